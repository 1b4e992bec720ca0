"""Electrophysiology that runs ahead of the others changes no bit of what comes out."""
import tempfile
import unittest
from pathlib import Path

from launch import SOURCE, run_scene

STAND_IN = "{program: stand_in, ranks: 1, settings: {mischief: none, step: 0, delay: 0}}"
SCENE = f"""
base: {SOURCE}/tests/regression/small_heartbeat.yaml
participants: {{ep: {{ranks: 1}}, mech: {{ranks: 1}}, ale: {STAND_IN}, fluid: {STAND_IN}}}
time: {{end: 9 ms}}
output: {{checkpoint: {{every: 4 ms, keep: 9}}}}
"""


class Lookahead(unittest.TestCase):
    """Of the wall's history: blood and lifting, whom the calcium does not reach, are stand-ins."""

    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = Path(temporary.name)
        (cls.folder / "scene.yaml").write_text(SCENE)
        cls.with_steps = {n: cls.history(f"out{n}", n) for n in (0, 1, 100)}
        cls.with_steps[3] = cls.history("out3", 3, "--record", "calcium=calcium.h5")

    @classmethod
    def history(cls, out, n, *arguments):
        launch = run_scene("scene.yaml", cls.folder, "--out", out, "--set", f"lookahead={n}", *arguments)
        assert launch.code == 0, launch.output
        return (cls.folder / out / "history.csv").read_bytes()

    def test_histories_are_the_same_with_and_without(self):
        self.assertEqual(len(set(self.with_steps.values())), 1)

    def test_so_are_those_of_a_recording_that_is_replayed(self):
        replay = ["--set", "participants.ep.program=replay", "--set", "participants.ep.settings.file=calcium.h5"]
        self.assertEqual(self.history("replayed0", 0, *replay), self.history("replayed3", 3, *replay))

    def test_a_run_that_is_interrupted_goes_on_with_the_same_bits(self):
        self.assertEqual(self.with_steps[3], self.history("out3", 3, "--restart", "4 ms"))


if __name__ == "__main__":
    unittest.main(verbosity=2)
