"""The benchmark slab of Niederer et al. 2011 (doi 10.1098/rsta.2011.0139) on its coarsest mesh, launched like a user would."""

import os
import shlex
import subprocess
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

BIN = Path(os.environ["HEARTBUS_BIN"])
SCENE = Path(os.environ["HEARTBUS_SOURCE"]) / "configs/benchmarks/niederer2011/slab.yaml"
COARSE = ["--ranks", "1", "--set", "geometry.slab.cell=0.5 mm", "--set", "time.end=65 ms", "--set", "output.every=65 ms"]


def activation(folder, point):
    """Activation time [ms] of the node at a point [mm]."""
    datasets = []
    with h5py.File(Path(folder) / "fields/activation.h5") as file:
        file.visititems(lambda name, item: datasets.append((name, item[()])) if isinstance(item, h5py.Dataset) else None)
    points = next(values for _, values in datasets if values.ndim == 2 and values.shape[1] == 3 and values.dtype.kind == "f")
    times = next(values for name, values in datasets if "activation_time" in name).ravel()
    return 1e3 * times[np.argmin(np.sum((1e3 * points - point) ** 2, axis=1))]


class Niederer2011(unittest.TestCase):
    def test_wave_reaches_the_corners_when_it_did(self):
        with tempfile.TemporaryDirectory() as folder:
            arguments = [BIN / "coupler", SCENE, *COARSE, "--out", folder]
            line = subprocess.run([*arguments, "--launch-line"], check=True, capture_output=True, text=True).stdout
            subprocess.run(["mpirun", *shlex.split(line)], check=True, timeout=300, stdout=subprocess.DEVNULL)
            # By this program, 0.5 mm, 0.05 ms. With 0.2 mm the last corner is reached at 44.1 ms; the eleven codes: 44.9 +- 3.2.
            for point, expected in (((20, 0, 0), 32.9), ((0, 7, 0), 48.0), ((20, 7, 3), 61.7)):
                self.assertAlmostEqual(activation(folder, point), expected, delta=0.3)


if __name__ == "__main__":
    unittest.main()
