"""A whole heartbeat on the smallest mesh: the phases, the indicators, and that the number of ranks does not matter."""
import csv
import json
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "coupling"))
from launch import SOURCE, run_scene  # noqa: E402

SCENE = SOURCE / "tests/regression/small_heartbeat.yaml"
PHASES = ["isovolumetric contraction", "ejection", "isovolumetric relaxation", "filling"]
TIGHT = ["electrophysiology.tolerance=1e-12", "mechanics.solver.residual_tolerance=1e-12",
         "mechanics.solver.update_tolerance=1e-11", "mechanics.solver.linear_tolerance=1e-6",
         "lifting.tolerance=1e-12", "fluid.tolerance=1e-12"]
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


class Heartbeat(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.rows, cls.indicators = {}, {}
        for ranks in (1, 2):
            with tempfile.TemporaryDirectory() as folder:
                cls.rows[ranks], cls.indicators[ranks] = beat(folder, ranks)

    def test_passes_the_four_phases_in_order(self):
        self.assertEqual([phase["name"] for phase in self.indicators[1]["phases"]][:4], PHASES)

    def test_ejects_as_a_heart_does(self):
        indicators = self.indicators[1]
        self.assertTrue(45 < indicators["EF_percent"] < 65, indicators)
        self.assertTrue(100 < indicators["p_max_mmHg"] < 140, indicators)
        self.assertTrue(1 < indicators["ILI_C_percent"] < 5, indicators)
        self.assertTrue(1 < indicators["ILI_R_percent"] < 5, indicators)

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


if __name__ == "__main__":
    unittest.main(verbosity=2)
