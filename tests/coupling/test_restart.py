"""A run goes on from a checkpoint as if it had never stopped, on other ranks and with other schemes too."""
import csv
import random
import shutil
import signal
import tempfile
import time
import unittest
from pathlib import Path

import numpy as np
from launch import BIN, SOURCE, Launch, run_crowded, run_scene

PISTON = SOURCE / "configs/benchmarks/piston/efs1.yaml"
VENTRICLE = SOURCE / "configs/ideal_lv/efs1.yaml"
PISTON_SETTINGS = ["time.end=16 ms", "checkpoint.every=4 ms", "checkpoint.keep=10"]
VENTRICLE_SETTINGS = ["mesh=MXS", "electrophysiology.refinements=0", "output.every=0 ms", "time.end=8 ms"]
TIGHT = ["electrophysiology.tolerance=1e-13", "fluid.tolerance=1e-13", "lifting.tolerance=1e-13",
         "mechanics.solver.residual_tolerance=1e-12", "mechanics.solver.update_tolerance=1e-11",
         "mechanics.solver.linear_tolerance=1e-8"]
MONOLITHIC = "participants: {mech: , fluid: , fsi: {program: fsi_solver, ranks: 1}}\n"


class Restart(unittest.TestCase):
    piston = None  # folder of the results of one piston, from which many go on

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def launch(self, scene, out, settings, *arguments, during=None):
        words = [word for setting in settings for word in ("--set", setting)]
        return run_scene(scene, self.folder, "--out", out, *words, *arguments, during=during)

    def run_well(self, *arguments, **options):
        launch = self.launch(*arguments, **options)
        self.assertEqual(launch.code, 0, launch.output)
        return launch

    def copy_of_piston(self, out):
        """The results of a run with PISTON_SETTINGS."""
        if not Restart.piston:
            temporary = tempfile.TemporaryDirectory()
            unittest.addModuleCleanup(temporary.cleanup)
            Restart.piston = Path(temporary.name) / "out"
            self.run_well(PISTON, Restart.piston, PISTON_SETTINGS)
        shutil.copytree(Restart.piston, self.folder / out)

    def stopped_by(self, out, rows):
        """Sends the signal when the history has so many rows."""

        def stop(process):
            history, deadline = self.folder / out / "history.csv", time.monotonic() + 60
            while time.monotonic() < deadline and not (history.exists() and history.read_text().count("\n") > rows):
                time.sleep(0.001)
            process.send_signal(signal.SIGUSR1)

        return stop

    def table(self, out):
        with open(self.folder / out / "history.csv", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def bits(self, out):
        return (self.folder / out / "history.csv").read_bytes()

    def values(self, out, column):
        return np.array([float(row[column]) for row in self.table(out)])

    def assert_same_bits_after_a_stop(self, scene, settings, last_row, ranks):
        self.run_well(scene, "whole", settings, "--ranks", ranks)
        rows = random.randint(1, last_row)
        stopped = self.run_well(scene, "halves", settings, "--ranks", ranks, during=self.stopped_by("halves", rows))
        self.assertIn("stopped on request", stopped.output, f"signal at row {rows}")
        self.assertNotEqual(self.bits("whole"), self.bits("halves"))
        n_stopped = len(self.table("halves"))
        self.run_well(scene, "halves", settings, "--ranks", ranks, "--restart", "latest")
        self.assertEqual(self.bits("whole"), self.bits("halves"), f"signal at row {rows}")
        return n_stopped

    def assert_close(self, out, reference, tolerance):
        """Within a fraction of each column's range; iterations are not what is computed."""
        for column in self.table(reference)[0]:
            if "iterations" in column or "residual" in column or column == "phase":
                continue
            a, b = self.values(out, column), self.values(reference, column)
            self.assertEqual(len(a), len(b))
            np.testing.assert_array_equal(np.isnan(a), np.isnan(b), column)
            a, b = a[~np.isnan(a)], b[~np.isnan(b)]
            if len(b):
                self.assertLessEqual(np.abs(a - b).max(), tolerance * np.ptp(b), column)

    def test_a_piston_stopped_by_a_signal_goes_on_with_the_same_bits(self):
        # long enough that the signal comes before the end
        self.assert_same_bits_after_a_stop(PISTON, ["time.end=160 ms", "checkpoint.every=0 ms"], 200, "1")

    def test_a_heartbeat_stopped_by_a_signal_goes_on_through_a_valve_with_the_same_bits(self):
        # The aorta's pressure is below the ventricle's from the start, so its valve opens as soon as it may: at step 600,
        # long after the signal.
        settings = VENTRICLE_SETTINGS + ["time.end=144 ms", "aortic_pressure=1300 Pa", "valve_blanking=120 ms"]
        n_stopped = self.assert_same_bits_after_a_stop(VENTRICLE, settings, 30, "2")
        self.assertGreater(len({row["phase"] for row in self.table("whole")[n_stopped:]}), 1)

    def test_all_schemes_go_on_with_the_same_bits_and_keep_the_last_checkpoints(self):
        settings = ["time.end=17 ms", "checkpoint.every=4 ms", "checkpoint.keep=3"]
        for scheme in ["scheme=EFS1-corrected"], ["scheme=adaptive", "iterations=3", "alpha=auto"], [
            "scheme=E1FS", "iterations=20", "coupling.tolerance=1e-6", "acceleration=anderson"]:
            with self.subTest(scheme):
                self.run_well(PISTON, "out", settings + scheme)
                sets = sorted(s.name for s in (self.folder / "out/checkpoints").iterdir())
                self.assertEqual(sets, ["000040", "000060", "000080"])
                whole = self.bits("out")
                self.run_well(PISTON, "out", settings + scheme, "--restart", "8 ms")
                self.assertEqual(whole, self.bits("out"))

    def test_other_ranks_go_on_with_the_same_numbers(self):
        settings = VENTRICLE_SETTINGS + TIGHT + ["checkpoint.every=4 ms"]
        self.run_well(VENTRICLE, "one", settings, "--ranks", "1")
        self.run_well(VENTRICLE, "two", settings, "--ranks", "2", "--restart", "one/checkpoints/000020")
        self.assert_close("two", "one", 1e-8)
        words = [word for setting in settings for word in ("--set", setting)]
        three = run_crowded(VENTRICLE, self.folder, 3, "--out", "three", *words, "--restart", "one/checkpoints/000020")
        self.assertEqual(three.code, 0, three.output)
        self.assert_close("three", "one", 1e-8)

    def test_a_step_of_another_size_keeps_the_velocity(self):
        self.copy_of_piston("coarse")
        self.run_well(PISTON, "fine", PISTON_SETTINGS + ["time.step=0.1 ms"], "--restart", "coarse/checkpoints/000040")
        self.assertEqual(list(self.values("fine", "step")[39:43]), [39, 40, 81, 82])
        self.assert_goes_on_smoothly("fine", 41, finer=2)

    def test_damaged_checkpoints_are_refused_and_latest_passes_over_them(self):
        self.copy_of_piston("out")
        whole, sets = self.bits("out"), self.folder / "out/checkpoints"

        def refused(restart, *parts):
            words = [word for setting in PISTON_SETTINGS for word in ("--set", setting)]
            launch = Launch([BIN / "coupler", PISTON, "--out", "out", *words, "--restart", restart, "--launch-line"],
                            self.folder)
            self.assertEqual(launch.code, 8, launch.output)
            for part in parts:
                self.assertIn(part, launch.output)

        mech = sets / "000080/mech.h5"
        content = mech.read_bytes()
        mech.write_bytes(content[:-100])
        refused("16 ms", "000080: mech.h5 has", "bytes instead of")
        mech.write_bytes(content[:5000] + bytes([content[5000] ^ 1]) + content[5001:])
        refused("out/checkpoints/000080", "000080: mech.h5 is damaged")
        (sets / "000060/manifest.json").unlink()
        refused("out/checkpoints/000060", "000060: there is no manifest.json")
        refused("7 ms", "no checkpoint of 7 ms", "there are: 4 ms, 8 ms, 16 ms")
        refused("soon", "write 'latest', a time such as '48 ms' or a folder")

        launch = self.run_well(PISTON, "out", PISTON_SETTINGS, "--restart", "latest")
        self.assertIn("goes on from t = 8.0 ms", launch.output)
        self.assertIn("passed over", launch.output)
        self.assertEqual(whole, self.bits("out"))
        self.assertEqual(sorted(s.name for s in sets.iterdir()), ["000020", "000040", "000060", "000080"])
        shutil.rmtree(sets)
        refused("latest", "there is no complete checkpoint")

    def test_a_state_of_another_mesh_is_refused(self):
        self.copy_of_piston("out")
        words = [word for setting in [*PISTON_SETTINGS, "cells_column=4"] for word in ("--set", setting)]
        launch = Launch([BIN / "coupler", PISTON, "--out", "out", *words, "--restart", "latest", "--validate"], self.folder)
        self.assertEqual(launch.code, 8, launch.output)
        self.assertIn("geometry.piston.cells_column is 3 there and 4 here", launch.output)

    def test_two_iterations_go_on_from_one(self):
        self.copy_of_piston("one")
        settings = PISTON_SETTINGS + ["scheme=E1FS", "iterations=2"]
        self.run_well(PISTON, "two", settings, "--restart", "one/checkpoints/000040")
        self.assertEqual(self.table("two")[:41], self.table("one")[:41])
        self.assert_goes_on_smoothly("two", 41)

    def test_partitioned_and_merged_schemes_go_on_from_each_other(self):
        merged = self.folder / "merged.yaml"
        merged.write_text(f"base: {PISTON}\ncoupling: {{scheme: E1FSinf}}\n{MONOLITHIC}")
        self.copy_of_piston("one")
        self.run_well(merged, "inf", PISTON_SETTINGS)
        self.run_well(merged, "inf_from_one", PISTON_SETTINGS, "--restart", "one/checkpoints/000040")
        self.run_well(PISTON, "one_from_inf", PISTON_SETTINGS, "--restart", "inf/checkpoints/000040")
        self.assert_goes_on_smoothly("inf_from_one", 41)
        self.assert_goes_on_smoothly("one_from_inf", 41)

    def assert_goes_on_smoothly(self, out, row, finer=1):
        """The pressure rises in the first steps after a restart about as it did before."""
        pressure = self.values(out, "mean_pressure [Pa]")
        before, after = pressure[row - 1] - pressure[row - 6], pressure[row - 1 + 5 * finer] - pressure[row - 1]
        self.assertGreater(after, 0.5 * before)
        self.assertLess(after, 2 * before)
        self.assertLess(np.abs(np.diff(pressure)[row - 1 : row + 5]).max(), before)


if __name__ == "__main__":
    unittest.main(verbosity=2)
