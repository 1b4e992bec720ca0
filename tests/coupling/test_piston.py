"""The piston: what the coupling loses and when it becomes unstable, against closed forms.

An elastic column is pushed from its far end against a closed box of blood. The closed forms need the column's own
matrices only: linear elements with consistent mass, springs and dampers at the far end.
"""
import csv
import functools
import json
import math
import re
import tempfile
import unittest
from pathlib import Path

import numpy as np
from launch import SOURCE, run_scene

CONVERGED = "scheme=E1FS", "iterations=50", "coupling.tolerance=1e-8"
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


def impedance(step):
    """Traction per velocity, within one implicit step of this size, at the interface."""
    M, C, K = column()
    return step / np.linalg.inv(M / step**2 + C / step + K)[0, 0]


def efs1_limit():
    """The alpha at which the mode of amplification -1 neither grows nor decays in a closed cavity: that of half a step."""
    return 2 * impedance(STEP / 2)


def e1fs2_limit():
    """The alpha at which an iteration in a closed cavity does not reduce the error of the velocity."""
    return 2 * impedance(STEP)


def run(folder, *settings):
    arguments = [word for setting in settings for word in ("--set", setting)]
    launch = run_scene(SCENE, folder, "--out", "out", *arguments)
    with open(Path(folder) / "out/history.csv") as file:
        rows = list(csv.DictReader(file))
    return launch, {key: np.array([float(row[key]) for row in rows]) for key in rows[0] if key != "phase"}


def volume_defect_after_push(alpha, *settings):
    """A push so small that nobody minds that what comes of it grows."""
    with tempfile.TemporaryDirectory() as folder:
        launch, history = run(folder, f"alpha={alpha} kg/(m^2 s)", "push.pressure.times=[0 ms, 0.2 ms]",
                              "push.pressure.values=[0 Pa, 0.01 Pa]", "time.end=40 ms", *settings)
    assert launch.code == 0, launch.output
    return history["volume_defect [m^3/s]"]


def alternating_growth(defect):
    """Logarithmic growth per step of the part that alternates from step to step."""
    alternating = np.abs(np.diff(defect, 8))[-120:]  # each difference doubles what alternates, and shrinks what is smooth
    return np.polyfit(np.arange(alternating.size), np.log(alternating), 1)[0]


def smooth_growth(defect):
    """Logarithmic growth per step of the part that does not alternate."""
    defect = np.abs(defect[1:] + defect[:-1])
    return math.log(defect[-50:].max() / defect[-100:-50].max()) / 50


def measured_limit(prediction, growth_of, *settings):
    """Where growth begins, by linear interpolation between runs below and above the prediction."""
    alphas = np.array([0.98, 1.01]) * prediction
    growth = np.array([growth_of(volume_defect_after_push(alpha, *settings)) for alpha in alphas])
    print("alpha", alphas, "log growth per step", growth)
    assert growth[0] <= 0 < growth[1], f"the growth factor does not cross 1 near {prediction}: {growth}"
    return alphas[1] - growth[1] * (alphas[1] - alphas[0]) / (growth[1] - growth[0])


def drift(history):
    """Of the wall into the blood [m]."""
    return (history["volume [m^3]"][0] - history["volume [m^3]"][-1]) / AREA


@functools.cache
def pushed(*settings):
    """(history, its bytes) of a push in a shorter time than the scene's; computed once for all who look at it."""
    with tempfile.TemporaryDirectory() as folder:
        launch, history = run(folder, "time.end=80 ms", *settings)
        assert launch.code == 0, launch.output
        return history, (Path(folder) / "out/history.csv").read_bytes()


