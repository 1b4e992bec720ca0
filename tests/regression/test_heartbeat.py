"""A whole heartbeat on the smallest mesh: the phases, the indicators, and that the number of ranks does not matter. One on
the mesh M0, whose calcium is written down here and replayed, so that electrophysiology has no part in it.

When a change is meant to change the numbers, `HEARTBUS_DIGITS=write ./test -R regression/heartbeat` writes the table anew."""
import csv
import json
import os
import re
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "coupling"))
from launch import SOURCE, run_scene  # noqa: E402

# Indicators of the two heartbeats, which hold to a thousandth of themselves.
DIGITS = {
    "MXS": {"EF_percent": 48.346, "p_max_mmHg": 136.024, "EDV_mL": 107.169, "ESV_mL": 55.3572, "ILI_C_percent": 1.71358, "ILI_R_percent": 1.9235, "aortic_opens_ms": 67.2, "aortic_closes_ms": 292.8, "mitral_opens_ms": 388.8, "J_min": 0.654607, "wall_volume_min_percent": 91.0981},
    "M0": {"EF_percent": 47.3305, "p_max_mmHg": 127.323, "EDV_mL": 118.428, "ESV_mL": 62.3756, "ILI_C_percent": 5.36186, "ILI_R_percent": 5.16041, "aortic_opens_ms": 68.8, "aortic_closes_ms": 260.8, "mitral_opens_ms": 378.0, "J_min": 0.625243, "wall_volume_min_percent": 91.2838},
}
NEAR = 1e-3

SCENE = SOURCE / "tests/regression/small_heartbeat.yaml"
PHASES = ["isovolumetric contraction", "ejection", "isovolumetric relaxation", "filling"]
TIGHT = ["electrophysiology.tolerance=1e-12", "mechanics.solver.residual_tolerance=1e-12",
         "mechanics.solver.update_tolerance=1e-11", "mechanics.solver.linear_tolerance=1e-6",
         "lifting.tolerance=1e-12", "fluid.tolerance=1e-12"]
NAMES = ["EF_percent", "p_max_mmHg", "EDV_mL", "ESV_mL", "ILI_C_percent", "ILI_R_percent", "aortic_opens_ms",
         "aortic_closes_ms", "mitral_opens_ms", "J_min", "wall_volume_min_percent"]
# Counts of iterations depend on the partition, since the preconditioners do.
COUNTS = ("iterations", "residual")
ESTIMATE = 1e-4  # of alpha_limit: what its linear solves leave, which no other column depends on while alpha is fixed


def beat(folder, ranks):
    settings = [word for setting in TIGHT for word in ("--set", setting)]
    launch = run_scene(SCENE, folder, "--ranks", str(ranks), "--out", "out", *settings)
    assert launch.code == 0, launch.output
    with open(Path(folder) / "out/history.csv") as file:
        rows = list(csv.DictReader(file))
    return rows, json.loads((Path(folder) / "out/indicators.json").read_text())


def assert_digits(test, mesh, indicators):
    """The numbers of the table, or their renewal."""
    found = {name: float(f"{indicators[name]:.6g}") for name in NAMES}
    if os.environ.get("HEARTBUS_DIGITS") == "write":
        text, entry = Path(__file__).read_text(), ", ".join(f'"{name}": {value}' for name, value in found.items())
        Path(__file__).write_text(re.sub(rf'(\n    "{mesh}": ){{.*?}}', lambda old: f"{old[1]}{{{entry}}}", text, count=1))
        return
    for name in NAMES:
        test.assertAlmostEqual(found[name] / DIGITS[mesh][name], 1, delta=NEAR, msg=f"{name} on {mesh}: {found}")


