"""Wall and lifting of another code, DOLFINx, on the same meshes in the same run: the same results as those of our own."""
import csv
import importlib.util
import shutil
import sys
import tempfile
import unittest
from pathlib import Path

from launch import BIN, SOURCE, Launch, use_library

EXAMPLES = SOURCE / "examples/dolfinx"
SCENE = """\
base: {source}/configs/ideal_lv/efs1.yaml
scene: by_two_codes
geometry: {{mesh: MXS}}
fibres: {{rule: ellipsoid}}
time: {{end: 20 ms}}
mechanics: {{solver: {{residual_tolerance: 1e-10, update_tolerance: 1e-9}}}}
lifting: {{tolerance: 1e-12}}
fluid: {{tolerance: 1e-11}}
electrophysiology:                        # the wall contracts within the first milliseconds
  refinements: 0
  stimulus: {{sites: [{{centre: [0 mm, 0 mm, -20 mm], radius: 200 mm}}]}}
output: {{every: 0 ms, checkpoint: {{every: 12 ms}}}}
"""
MECHANICS = f"participants.mech.command={sys.executable} {EXAMPLES}/mechanics.py"
LIFTING = f"participants.ale.command={sys.executable} {EXAMPLES}/lifting.py"


@unittest.skipUnless(importlib.util.find_spec("dolfinx"), "DOLFINx is not installed (python3-dolfinx)")
class TwoCodes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        use_library()
        cls.folder = Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        (cls.folder / "scene.yaml").write_text(SCENE.format(source=SOURCE))
        mesh = Launch([BIN / "coupler", "scene.yaml", "--write-mesh", "ventricle.h5"], cls.folder)
        assert mesh.code == 0, mesh.output
        cls.ours = cls.history("ours")

    @classmethod
    def history(cls, name, *words):
        run = Launch([sys.executable, SOURCE / "tools/check.py", "--launch", "scene.yaml", "--oversubscribe", "--ranks", "1",
                      "--out", name, *words], cls.folder)
        assert run.code == 0, run.output
        with open(cls.folder / name / "history.csv", encoding="utf-8") as file:
            return {title.split(" ")[0]: column for title, *column in zip(*csv.reader(file))}

    def compare(self, theirs, share):
        """Volume and pressure within a share of their range; it has to be a range worth the name."""
        for name, least in (("volume", 0.1e-6), ("mean_pressure", 400.)):
            one, two = ([float(value) for value in run[name]] for run in (self.ours, theirs))
            extent = max(one) - min(one)
            self.assertGreater(extent, least)
            self.assertEqual(len(one), len(two))
            self.assertLess(max(abs(a - b) for a, b in zip(one, two)), share * extent, name)

    def test_mechanics(self):
        theirs = self.history("mechanics", "--set", MECHANICS)
        self.compare(theirs, 1e-6)
        again = self.history("mechanics", "--set", MECHANICS, "--restart", "12 ms")
        self.assertEqual(theirs["mean_pressure"], again["mean_pressure"])

    def test_a_missing_mesh_is_said(self):
        run = Launch([sys.executable, SOURCE / "tools/check.py", "--launch", "scene.yaml", "--oversubscribe", "--ranks", "1",
                      "--out", "missing", "--set", LIFTING, "--set", "participants.ale.settings.mesh=no.h5"], self.folder)
        self.assertEqual(run.code, 8, run.output)
        self.assertIn("ale (rank 0): there is no no.h5: coupler SCENE --write-mesh no.h5 makes it", run.output)

    def test_lifting(self):
        self.compare(self.history("lifting", "--set", LIFTING), 1e-6)

    def test_both_on_two_ranks(self):
        ranks = [word for name in ("mech", "ale") for word in ("--set", f"participants.{name}.ranks=2")]
        self.compare(self.history("both", "--set", MECHANICS, "--set", LIFTING, *ranks), 1e-6)


if __name__ == "__main__":
    unittest.main(verbosity=2)
