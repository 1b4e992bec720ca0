"""Electrophysiology by a front of given speed, or at prescribed times: whole programs, launched."""
import csv
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np
from launch import SOURCE, run_scene

SCENE = SOURCE / "configs/ideal_lv/eikonal.yaml"
SETTINGS = ["mesh=MXS", "electrophysiology.refinements=1", "time.end=60 ms", "output.every=20 ms", "checkpoint.every=20 ms"]


class Activation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = Path(temporary.name)
        cls.launch("front", "ranks=1")

    @classmethod
    def launch(cls, out, *settings, restart=()):
        words = [word for setting in [*SETTINGS, *(s for s in settings if s != "ranks=1")] for word in ("--set", setting)]
        run = run_scene(SCENE, cls.folder, "--out", out, "--ranks", "1" if "ranks=1" in settings else "2", *words, *restart)
        assert run.code == 0, run.output
        return run

    def history(self, out):
        with open(self.folder / out / "history.csv", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def fields(self, out, name):
        with h5py.File(self.folder / out / "fields" / name) as file:
            order = np.lexsort(np.round(file["mesh/points"][:], 9).T)
            return {instant + "/" + field: file[instant][field][:].ravel()[order]
                    for instant in file if instant != "mesh" for field in file[instant]}

    def test_the_front_makes_the_ventricle_contract(self):
        last = self.history("front")[-1]
        self.assertGreater(float(last["mean_pressure [Pa]"]), 3000)
        activation = self.fields("front", "activation.h5")["000000/activation_time"]
        self.assertAlmostEqual(activation.min(), 2e-3, delta=1e-3)
        self.assertGreater(activation.max(), 50e-3)
        electric = self.fields("front", "ep.h5")
        active = activation < 20e-3
        self.assertEqual(set(electric), {f"{k:06d}/{name}" for k in range(4) for name in ("potential", "calcium")})
        self.assertTrue((electric["000001/potential"][active] > -0.02).all())
        self.assertTrue((electric["000001/potential"][activation > 21e-3] < -0.02).all())
        early = activation < 10e-3
        self.assertTrue((electric["000001/calcium"][early] > 2 * electric["000000/calcium"][early]).all())

    def test_other_ranks_give_the_same(self):
        self.launch("two")
        for name in ("activation.h5", "ep.h5"):
            one, two = self.fields("front", name), self.fields("two", name)
            for field, values in one.items():
                np.testing.assert_allclose(values, two[field], atol=1e-6 * np.ptp(values), err_msg=field)
        for ours, theirs in zip(self.history("front"), self.history("two")):
            self.assertAlmostEqual(float(ours["mean_pressure [Pa]"]), float(theirs["mean_pressure [Pa]"]), delta=0.05)

    def test_a_restart_gives_the_same_bits(self):
        history, fields = self.history("front"), self.fields("front", "ep.h5")
        self.launch("front", "ranks=1", restart=("--restart", "40 ms"))
        self.assertEqual(self.history("front"), history)
        for field, values in self.fields("front", "ep.h5").items():
            np.testing.assert_array_equal(values, fields[field], field)

    def test_times_of_another_run_give_the_same_beat(self):
        self.launch("again", "ranks=1", "electrophysiology.model=prescribed",
                    f"prescribed.activation={self.folder}/front/fields/activation.h5")
        self.assertEqual(self.history("again"), self.history("front"))


if __name__ == "__main__":
    unittest.main(verbosity=2)
