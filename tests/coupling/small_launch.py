"""The smallest launches: of stand-ins, in a folder of their own."""
import sys
import tempfile
import time
import unittest
from pathlib import Path

from launch import SOURCE, Launch, wait_for

LAUNCH = [sys.executable, SOURCE / "tools/launch.py"]
WITHOUT_REPORT = [sys.executable, SOURCE / "tools/check.py", "--launch"]
SMALL = """
scene: small
time: {end: 20 s, step: 0.2 ms}
coupling: {scheme: one_way, deadline: 30 s}
participants: {ep: {ranks: 2}}
geometry: {mesh: MXS}
electrophysiology: {refinements: 1}
output: {every: 0 ms}
"""
STAND_IN = "{program: stand_in, ranks: %d, settings: {mischief: none, step: 0, delay: 0.002}}"
NO_PHYSICS = SMALL.replace("{ranks: 2}", STAND_IN % 2)  # the same in no time


class Case(unittest.TestCase):
    text = NO_PHYSICS
    command = LAUNCH

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        (self.folder / "scene.yaml").write_text(self.text)
        self.history = self.folder / "results/small/history.csv"

    def is_running(self):
        return self.history.exists() and self.history.read_text().count("\n") > 5

    def launch(self, *words, during=None):
        return Launch([*self.command, *words], self.folder, during)

    def meanwhile(self, action, *words, scene="scene.yaml"):
        """A run, and what is done to it once it is under way."""
        def during(launcher):
            wait_for(self.is_running)
            action(launcher)
            self.since = time.monotonic()
        launch = self.launch(scene, *words, during=during)
        self.seconds = time.monotonic() - self.since
        self.assertEqual(launch.orphans, [])
        return launch

    def assert_causes(self, launch, code, *patterns):
        causes = [line for line in launch.output.splitlines() if line.startswith("heartbus: ")]
        self.assertEqual(launch.code, code, launch.output)
        self.assertEqual(len(causes), len(patterns), launch.output)
        for cause, pattern in zip(causes, patterns):
            self.assertRegex(cause, pattern)
