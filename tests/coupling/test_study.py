"""Studies: nothing is computed twice, nothing finished is lost, mistakes are told, the border of stability is found."""
import csv
import os
import signal
import sys
import tempfile
import time
import unittest
from pathlib import Path

from launch import SOURCE, Launch

sys.path.insert(0, str(SOURCE / "tools"))
from study.launch import defaults  # noqa: E402
from study.pareto import cheapest, front, limits  # noqa: E402
from study.plan import Study  # noqa: E402
from study.scene import StudyError  # noqa: E402

PISTON = SOURCE / "configs/benchmarks/piston/efs1.yaml"
STUDY = f"""
about: Losses of the piston
base: {PISTON}
settings: {{time.end: 20 ms, end_pressure.ramp: 10 ms, checkpoint.every: 4 ms, keep: 9}}
vary:
  scheme:
    EFS1: {{scheme: EFS1}}
    E1FS2: {{scheme: E1FS, iterations: 2}}
  alpha:
    a2500: {{alpha: 2500 kg/(m^2 s)}}
    a5000: {{alpha: 5000 kg/(m^2 s)}}
also:
  E1FSinf: {{scheme: E1FSinf, participants: {{mech: , fluid: , fsi: {{program: fsi_solver}}}}}}
reference: E1FSinf
figures:
  losses: {{kind: against, x: alpha, y: [max_V, error_p], by: scheme, log: [x, y], fit: true}}
"""
UNSTABLE = "  unstable: {alpha: 60000 kg/(m^2 s), from: {run: EFS1_a5000, time: 8 ms}}\n"
BORDER = f"""
base: {PISTON}
settings: {{end_pressure.ramp: 0.2 ms, end_pressure.final: 0.01 Pa, steps: 200}}
vary:
  scheme: {{EFS1: {{scheme: EFS1}}}}
border: {{key: alpha, unit: kg/(m^2 s), values: [22000, 28000], precision: 0.03, column: volume_defect, closed_form: piston}}
"""


