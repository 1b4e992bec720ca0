"""Arteries behind the aortic valve of 3D blood: their pressure is what came in and what left, also after a restart."""
import csv
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SOURCE = Path(os.environ["HEARTBUS_SOURCE"])
C, R = 1.5e-8, 1.2e8  # of configs/ideal_lv/windkessel.yaml
STEP = 0.4e-3


class Arteries(unittest.TestCase):
    def test_their_pressure_is_the_blood_they_hold(self):
        with tempfile.TemporaryDirectory() as folder:
            text = self.run_scene(folder)
            rows = [{title.split(" ")[0]: value if title == "phase" else float(value) for title, value in row.items()}
                    for row in csv.DictReader(text.splitlines())]
            ejected = [row for row in rows if row["phase"] == "ejection"]
            self.assertGreater(len(ejected), 50)
            for before, row in zip(rows, rows[1:]):
                p_n, p = before["arterial_pressure"], row["arterial_pressure"]
                change = STEP * (row["aortic_flow"] - p / R)
                self.assertAlmostEqual(C * (p - p_n), change, delta=1e-9 * C * p)
            self.assertGreater(ejected[-1]["arterial_pressure"], ejected[0]["arterial_pressure"] + 1000)
            # the valve opens against the arteries of this moment, not against the 9 kPa of the start
            last = rows[rows.index(ejected[0]) - 1]
            self.assertLess(last["arterial_pressure"], 8990)
            self.assertLess(last["mean_pressure"], 9000)
            self.assertEqual(self.run_scene(folder, "--restart", "120 ms").splitlines(), text.splitlines())

    def run_scene(self, folder, *words):
        command = [sys.executable, SOURCE / "tools/launch.py", SOURCE / "configs/ideal_lv/windkessel.yaml", "--oversubscribe",
                   "--ranks", "1", "--out", "run", *words]
        for value in ("mesh=MXS", "refinements=1", "time.beats=0", "time.until_periodic=0", "time.end=0.16 s",
                      f"time.step={1e3 * STEP} ms", "output.every=0 s", "checkpoint.every=40 ms", "checkpoint.keep=9",
                      "electrophysiology.stimulus.sites=[{centre: [0 mm, 0 mm, -20 mm], radius: 200 mm}]"):
            command += ["--set", value]
        run = subprocess.run([str(word) for word in command], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                             text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stdout)
        return (Path(folder) / "run/history.csv").read_text(encoding="utf-8")


if __name__ == "__main__":
    unittest.main(verbosity=2)