class Piston(unittest.TestCase):
    def pushed(self, *settings):
        return pushed(*settings)[0]

    def assert_close(self, value, expected, share=0.03):
        self.assertAlmostEqual(value / expected, 1, delta=share)

    def test_wall_drifts_by_step_times_pressure_over_alpha(self):
        with tempfile.TemporaryDirectory() as folder:
            launch, history = run(folder)
        self.assertEqual(launch.code, 0, launch.output)
        pressure = history["mean_pressure [Pa]"][-1]
        self.assert_close(drift(history), STEP * pressure / 5000)
        # The push arrives but for what the far spring takes.
        self.assertGreater(pressure, 0.9 * 500)
        self.assertLess(pressure, 500)

    def test_loose_coupling_is_of_first_order_in_the_step(self):
        # against iterations to the end, which are the monolithic scheme, with the same step
        errors = []
        for step in 0.4, 0.2, 0.1:
            size = [] if step == 0.2 else [f"time.step={step} ms"]
            loose, whole = (self.pushed(*size, *settings) for settings in ([], [*CONVERGED, "acceleration=anderson"]))
            errors.append([np.linalg.norm(loose[key] - whole[key]) / np.linalg.norm(whole[key])
                           for key in ("volume [m^3]", "mean_pressure [Pa]")])
        orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
        print("orders of volume and pressure", orders)
        self.assertLess(abs(orders[:, 0] - 1).max(), 0.05)
        self.assertLess(abs(orders[:, 1] - 1).max(), 0.15)

    def test_iterations_reduce_the_drift_as_the_impedance_says(self):
        # ILI_k/ILI_1 = 1 / sum_{j<k} (1-q)^{-j} with q = alpha/Z
        once = drift(self.pushed())
        q = 5000 / impedance(STEP)
        for k in 2, 3:
            ratio = drift(self.pushed("scheme=E1FS", f"iterations={k}")) / once
            self.assert_close(ratio, 1 / sum((1 - q) ** -j for j in range(k)))

    def test_E1FS_with_one_iteration_is_EFS1_to_the_last_bit(self):
        self.assertEqual(pushed()[1], pushed("scheme=E1FS")[1])

    def test_converged_iterations_keep_the_volume(self):
        once = drift(self.pushed())
        mean_iterations = []
        for acceleration in "none", "anderson":
            history = self.pushed(*CONVERGED, f"acceleration={acceleration}")
            self.assertLess(abs(drift(history)), 1e-4 * once)
            self.assertLess(history["datum_residual"][1:].max(), 1e-8)
            mean_iterations.append(history["coupling_iterations"][1:].mean())
        self.assertLess(mean_iterations[1], 0.5 * mean_iterations[0])

    def test_iterations_that_do_not_converge_are_reported(self):
        with tempfile.TemporaryDirectory() as folder:
            launch, _ = run(folder, "scheme=E1FS", "iterations=2", "coupling.tolerance=1e-8")
        self.assertEqual(launch.code, 5)
        self.assertRegex(launch.output, "do not agree after 2 iterations: 'datum_residual' is .* where 1e-08 is wanted")

    def test_adaptive_iterations_bound_the_loss_of_each_step(self):
        history = self.pushed("scheme=adaptive", "iterations=20", "epsilon=1e-6")
        self.assertLess(history["volume_loss"][1:].max(), 1e-6)
        self.assertGreater(history["coupling_iterations"].max(), 1)
        self.assertEqual(history["coupling_iterations"][-1], 1)  # when all is at rest

    def test_corrected_pressure_keeps_the_volume(self):
        exact = self.pushed(*CONVERGED, "acceleration=anderson")
        for alpha in 500, 5000, 15000:
            history = self.pushed("scheme=EFS1-corrected", f"alpha={alpha} kg/(m^2 s)")
            self.assertLess(abs(drift(history)), 1e-9 * LENGTH)
            self.assert_close(history["mean_pressure [Pa]"][-1], exact["mean_pressure [Pa]"][-1], 1e-3)

    def predicted_limit(self, *settings):
        history = self.pushed("alpha=auto", "time.end=4 ms", *settings)
        limit = history["alpha_limit [kg/(m^2 s)]"][-1]
        self.assert_close(history["alpha [kg/(m^2 s)]"][-1], 0.8 * limit, 1e-3)
        return limit

    def test_alphas_limit_is_estimated_before_the_first_step_and_every_20_ms(self):
        with tempfile.TemporaryDirectory() as folder:
            launch, history = run(folder, "alpha=auto", "time.end=41 ms")
            said = (Path(folder) / "out/logs/mech.log").read_text()
        self.assertEqual(launch.code, 0, launch.output)
        self.assertGreater(history["alpha_limit [kg/(m^2 s)]"][0], 0)
        self.assertEqual(re.findall(r"t = (\S+) s: alpha may be up to", said), ["0.0000", "0.0200", "0.0400"])

    def test_EFS1_becomes_unstable_where_the_column_and_alpha_auto_say(self):
        limit = measured_limit(efs1_limit(), alternating_growth)
        self.assert_close(limit, efs1_limit())
        self.assert_close(limit, self.predicted_limit())

    def test_two_iterations_become_unstable_where_the_column_and_alpha_auto_say(self):
        twice = "scheme=E1FS", "iterations=2"
        limit = measured_limit(e1fs2_limit(), smooth_growth, *twice)
        self.assert_close(limit, e1fs2_limit())
        self.assert_close(limit, self.predicted_limit(*twice))

    def test_instability_is_recognised_and_named(self):
        with tempfile.TemporaryDirectory() as folder:
            launch, history = run(folder, f"alpha={1.1 * efs1_limit():.0f} kg/(m^2 s)")
        self.assertEqual(launch.code, 5)
        self.assertRegex(launch.output, "the coupling is unstable: .* coupling.alpha is 27[0-9]{3} .* or 'alpha: auto'")
        self.assertLess(history["mean_pressure [Pa]"].max(), 50e3)  # before it has become absurd

    def test_the_trace_has_a_row_for_each_rank_and_nothing_overlaps_in_it(self):
        with tempfile.TemporaryDirectory() as folder:
            launch, _ = run(folder, "time.end=2 ms", "output.trace=true", "mech.ranks=2")
            events = json.loads((Path(folder) / "out/trace.json").read_text())["traceEvents"]
        self.assertEqual(launch.code, 0, launch.output)
        names = {event["pid"]: event["args"]["name"] for event in events if event["name"] == "process_name"}
        rows = {}
        for event in events:
            if event["ph"] == "X":
                rows.setdefault((names[event["pid"]], event["tid"]), []).append(event)
        self.assertEqual(sorted(rows), [("ale", 0), ("coupler", 0), ("fluid", 0), ("mech", 0), ("mech", 1)])
        self.assertEqual(sum(event["name"] == "solve" for event in rows["mech", 1]), 10)
        self.assertIn("receive blood_force", [event["name"] for event in rows["mech", 0]])
        for row in rows.values():
            open_until = []  # ends of the slices around
            for event in sorted(row, key=lambda event: (event["ts"], -event["dur"])):
                while open_until and open_until[-1] <= event["ts"] + 1e-6:
                    open_until.pop()
                end = event["ts"] + event["dur"]
                self.assertTrue(not open_until or end <= open_until[-1] + 1e-6, event)
                open_until.append(end)


if __name__ == "__main__":
    unittest.main(verbosity=2)
