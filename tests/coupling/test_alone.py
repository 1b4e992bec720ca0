"""Each physics alone, by scene: blood in a prescribed motion, lifting, the wall under loads; and what they need is asked for."""
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

sys.path.append(str(Path(os.environ["HEARTBUS_SOURCE"]) / "tools"))
from launch import BIN, SOURCE, Launch, run_scene  # noqa: E402
from results import History  # noqa: E402

# Blood above a piston that moves up and down, open at its upper end: all of it moves alike, and with its length l(t) its
# pressure falls linearly to 0 there, p = rho v' l / 2 in the mean.
LENGTH, DENSITY, AMPLITUDE, OMEGA, STEP = 10e-3, 1060.0, 1e-3, 2 * np.pi / 40e-3, 0.2e-3
BLOOD = """
scene: blood_alone
geometry: {shape: piston, piston: {cells_across: 2, cells_column: 2, cells_fluid: 4}}
time: {end: 20 ms, step: 0.2 ms}
coupling: {scheme: %s}
participants:
  mech: {program: replay, settings: {file: motion.h5}}
  ale: {program: ale_solver}
  fluid: {program: fluid_solver}
lifting: {fixed: [z_high], slip: [x_low, x_high, y_low, y_high], tolerance: 1e-12}
fluid:
  initial_pressure: 0 Pa
  no_slip: []
  slip: [x_low, x_high, y_low, y_high]
  tolerance: 1e-11
output: {every: 0 ms, checkpoint: {every: 0 ms}}
"""


# The cavity of the ideal ventricle rests, shrinks, and grows.
TABLE = {0: 100, 20: 100, 40: 90, 60: 95}  # ms, mL
HAEMODYNAMICS = f"""
base: {SOURCE}/configs/ideal_lv/haemodynamics.yaml
geometry: {{mesh: MXS}}
time: {{end: 60 ms, step: 1 ms}}
mechanics: {{cavity_volume: {{table: table.csv}}}}
output: {{every: 0 ms, checkpoint: {{every: 20 ms, keep: 9}}}}
"""


def displacement(time):
    return AMPLITUDE * (1 - np.cos(OMEGA * time)) / 2


def record(path, points, end=20e-3):
    """The motion of the interface as a recording."""
    times = STEP * np.arange(round(end / STEP) + 1)
    values = np.zeros((len(times), len(points), 3))
    values[:, :, 2] = displacement(times)[:, None]
    with h5py.File(path, "w") as file:
        points = file.create_dataset("points", data=np.array(points, dtype=float))
        points.attrs["field"], points.attrs["unit"] = np.bytes_("displacement"), np.bytes_("m")
        file["values"], file["time"] = values, times
        file["step"] = np.arange(len(times), dtype=np.int32)


