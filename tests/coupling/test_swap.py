"""One physics code for another: a part of the matrix of tests/swap, in which each electrophysiology, blood and wall stands."""
import importlib.util
import sys
import tempfile
import unittest

from launch import SOURCE

sys.path.insert(0, str(SOURCE / "tests/swap"))
import matrix  # noqa: E402


class Swap(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = temporary.name
        matrix.prepare(cls.folder)

    def run_all(self, *combinations):
        runs = [matrix.Combination(self.folder, *parts) for parts in combinations]
        for run in runs:
            with self.subTest(run=run.parts):
                self.assertEqual(run.code, 0, run.output)
                self.assertGreater(run.pressure[-1] - run.pressure[0], 100)
        return runs

    def test_each_electrophysiology(self):
        runs = self.run_all(*((name, "0D", "ours") for name in matrix.ELECTROPHYSIOLOGIES))
        played = next(run for run in runs if run.parts[0] == "replay")
        computed = next(run for run in runs if run.parts[0] == "ttp06")
        self.assertLess(computed.differs(played), 1e-9)

    def test_blood_in_python(self):
        ours, theirs = self.run_all(("eikonal", "0D", "ours"), ("eikonal", "0D in Python", "ours"))
        self.assertLess(ours.differs(theirs), matrix.limit(ours, theirs))

    @unittest.skipUnless(importlib.util.find_spec("dolfinx"), "DOLFINx is not installed (python3-dolfinx)")
    def test_walls_and_lifting_in_dolfinx(self):
        for blood, other in (("3D", "3D, DOLFINx lifting"), ("0D", "0D in Python")):
            ours, theirs = self.run_all(("eikonal", blood, "ours"), ("eikonal", other, "DOLFINx"))
            self.assertLess(ours.differs(theirs), matrix.limit(ours, theirs))


if __name__ == "__main__":
    unittest.main(verbosity=2)
