"""Electrophysiology that runs ahead of the others changes no bit of what comes out."""
import tempfile
import unittest
from pathlib import Path

from launch import SOURCE, run_scene

SCENE = SOURCE / "tests/regression/small_heartbeat.yaml"


class Lookahead(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def history(self, out, *arguments):
        launch = run_scene(SCENE, self.folder, "--set", "time.end=9 ms", "--set", "checkpoint.every=4 ms", "--set",
                           "checkpoint.keep=9", "--ranks", "1", "--out", out, *arguments)
        self.assertEqual(launch.code, 0, launch.output)
        return (self.folder / out / "history.csv").read_bytes()

    def test_histories_are_the_same_with_and_without(self):
        with_steps = [self.history(f"out{n}", "--set", f"lookahead={n}") for n in (0, 1, 3, 100)]
        self.assertEqual(len(set(with_steps)), 1)

    def test_so_are_those_of_a_recording_that_is_replayed(self):
        replay = ["--set", "participants.ep.program=replay", "--set", f"participants.ep.settings.file={self.folder}/calcium.h5"]
        self.history("recorded", "--record", f"calcium={self.folder}/calcium.h5", "--set", "lookahead=3")
        self.assertEqual(self.history("out0", *replay), self.history("out3", *replay, "--set", "lookahead=3"))

    def test_a_run_that_is_interrupted_goes_on_with_the_same_bits(self):
        whole = self.history("whole", "--set", "lookahead=3")
        self.history("parts", "--set", "lookahead=3")
        self.assertEqual(whole, self.history("parts", "--set", "lookahead=3", "--restart", "4 ms"))


if __name__ == "__main__":
    unittest.main(verbosity=2)
