"""A run that is killed whenever it may be, also while it saves: it restarts each time."""
import json
import os
import random
import signal
import tempfile
import time
import unittest
from pathlib import Path

from casts import PISTON, settings_words
from launch import Launch, launch_words, wait_for
from trial import is_json

# Saves at each step at which it may, every twentieth.
SCENE = f"""
base: {PISTON}
participants:  # two have a state to save
  ale: {{program: stand_in, settings: {{mischief: none, step: 0, delay: 0}}}}
"""
SETTINGS = ["checkpoint.every=4 ms", "checkpoint.keep=2"]
N_KILLS = 20


class Kills(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        self.sets = self.folder / "out/checkpoints"
        (self.folder / "scene.yaml").write_text(SCENE)

    def launch(self, *words, end, during=None):
        settings = settings_words([*SETTINGS, f"time.end={end} ms"])
        return Launch(launch_words("scene.yaml", self.folder, "--out", "out", *settings, *words), self.folder, during)

    def times(self):
        return [json.loads(path.read_text())["time"] for path in self.sets.glob("*/manifest.json") if is_json(path)]

    def kill_while_it_saves(self, process, delay):
        """Some milliseconds after a set has begun to be written, or after all: a moment anywhere in it."""
        known = set(os.listdir(self.sets)) if self.sets.exists() else set()

        def saves():
            new = [name for name in os.listdir(self.sets) if name not in known and name.endswith(".part")] if self.sets.exists() else []
            self.saved_step = int(new[0][:6]) if new else 0
            return self.saved_step

        wait_for(saves, pause=0.0005)
        time.sleep(delay)
        ranks = [int(pid) for pid in Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()]
        for pid in [process.pid, *ranks]:
            os.kill(pid, signal.SIGKILL)
        wait_for(lambda: not any(os.path.exists(f"/proc/{pid}/exe") for pid in ranks), 20)

    def test_a_run_that_is_killed_at_twenty_random_moments_while_it_saves_restarts_each_time(self):
        seed = random.randrange(10**6)
        moments, parts, before = random.Random(seed), 0, 0.
        latest = 0.004  # [s] after a set has begun; becomes about twice what one takes, so that half of the kills fall within it
        for n in range(N_KILLS):
            words = ["--restart", "latest"] if n else []
            delay = moments.uniform(0, latest)
            launch = self.launch(*words, end=90000, during=lambda process, d=delay: self.kill_while_it_saves(process, d))
            self.assertGreater(self.saved_step * 0.2e-3, before, f"seed {seed}, kill {n} has not gone on: {launch.output}")
            self.assertEqual(launch.orphans, [])
            if n == 0:
                self.launch(end=4)  # whatever was killed: from here on there is one complete set
            is_within = any(path.suffix == ".part" for path in self.sets.iterdir())
            parts += is_within
            latest *= 1.4 if is_within else 0.7
            self.assertGreaterEqual(max(self.times()), before, f"seed {seed}, kill {n}")
            before = max(self.times())
        print(f"seed {seed}: {parts} of {N_KILLS} kills left a set that was being written; t = {1e3 * before:g} ms")
        self.assertGreater(parts, N_KILLS / 4)
        launch = self.launch("--restart", "latest", end=round(1e3 * before) + 4)
        self.assertEqual(launch.code, 0, launch.output)


if __name__ == "__main__":
    unittest.main(verbosity=2)