class Heartbeat(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.rows, cls.indicators = {}, {}
        for ranks in (1, 2):
            with tempfile.TemporaryDirectory() as folder:
                cls.rows[ranks], cls.indicators[ranks] = beat(folder, ranks)

    def test_passes_the_four_phases_in_order(self):
        self.assertEqual([phase["name"] for phase in self.indicators[1]["phases"]][:4], PHASES)

    def test_its_digits_stay(self):
        assert_digits(self, "MXS", self.indicators[1])

    def test_histories_on_one_and_two_ranks_agree_up_to_the_first_valve(self):
        n = sum(row["phase"] == PHASES[0] for row in self.rows[1])
        self.assertGreater(n, 100)
        for column in self.rows[1][0]:
            if column == "phase" or any(word in column for word in COUNTS):
                continue
            one, two = (np.array([float(row[column]) for row in self.rows[ranks]]) for ranks in (1, 2))
            self.assertTrue(np.array_equal(np.isnan(one[:n]), np.isnan(two[:n])), column)
            difference = np.nanmax(np.abs(one[:n] - two[:n]), initial=0)
            finite = one[np.isfinite(one)]
            scale = np.ptp(finite) or np.max(np.abs(finite))  # the activation time is known once, then constant
            self.assertLessEqual(difference, (ESTIMATE if "alpha_limit" in column else 1e-6) * scale, column)

    def test_indicators_and_phases_do_not_depend_on_the_ranks(self):
        one, two = self.indicators[1], self.indicators[2]
        for key in ("EF_percent", "p_max_mmHg", "ILI_C_percent", "ILI_R_percent", "EDV_mL", "ESV_mL"):
            self.assertAlmostEqual(two[key] / one[key], 1, delta=1e-4, msg=key)
        for phase, other in zip(one["phases"], two["phases"]):
            self.assertEqual(phase["name"], other["name"])
            self.assertAlmostEqual(phase["start"], other["start"], delta=2.01e-4)
            self.assertAlmostEqual(phase["end"], other["end"], delta=2.01e-4)


def calcium(time, x):
    """A transient that spreads from the base to the apex in 60 ms [uM]; x [point][3] [m]."""
    since = np.maximum(0, time - 0.06 * (0.015 - x[:, 2]) / 0.087)
    return 0.115 + 1.35 * np.exp(-since / 0.15) * (1 - np.exp(-since / 0.008))


class HeartbeatOfM0(unittest.TestCase):
    STEP_MS, STEPS = 0.4, 2000

    def test_its_digits_stay(self):
        settings = ["mesh=M0", f"time.step={self.STEP_MS} ms", "checkpoint.every=0 ms"]
        words = [word for setting in settings for word in ("--set", setting)]
        with tempfile.TemporaryDirectory() as folder:
            recorded = Path(folder) / "calcium.h5"
            one_step = ["--set", f"time.end={self.STEP_MS} ms", "--set", "electrophysiology.refinements=0"]
            launch = run_scene(SCENE, folder, "--ranks", "1", "--out", "points", "--record", f"calcium={recorded}",
                               *words, *one_step)
            self.assertEqual(launch.code, 0, launch.output)
            self.write(recorded)
            scene = Path(folder) / "replayed.yaml"
            scene.write_text(f"base: {SCENE}\nparticipants:\n"
                             f"  ep: {{program: replay, ranks: 1, settings: {{file: {recorded}}}}}\n")
            launch = run_scene(scene, folder, "--ranks", "1", "--out", "out", *words)
            self.assertEqual(launch.code, 0, launch.output)
            indicators = json.loads((Path(folder) / "out/indicators.json").read_text())
        self.assertEqual([phase["name"] for phase in indicators["phases"]][:4], PHASES)
        assert_digits(self, "M0", indicators)

    def write(self, recorded):
        """`calcium` at the points of the recording, in all steps."""
        with h5py.File(recorded, "r+") as file:
            points, n = file["points"][:], self.STEPS
            file["values"].resize(n, axis=0)
            for name in "step", "time":
                file[name].resize(n, axis=0)
            file["step"][:] = np.arange(1, n + 1)
            file["time"][:] = 1e-3 * self.STEP_MS * np.arange(1, n + 1)
            file["values"][:] = [calcium(time, points)[:, None] for time in file["time"][:]]


if __name__ == "__main__":
    unittest.main(verbosity=2)
