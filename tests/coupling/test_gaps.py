"""tools/gaps: when nobody works, from a trace."""
import json
import os
import subprocess
import tempfile
import unittest

GAPS = os.path.join(os.environ.get("HEARTBUS_SOURCE", "."), "tools", "gaps")


def name(participant, process):
    return {"ph": "M", "name": "process_name", "pid": process, "tid": 0, "args": {"name": participant}}


def slice_of(process, what, begin, end, step):
    return {"ph": "X", "name": what, "pid": process, "tid": 0, "ts": begin, "dur": end - begin, "args": {"step": step}}


def one_step(step, begin):
    """1000 us: a works from 0 to 400, b from 450 to 900 and, beside it, a again; the rest is bus and waiting."""
    return [slice_of(0, "solve", begin, begin + 400, step), slice_of(0, "send x", begin + 400, begin + 420, step),
            slice_of(0, "notify b", begin + 420, begin + 425, step), slice_of(1, "wait a", begin + 400, begin + 440, step),
            slice_of(1, "receive x", begin - 80, begin + 440, step), slice_of(1, "solve", begin + 450, begin + 900, step),
            slice_of(0, "commit", begin + 460, begin + 500, step), slice_of(2, "step", begin, begin + 1000, step)]


class Gaps(unittest.TestCase):
    def gaps(self, events):
        with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
            json.dump({"traceEvents": events}, file)
            file.flush()
            return subprocess.run([GAPS, file.name], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def test_tells_handovers_within_steps_from_turns_between_them(self):
        names = [name("a", 0), name("b", 1), name("coupler", 2)]
        # The first step does not count; after the 20th the next one begins 300 us later.
        steps = [event for step in range(1, 23) for event in one_step(step, 1000 * step + (300 if step > 20 else 0))]
        run = self.gaps(names + steps)
        self.assertEqual(run.returncode, 0, run.stderr)
        lines = [line.split() for line in run.stdout.splitlines()]
        self.assertEqual(lines[0][0], "21")  # steps 2 to 22
        microseconds = [float(line[line.index("us") - 1]) for line in lines[1:]]
        within, turns, after_20th, total = microseconds
        self.assertEqual(within, 50.0)  # from the end of a to the begin of b
        self.assertAlmostEqual(turns, 100 * 19 / 21, delta=0.06)
        self.assertAlmostEqual(after_20th, 400 / 21, delta=0.06)
        self.assertAlmostEqual(total, within + turns + after_20th, delta=0.11)

    def test_a_file_that_is_no_trace_is_refused(self):
        run = subprocess.run([GAPS, __file__], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.assertEqual(run.returncode, 1)
        self.assertIn("not a trace of a run", run.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
