"""Blood of one pressure: no volume is lost, and the program in Python does what ours does."""
import csv
import json
import sys
import tempfile
import unittest
from pathlib import Path

from launch import SOURCE, Launch, use_library

STEP = 0.2e-3  # [s]; what one step misses falls with its fourth power
SCENE = f"""\
base: {SOURCE}/configs/ideal_lv/circulation.yaml
scene: filling
geometry: {{mesh: MXS}}
time: {{end: 80 ms, step: {1e3 * STEP} ms}}
mechanics: {{active: {{tension_max: 1500 kPa}}}}
participants:
  ep: {{command: {sys.executable} {SOURCE}/examples/wave/wave.py, ranks: 1, settings: {{velocity: 4 m/s, peak: 2 uM}}}}
  mech: {{ranks: 1}}
output: {{every: 0 ms, checkpoint: {{every: 40 ms}}}}
"""
IN_PYTHON = f"participants.circulation.command={sys.executable} {SOURCE}/examples/circulation/circulation.py"


class Circulation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        use_library()
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = Path(temporary.name)
        cls.ours = cls.history("ours")

    @classmethod
    def history(cls, name, *words):
        scene = cls.folder / "scene.yaml"
        scene.write_text(SCENE)
        run = Launch([sys.executable, SOURCE / "tools/check.py", "--launch", scene, "--oversubscribe", "--out", name, *words],
                     cls.folder)
        assert run.code == 0, run.output
        with open(cls.folder / name / "history.csv") as file:
            return [{title.split(" ")[0]: value if title == "phase" else float(value) for title, value in row.items()}
                    for row in csv.DictReader(file)]

    def test_closed_valves_keep_the_volume_and_open_ones_pass_what_it_changes_by(self):
        phases = [row["phase"] for row in self.ours]
        self.assertEqual(phases[-1], "ejection")
        self.assertGreater(phases.count("isovolumetric contraction"), 10)
        for before, row in zip(self.ours, self.ours[1:]):
            self.assertLess(abs(row["volume_missed"]), 1e-10 * row["volume"])
            passed = STEP * (row["mitral_flow"] - row["aortic_flow"])
            self.assertAlmostEqual(row["volume"] - before["volume"], passed, delta=2e-10 * row["volume"])

    def test_the_pressure_is_that_of_the_wall_in_balance(self):
        self.assertAlmostEqual(self.ours[0]["mean_pressure"], 1333)
        self.assertGreater(self.ours[-1]["mean_pressure"], 9000)

    def test_python_gives_the_same(self):
        theirs = self.history("theirs", "--set", IN_PYTHON)
        for ours, other in zip(self.ours, theirs):
            for name in ("volume", "mean_pressure", "mitral_flow", "aortic_flow"):
                self.assertAlmostEqual(ours[name], other[name], delta=1e-9 * abs(ours[name]) + 1e-15, msg=name)

    def test_what_makes_no_sense_is_refused(self):
        for key, value in (("aortic_area", "-2 cm^2"), ("compliance", "-1e-8 m^3/Pa"), ("mitral_resistance", "0 kg/(s m^4)")):
            run = Launch([sys.executable, SOURCE / "tools/check.py", "--launch", SOURCE / "configs/ideal_lv/circulation.yaml",
                          "--oversubscribe", "--ranks", "1", "--set", "mesh=MXS", "--set", "time.end=2 ms", "--out", "refused",
                          "--set", f"participants.circulation.settings.{key}={value}"], self.folder)
            self.assertEqual(run.code, 2, run.output)
            self.assertIn(f"key 'participants.circulation.settings.{key}': must", run.output)

    def test_beats_against_arteries_approach_a_limit_cycle_by_half_each(self):
        words = ["mesh=MXS", "time.step=2 ms", "time.beats=6", "until_periodic=2 %", "output.every=0 ms", "checkpoint.every=0 ms"]
        run = Launch([sys.executable, SOURCE / "tools/check.py", "--launch", SOURCE / "configs/ideal_lv/eikonal.yaml",
                      "--oversubscribe", "--out", "beats", *(word for value in words for word in ("--set", value))], self.folder)
        self.assertEqual(run.code, 0, run.output)
        beats = json.loads((self.folder / "beats/indicators.json").read_text())["beats"]
        self.assertEqual(len(beats), 3)  # as docs/results.md has it of M0
        second, third = (beat["change_percent"] for beat in beats[1:])
        self.assertLess(max(third.values()), 2)
        for name in ("ESV", "p_max"):
            self.assertAlmostEqual(third[name] / second[name], 0.54, delta=0.06)
        self.assertLess(third["EDV"], 0.01)  # the atrium's pressure is constant

    def test_a_restart_gives_the_same_bits(self):
        again = self.history("ours", "--restart", "40 ms")
        self.assertEqual(again, self.ours)


if __name__ == "__main__":
    unittest.main(verbosity=2)
