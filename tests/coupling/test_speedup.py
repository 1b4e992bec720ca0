"""tools/speedup: steps and speeds of the cores from traces, and steps at equal speed."""
import importlib.machinery
import importlib.util
import os
import subprocess
import sys
import unittest

TOOLS = os.path.join(os.environ.get("HEARTBUS_SOURCE", "."), "tools")
sys.path.insert(0, TOOLS)
loader = importlib.machinery.SourceFileLoader("speedup", os.path.join(TOOLS, "speedup"))
speedup = importlib.util.module_from_spec(importlib.util.spec_from_loader("speedup", loader))
sys.dont_write_bytecode = True
loader.exec_module(speedup)


def ionic_model(rank, step, begin_ms, ms):
    return {"ph": "X", "name": "ionic model", "pid": 1, "tid": rank, "ts": 1e3 * begin_ms, "dur": 1e3 * ms, "args": {"step": step}}


def other(step):
    return {"ph": "X", "name": "assembly", "pid": 1, "tid": 0, "ts": 0, "dur": 7, "args": {"step": step}}


class Speedup(unittest.TestCase):
    def test_a_step_lasts_from_one_ionic_model_to_the_next(self):
        first = speedup.FIRST
        events = [event for step in range(1, first + 3) for event in (
            ionic_model(0, step, 50 * step + step * step, 4), ionic_model(1, step, 50 * step + step * step + 1, 6), other(step))]
        steps = speedup.steps(events, 2)
        self.assertEqual(len(steps), 2)  # of the last one the end is unknown
        for k, (time, cells) in enumerate(steps):
            self.assertAlmostEqual(time, 50 + 2 * (first + k) + 1)
            self.assertEqual(cells, [8, 12])  # as if each rank had all cells

    def test_steps_are_compared_at_equal_speed_of_all_cores(self):
        fast, slow = 8.0, 12.0
        found = {1: [(60, [fast]), (80, [slow])],
                 2: [(32, [fast, 1.03 * fast]), (45, [fast, slow]), (46, [slow, fast]), (43, [slow, slow])]}
        fastest, classes = speedup.by_speed(found)
        self.assertEqual(fastest, fast)
        self.assertEqual(sorted(classes[1].values()), [[60], [80]])
        self.assertEqual(sorted(classes[2].values()), [[32], [43]])
        self.assertEqual(classes[1].keys(), classes[2].keys())

    def test_one_rank_is_not_compared_with_itself(self):
        run = subprocess.run([loader.path, "scene.yaml", "--ranks", "1"], stderr=subprocess.PIPE, text=True)
        self.assertEqual(run.returncode, 2)
        self.assertIn("give 2 or more", run.stderr)

    def test_without_ionic_model_there_are_no_steps(self):
        self.assertEqual(speedup.steps([other(step) for step in range(1, 50)], 2), [])


if __name__ == "__main__":
    unittest.main(verbosity=2)