class Alone(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        record(self.folder / "motion.h5", [(x, y, 0) for x in (0, 5e-3, 10e-3) for y in (0, 5e-3, 10e-3)])

    def run_text(self, text):
        scene = self.folder / "scene.yaml"
        scene.write_text(text)
        return run_scene(scene, self.folder, "--out", self.folder / "out")

    def test_blood_in_a_prescribed_motion_has_the_pressure_of_newtons_law(self):
        launch = self.run_text(BLOOD % "one_way")
        self.assertEqual(launch.code, 0, launch.output)
        history = History(self.folder / "out")
        time, pressure = history.time, history["mean_pressure"]
        velocity = np.diff(displacement(time)) / STEP      # implicit Euler's own, exact for this flow
        acceleration = np.diff(np.concatenate(([0], velocity))) / STEP
        exact = DENSITY * acceleration * (LENGTH - displacement(time[1:])) / 2
        self.assertGreater(np.abs(exact).max(), 50)
        self.assertLess(np.abs(pressure[1:] - exact).max(), 1e-3 * np.abs(exact).max())
        self.assertLess(abs(history["volume"][-1] / (1e-4 * (LENGTH - displacement(time[-1]))) - 1), 1e-9)

    def write_haemodynamics(self, table):
        (self.folder / "table.csv").write_text("time [ms],volume [mL]\n" + "".join(f"{t},{V}\n" for t, V in table.items()))
        (self.folder / "scene.yaml").write_text(HAEMODYNAMICS)
        return self.folder / "scene.yaml"

    def run_haemodynamics(self, table, *words):
        return run_scene(self.write_haemodynamics(table), self.folder, "--ranks", "1", "--out", self.folder / "out", *words)

    def test_a_cavity_has_the_volumes_of_a_table_and_its_open_valve_passes_what_it_changes_by(self):
        launch = self.run_haemodynamics(TABLE)
        self.assertEqual(launch.code, 0, launch.output)
        history = History(self.folder / "out")
        time, volume, ml = 1e3 * history.time, history["volume"], 1e-6
        for t, V in TABLE.items():
            at = np.argmin(abs(time - t))
            self.assertLess(abs(volume[at] / (V * ml) - 1), 1e-10, t)
        self.assertLess(abs(volume / history["cavity_volume"] - 1).max(), 1e-10)
        self.assertTrue((np.diff(volume)[time[1:] < 40.5] <= 1e-12 * volume[0]).all() and (np.diff(volume)[time[1:] > 40.5] > 0).all())
        change, shrinks = np.diff(volume) / 1e-3, (time[1:] > 20.5) & (time[1:] < 40.5)
        out, into = history["aortic_flow"][1:], history["mitral_flow"][1:]
        largest = abs(change).max()
        self.assertGreater(largest, 500 * ml)
        self.assertLess(abs(out + change)[shrinks].max(), 0.01 * largest)  # of first order in the step: it flows where
        self.assertLess(abs(into - change)[~shrinks].max(), 0.01 * largest)  # the wall has arrived
        phases = history.columns["phase"][1:]  # no valve moves while the cavity rests
        self.assertEqual([name for k, name in enumerate(phases) if k == 0 or phases[k - 1] != name], ["filling", "ejection", "filling"])
        self.assertLess(abs(into)[shrinks].max() + abs(out)[~shrinks].max(), 1e-6 * largest)  # closed to the solver's tolerance
        again = self.run_haemodynamics(TABLE, "--restart", "40 ms")
        self.assertEqual(again.code, 0, again.output)
        self.assertEqual(History(self.folder / "out").columns, history.columns)

    def test_volumes_that_the_cavity_cannot_have_are_refused(self):
        launch = self.run_haemodynamics({0: 100, 20: 500})
        self.assertEqual(launch.code, 2, launch.output)
        self.assertIn("key 'mechanics.cavity_volume': 500 mL cannot be reached; at rest the cavity has 77.4 mL, and it goes from "
                      "31.6 mL to 149.2 mL", launch.output)
        for table, words, message in (({0: 100, 20: -5}, [], "is out of range"), ({0: 100, 20: 0}, [], "needs volumes above 0 in time"),
                                      ({0: 100, "0.0": 90}, [], "has the same time twice"),
                                      (TABLE, ["--set", "scheme=EFS1"], "'model: prescribed' is a motion that the blood follows: "
                                                                        "'coupling: {scheme: one_way}'")):
            scene = self.write_haemodynamics(table)
            told = Launch([BIN / "coupler", scene, "--validate", *words], self.folder)
            self.assertEqual(told.code, 2, told.output)
            self.assertIn("key 'mechanics", told.output)
            self.assertIn(message, told.output)

    def test_without_its_robin_datum_it_is_refused(self):
        text = (BLOOD % "EFS1").replace("  mech: {program: replay, settings: {file: motion.h5}}\n  ale: {program: ale_solver}\n", "")
        launch = self.run_text(text)
        self.assertEqual(launch.code, 2, launch.output)
        self.assertIn("the blood needs 'wall_velocity' and 'wall_force' on the interface, which nobody sends", launch.output)

    def test_blood_that_nowhere_can_leave_is_refused(self):
        launch = self.run_text((BLOOD % "one_way").replace("no_slip: []", "no_slip: [z_high]"))
        self.assertEqual(launch.code, 2, launch.output)
        self.assertIn("it needs an opening", launch.output)

    def test_lifting_alone_moves_the_mesh_and_asks_for_the_motion(self):
        text = (BLOOD % "one_way").replace("  fluid: {program: fluid_solver}\n", "")
        launch = self.run_text(text)
        self.assertEqual(launch.code, 0, launch.output)
        self.assertGreater(History(self.folder / "out")["lifting_iterations"].max(), 0)
        launch = self.run_text(text.replace("  mech: {program: replay, settings: {file: motion.h5}}\n", ""))
        self.assertEqual(launch.code, 2, launch.output)
        self.assertIn("lifting needs 'displacement' of the interface, which nobody sends", launch.output)

    def test_short_benchmarks_and_one_of_them_once_more(self):
        for names in (QUICK, QUICK[:1]):
            done = subprocess.run([SOURCE / "tools/verify", "--quick", "--out", self.folder, *names], check=False,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                  env={**os.environ, "HEARTBUS_BIN": str(BIN)})
            self.assertEqual(done.returncode, 0, done.stdout)
            self.assertEqual(done.stdout.count("| within"), done.stdout.count("\n| ") + 1, done.stdout)


QUICK = ["land2015_beam", "turek_hron_csm1", "elastic_bar"]

if __name__ == "__main__":
    unittest.main(verbosity=2)
