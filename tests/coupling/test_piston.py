"""The piston: what the coupling loses and when it becomes unstable, against closed forms.

An elastic column is pushed from its far end against a closed box of blood. The closed forms need the column's own
matrices only: linear elements with consistent mass, springs and dampers at the far end.
"""
import csv
import math
import tempfile
import unittest
from pathlib import Path

import numpy as np
from launch import SOURCE, run_scene

SCENE = SOURCE / "configs/benchmarks/piston/efs1.yaml"
STEP, LENGTH, CELLS, AREA = 2e-4, 10e-3, 3, 1e-4
DENSITY, MODULUS, SPRING, DAMPER = 1000.0, 66e3, 10e3, 20e3


def column():
    """Mass, damping and stiffness per area of the column; node 0 is the interface."""
    n, h = CELLS + 1, LENGTH / CELLS
    M, C, K = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    for e in range(CELLS):
        M[e : e + 2, e : e + 2] += DENSITY * h / 6 * np.array([[2, 1], [1, 2]])
        K[e : e + 2, e : e + 2] += MODULUS / h * np.array([[1, -1], [-1, 1]])
    K[-1, -1] += SPRING
    C[-1, -1] += DAMPER
    return M, C, K


def efs1_limit():
    """The alpha at which the mode of amplification -1 neither grows nor decays in a closed cavity."""
    M, C, K = column()
    return STEP / np.linalg.inv(4 * M / STEP**2 + 2 * C / STEP + K)[0, 0]


def run(folder, *settings):
    arguments = [word for setting in settings for word in ("--set", setting)]
    launch = run_scene(SCENE, folder, "--out", "out", *arguments)
    with open(Path(folder) / "out/history.csv") as file:
        rows = list(csv.DictReader(file))
    return launch, {key: np.array([float(row[key]) for row in rows]) for key in rows[0] if key != "phase"}


def growth_per_step(alpha, scheme=()):
    """Amplification per step of the part of the volume defect that alternates from step to step, after a sudden push."""
    with tempfile.TemporaryDirectory() as folder:
        launch, history = run(folder, f"alpha={alpha} kg/(m^2 s)", "end_pressure.ramp=0.2 ms",
                              "end_pressure.final=1 Pa", "time.end=40 ms", *scheme)
    assert launch.code == 0, launch.output
    defect = history["volume_defect [m^3/s]"]
    alternating = np.abs(np.diff(defect, 8))[-120:]  # each difference doubles what alternates, and shrinks what is smooth
    return math.exp(np.polyfit(np.arange(alternating.size), np.log(alternating), 1)[0])


def measured_limit(prediction, scheme=()):
    """Where the growth factor crosses 1, by linear interpolation between runs below and above the prediction."""
    alphas = np.array([0.98, 0.99, 1.005, 1.01]) * prediction
    growth = np.array([math.log(growth_per_step(alpha, scheme)) for alpha in alphas])
    print("alpha", alphas, "log growth per step", growth)
    above = int(np.argmax(growth > 0))
    assert above > 0, f"the growth factor does not cross 1 near {prediction}: {growth}"
    slope = (growth[above] - growth[above - 1]) / (alphas[above] - alphas[above - 1])
    return alphas[above] - growth[above] / slope


class Piston(unittest.TestCase):
    def test_wall_drifts_by_step_times_pressure_over_alpha(self):
        with tempfile.TemporaryDirectory() as folder:
            launch, history = run(folder)
        self.assertEqual(launch.code, 0, launch.output)
        drift = (history["volume [m^3]"][0] - history["volume [m^3]"][-1]) / AREA
        pressure = history["mean_pressure [Pa]"][-1]
        self.assertAlmostEqual(drift / (STEP * pressure / 5000), 1, delta=0.03)
        # The push arrives but for what the far spring takes.
        self.assertGreater(pressure, 0.9 * 500)
        self.assertLess(pressure, 500)

    def test_EFS1_becomes_unstable_where_the_column_says(self):
        limit = efs1_limit()
        self.assertAlmostEqual(measured_limit(limit) / limit, 1, delta=0.03)


if __name__ == "__main__":
    unittest.main(verbosity=2)
