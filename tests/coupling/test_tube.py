"""The pressure pulse in an elastic tube: its speed, and who is stable where blood is as heavy as the wall it moves."""
import csv
import math
import subprocess
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np
from launch import BIN, SOURCE, run_scene

SCENES = SOURCE / "configs/benchmarks/tube"
LENGTH, RADIUS, OUTER, MODULUS, POISSON, BLOOD = 50e-3, 5e-3, 6e-3, 3e5, 0.3, 1000.0


def wave_speed():
    """Of long waves: c^2 = A / (rho dA/dp), the area A of a thick tube that keeps its length (Lame)."""
    compliance = (2 * (1 + POISSON) / MODULUS * ((1 - 2 * POISSON) * RADIUS**2 + OUTER**2) / (OUTER**2 - RADIUS**2))
    return 1 / math.sqrt(BLOOD * compliance)


class Run:
    """A launch of a scene: exit code, output, history, and the pressure over time and length."""

    def __init__(self, scene, *settings):
        arguments = [word for setting in settings for word in ("--set", setting)]
        with tempfile.TemporaryDirectory() as folder:
            check = subprocess.run([BIN / "coupler", SCENES / scene, "--validate", *arguments], capture_output=True, text=True)
            if check.returncode:
                self.code, self.output = check.returncode, check.stderr
                return
            launch = run_scene(SCENES / scene, folder, "--out", "out", *arguments)
            self.code, self.output = launch.code, launch.output
            if self.code == 0:
                self.read(Path(folder) / "out")

    def read(self, results):
        with open(results / "history.csv") as file:
            rows = list(csv.DictReader(file))
        self.history = {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}
        with h5py.File(results / "fields/fluid.h5") as file:
            instants = [file[name] for name in sorted(file) if name != "mesh"]
            height = np.round(file["mesh/points"][:, 2], 9)
            self.times = np.array([instant.attrs["time"] for instant in instants])
            self.heights, sections = np.unique(height, return_inverse=True)
            self.pressure = np.array([np.bincount(sections, instant["pressure"][:, 0]) for instant in instants])
        self.pressure /= np.bincount(sections)

    def arrival(self, height):
        """When half of the largest pressure there has come."""
        pressure = self.pressure[:, np.argmin(abs(self.heights - height))]
        half = pressure.max() / 2
        n = int(np.argmax(pressure > half))
        return np.interp(half, pressure[n - 1 : n + 1], self.times[n - 1 : n + 1])

    def speed(self):
        heights = LENGTH * np.array([0.2, 0.4, 0.6, 0.8])
        return 1 / np.polyfit(heights, [self.arrival(z) for z in heights], 1)[0]


class Tube(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.loose, cls.merged = Run("pulse.yaml"), Run("pulse_e1fsinf.yaml")

    def test_pulse_travels_with_the_speed_of_long_waves(self):
        # Measured: 4 % slower (merged), 2 % slower (loose); closer on meshes that resolve the layer at the wall (README).
        for run in self.merged, self.loose:
            self.assertEqual(run.code, 0, run.output)
            self.assertAlmostEqual(run.speed() / wave_speed(), 1, delta=0.06)

    def test_EFS1_follows_the_merged_solution(self):
        # Measured: 4.8 % of the volume's range, 5.7 % of the pressure's.
        for key in "volume [m^3]", "mean_pressure [Pa]":
            loose, merged = self.loose.history[key], self.merged.history[key]
            self.assertLess(abs(loose - merged).max(), 0.08 * np.ptp(merged))

    def test_ranks_do_not_matter(self):
        tight = ["fluid.tolerance=1e-9", "lifting.tolerance=1e-9", "time.end=4 ms"]
        one, two = Run("pulse.yaml", *tight), Run("pulse.yaml", "mech.ranks=2", "ale.ranks=2", "fluid.ranks=2", *tight)
        self.assertEqual(two.code, 0, two.output)
        for key in "volume [m^3]", "mean_pressure [Pa]":
            a, b = one.history[key], two.history[key]
            self.assertLess(abs(a - b).max(), 1e-6 * np.ptp(a))

    def test_dirichlet_neumann_is_unstable_and_says_so(self):
        run = Run("pulse.yaml", "alpha=1e9 kg/(m^2 s)")
        self.assertEqual(run.code, 5)
        self.assertRegex(run.output, "the coupling is unstable: .* coupling.alpha is 1000000000 .* or 'alpha: auto'")

    def test_dirichlet_neumann_is_stable_for_a_wall_heavier_than_the_added_mass(self):
        run = Run("pulse.yaml", "alpha=1e9 kg/(m^2 s)", "mechanics.density=9e5 kg/m^3", "time.end=6 ms")
        self.assertEqual(run.code, 0, run.output)
        self.assertLess(run.history["datum_residual"][-20:].max(), 0.5)

    def test_an_inlet_that_is_not_there_is_refused(self):
        run = Run("pulse.yaml", "fluid.inlet.label=inlett")
        self.assertEqual(run.code, 2)
        self.assertRegex(run.output, r"no boundary label 'inlett'; did you mean 'inlet'\? It has .*inlet.*outlet")


if __name__ == "__main__":
    unittest.main(verbosity=2)