class Studies(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def write(self, text):
        (self.folder / "losses.yaml").write_text(text)

    def command(self, what="run", *arguments):
        return ["/usr/bin/python3", SOURCE / "tools/study.py", what, "losses.yaml", "--out", "out", *arguments]

    def study(self, *arguments, during=None):
        return Launch(self.command(*arguments), self.folder, during)

    def table(self):
        with open(self.folder / "out/losses/table.csv", newline="") as file:
            return {row["run"]: row for row in csv.DictReader(file)}

    def finished(self):
        """When each finished run was."""
        return {note.parent.name: note.stat().st_mtime_ns for note in (self.folder / "out/runs").glob("*/run.json")}

    def test_what_is_done_is_not_done_again(self):
        self.write(STUDY)
        launch = self.study()
        self.assertEqual(launch.code, 0, launch.output)
        self.assertTrue((self.folder / "out/losses/losses.png").exists())
        table, finished = self.table(), self.finished()
        self.assertEqual(len(finished), 5)
        # twice alpha, half the loss; two iterations lose less
        self.assertAlmostEqual(float(table["EFS1_a2500"]["max_V"]) / float(table["EFS1_a5000"]["max_V"]), 2, delta=0.1)
        self.assertLess(float(table["E1FS2_a5000"]["max_V"]), 0.5 * float(table["EFS1_a5000"]["max_V"]))

        launch = self.study()
        self.assertEqual(launch.code, 0, launch.output)
        self.assertIn("0 to be computed", launch.output)
        self.assertEqual(finished, self.finished())
        self.assertEqual(table, self.table())

        launch = self.study("advise", "--tolerance", "p=100%")
        self.assertEqual(launch.code, 0, launch.output)
        self.assertRegex(launch.output, r"E1?FS\d_a\d+: .* CPU s")
        Launch([Path(os.environ["HEARTBUS_BIN"]) / "coupler", "out/losses/advised.yaml", "--validate"], self.folder)

    def test_a_killed_study_goes_on(self):
        self.write(STUDY)

        def kill(process):
            deadline = time.monotonic() + 60
            while not self.finished() and time.monotonic() < deadline:
                time.sleep(0.02)
            process.send_signal(signal.SIGKILL)

        launch = self.study(during=kill)
        self.assertEqual(launch.code, -signal.SIGKILL)
        before = self.finished()
        self.assertGreater(len(before), 0)
        self.assertLess(len(before), 5)
        launch = self.study()
        self.assertEqual(launch.code, 0, launch.output)
        self.assertEqual(before, {key: self.finished()[key] for key in before})
        self.assertTrue(all(row["state"] == "done" for row in self.table().values()))
        self.assertEqual(launch.orphans, [])

    def test_an_interrupted_study_says_what_is_missing_and_leaves_nobody_behind(self):
        self.write(STUDY)

        def interrupt(process):
            time.sleep(2)
            process.send_signal(signal.SIGINT)

        launch = self.study(during=interrupt)
        self.assertEqual(launch.code, 1, launch.output)
        self.assertIn("interrupted by SIGINT", launch.output)
        self.assertIn("missing: E1FSinf", launch.output)
        self.assertEqual(launch.orphans, [])

    def test_a_run_that_fails_is_kept_with_its_reason(self):
        self.write(STUDY.replace("reference:", UNSTABLE + "reference:"))
        launch = self.study("run", "--only", "unstable", "EFS1_a5000")
        self.assertEqual(launch.code, 1, launch.output)
        row = self.table()["unstable"]
        self.assertEqual(row["state"], "failed")
        self.assertRegex(row["reason"], "exit code 5: fluid.*the coupling is unstable")
        self.assertEqual(self.table()["EFS1_a5000"]["state"], "done")
        self.assertEqual(self.table()["E1FSinf"]["state"], "missing")
        self.assertIn("0 to be computed", self.study("run", "--only", "unstable").output)
        self.assertIn("1 to be computed", self.study("run", "--only", "unstable", "--retry").output)

    def test_mistakes_in_a_study_are_named(self):
        for wrong, right, message in (("refrence:", "reference:", "'refrence' is unknown; 'reference' is meant"),
                                      ("alhpa: 2500", "alpha: 2500", "a2500: key 'alhpa' is unknown; 'alpha' is meant"),
                                      ("reference: E1FSi\n", "reference: E1FSinf\n", "there is no run 'E1FSi' among"),
                                      ("kind: agianst", "kind: against", "key 'kind' is one of against")):
            self.write(STUDY.replace(right, wrong))
            launch = self.study()
            self.assertEqual(launch.code, 2, launch.output)
            self.assertIn(message, launch.output)
            self.assertEqual(launch.output.count("\n"), 1, launch.output)
        self.assertFalse((self.folder / "out").exists())

    def test_the_border_of_the_piston_is_that_of_the_closed_form(self):
        self.write(BORDER)
        launch = self.study("stability")
        self.assertEqual(launch.code, 0, launch.output)
        row = self.table()["EFS1"]
        self.assertAlmostEqual(float(row["border"]) / float(row["piston"]), 1, delta=0.03)
        self.assertTrue((self.folder / "out/losses/losses.png").exists())


class StudiesOfTheProject(unittest.TestCase):
    def test_all_can_be_read(self):
        known = defaults()
        for file in sorted(SOURCE.glob("configs/studies/*.yaml")):
            with self.subTest(file.name):
                study = Study(file, known)
                for run in study.runs:
                    study.case(run)


class Choice(unittest.TestCase):
    ROWS = [{"run": name, "cpu_s": cost, "error_EF": EF, "error_p_max": p}
            for name, cost, EF, p in (("cheap", 1, 5, 5), ("fair", 2, 1.5, 4), ("good", 3, 1, 1), ("dear", 4, 2, 0.5))]

    def test_the_front_is_what_no_other_beats_in_both(self):
        self.assertEqual(front([(row["cpu_s"], row["error_EF"]) for row in self.ROWS]), [True, True, True, False])

    def test_the_cheapest_choice_within_all_limits_is_advised(self):
        for words, name in ((["EF=2%"], "fair"), (["EF=2%", "p_max=3"], "good"), (["EF=10%"], "cheap")):
            self.assertEqual(cheapest(self.ROWS, limits(words))["run"], name)
        self.assertIsNone(cheapest(self.ROWS, limits(["EF=0.1%"])))
        with self.assertRaises(StudyError):
            limits(["EF 2%"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
