"""The benchmark slab of Niederer et al. 2011 (doi 10.1098/rsta.2011.0139), launched like a user would."""

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

# Points [mm] and the activation times [ms] of eleven codes there, mean and standard deviation, with cells of 0.2 mm and
# steps of 0.01 ms (supplement of the paper).
ELEVEN_CODES = {
    (20, 0, 0): (34.43, 1.48), (0, 0, 3): (11.29, 1.60), (20, 0, 3): (36.67, 2.98), (0, 7, 0): (38.56, 5.00),
    (20, 7, 0): (52.56, 7.10), (0, 7, 3): (40.52, 6.08), (20, 7, 3): (53.81, 8.17), (10, 3.5, 1.5): (24.58, 3.76),
}
# The same with cells of 0.1 mm. Codes with lumped mass are late on coarser cells; a consistent mass is hardly, so that the
# wave should arrive between the two. Along the fibres (20, 0, 0) no wave from the edge of the stimulus, 1.5 mm, is faster
# than the converged one of a cable, 0.612 m/s: 30.2 ms.
FINER = {
    (0, 0, 3): (8.95, 0.56), (20, 0, 3): (33.70, 1.00), (0, 7, 0): (29.76, 1.65), (20, 7, 0): (43.97, 2.83),
    (0, 7, 3): (31.32, 2.12), (20, 7, 3): (44.93, 3.22), (10, 3.5, 1.5): (20.50, 1.30), (20, 0, 0): (30.2, 0),
}


def activation(folder, point):
    """Activation time [ms] of the node at a point [mm]."""
    with h5py.File(Path(folder) / "fields/activation.h5") as file:
        points, times = file["mesh/points"][:], file["000000/activation_time"][:].ravel()
    return 1e3 * times[np.argmin(np.sum((1e3 * points - point) ** 2, axis=1))]


class Niederer2011(unittest.TestCase):
    def run_slab(self, *settings):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        words = [word for setting in settings for word in ("--set", setting)]
        arguments = [BIN / "coupler", SCENE, *words, "--out", temporary.name]
        line = subprocess.run([*arguments, "--launch-line"], check=True, capture_output=True, text=True).stdout
        subprocess.run(["mpirun", "--oversubscribe", *shlex.split(line)], check=True, timeout=600, stdout=subprocess.DEVNULL)
        return temporary.name

    def test_wave_arrives_between_eleven_codes_at_the_same_spacing_and_at_half_of_it(self):
        folder = self.run_slab("geometry.slab.cell=0.2 mm", "time.step=0.1 ms", "time.end=48 ms", "output.every=48 ms")
        for point, (mean, deviation) in ELEVEN_CODES.items():
            finer, finer_deviation = FINER[point]
            self.assertLessEqual(activation(folder, point), mean + 2 * deviation, msg=f"at {point} mm")
            self.assertGreaterEqual(activation(folder, point), finer - 2 * finer_deviation, msg=f"at {point} mm")

    def test_wave_reaches_the_corners_when_it_did(self):
        # By this program, 0.5 mm. With 0.01 ms the midpoint rule gives 32.3, 48.0 and 61.7.
        for settings, expected in CORNERS.items():
            folder = self.run_slab("ep.ranks=1", "geometry.slab.cell=0.5 mm", "time.end=65 ms", "output.every=65 ms", *settings)
            for point, time in expected.items():
                self.assertAlmostEqual(activation(folder, point), time, delta=0.3, msg=f"{settings} at {point} mm")


# By settings: point [mm] and time [ms].
CORNERS = {
    ("integrator=imex_euler", "substeps=1"): {(20, 0, 0): 32.9, (0, 7, 0): 48.0, (20, 7, 3): 61.7},
    ("time.step=0.1 ms",): {(20, 0, 0): 32.5, (0, 7, 0): 48.2, (20, 7, 3): 62.0},
}


if __name__ == "__main__":
    unittest.main()
