"""Studies: nothing is computed twice, nothing finished is lost, mistakes are told, the border of stability is found."""
import csv
import os
import signal
import sys
import tempfile
import unittest
from pathlib import Path

from launch import SOURCE, Forked, Launch, wait_for

sys.path.insert(0, str(SOURCE / "tools"))
from study import table  # noqa: E402
from study.budget import Plan  # noqa: E402
from study.launch import defaults  # noqa: E402
from study.plan import Study  # noqa: E402

PISTON = SOURCE / "configs/benchmarks/piston/efs1.yaml"
STUDY = f"""
about: Losses of the piston
base: {PISTON}
settings: {{time.end: 20 ms, push.pressure.times: "[0 ms, 10 ms]", checkpoint.every: 4 ms, keep: 9}}
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
ITERATED = ("EFS1_a2500", "EFS1_a5000", "E1FS2_a2500", "E1FS2_a5000")
STAND_IN = "{program: stand_in, ranks: 1, settings: {mischief: none, step: 0, delay: 0}}"
UNSTABLE = "  unstable: {alpha: 60000 kg/(m^2 s), from: {run: EFS1_a5000, time: 8 ms}}\n"
BORDER = f"""
base: {PISTON}
settings: {{push.pressure.times: "[0 ms, 0.2 ms]", push.pressure.values: "[0 Pa, 0.01 Pa]", steps: 200}}
vary:
  scheme: {{EFS1: {{scheme: EFS1}}}}
border: {{key: alpha, unit: kg/(m^2 s), values: [23500, 26500], precision: 0.03, column: volume_defect, closed_form: piston}}
"""


class Folder(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def write(self, text):
        (self.folder / "losses.yaml").write_text(text)

    def command(self, what="run", *arguments):
        return ["/usr/bin/python3", SOURCE / "tools/study.py", what, "losses.yaml", "--out", "out", *arguments]

    def study(self, *arguments):
        return Forked(SOURCE / "tools/study.py", self.command(*arguments)[2:], self.folder)

    def stopped(self, during):
        """While all but the reference is computed."""
        return Launch(self.command("run", "--jobs", 2, "--only", *ITERATED), self.folder, during)

    def table(self):
        with open(self.folder / "out/losses/table.csv", newline="") as file:
            return {row["run"]: row for row in csv.DictReader(file)}

    def finished(self):
        """When each finished run was."""
        return {note.parent.name: note.stat().st_mtime_ns for note in (self.folder / "out/runs").glob("*/run.json")}


class Life(Folder):
    """One study, begun and ended in every way: what a stage has finished the next ones find."""

    def test_results_are_in_the_folder_one_stands_in(self):
        self.write(STUDY)
        Forked(SOURCE / "tools/study.py", ["plot", "losses.yaml"], self.folder)
        self.assertTrue((self.folder / "results/studies/losses/table.csv").exists())

    def test_nothing_finished_is_lost_or_done_again(self):
        self.write(STUDY)
        self.is_interrupted()
        self.is_killed()
        self.goes_on_with_a_run_that_fails()
        self.is_completed()
        self.is_not_done_again()
        self.is_asked_for_advice()

    def is_interrupted(self):
        def interrupt(process):
            wait_for(lambda: any((self.folder / "out/runs").glob("*/history.csv")))
            process.send_signal(signal.SIGINT)

        launch = self.stopped(interrupt)
        self.assertEqual(launch.code, 1, launch.output)
        self.assertIn("interrupted by SIGINT", launch.output)
        self.assertRegex(launch.output, "missing: .*E1FS2_a5000")
        self.assertEqual(launch.orphans, [])

    def is_killed(self):
        before = self.finished()

        def kill(process):
            wait_for(lambda: len(self.finished()) > len(before))
            process.send_signal(signal.SIGKILL)

        launch = self.stopped(kill)
        self.assertEqual(launch.code, -signal.SIGKILL)
        self.assertGreater(len(self.finished()), len(before))
        self.assertLess(len(self.finished()), len(ITERATED))
        self.kept = self.finished()

    def goes_on_with_a_run_that_fails(self):
        """Only that and what it starts from: the reference stays missing."""
        self.write(STUDY.replace("reference:", UNSTABLE + "reference:"))
        launch = self.study("run", "--only", "unstable", "EFS1_a5000")
        self.assertEqual(launch.code, 1, launch.output)
        row = self.table()["unstable"]
        self.assertEqual(row["state"], "failed")
        self.assertRegex(row["reason"], "exit code 5: fluid.*the coupling is unstable")
        self.assertEqual(self.table()["EFS1_a5000"]["state"], "done")
        self.assertEqual(self.table()["E1FSinf"]["state"], "missing")
        self.assertEqual(launch.output.count("reference 'E1FSinf' is missing"), 1, launch.output)
        launch = self.study("advise", "--tolerance", "p=100%")
        self.assertEqual(launch.code, 2, launch.output)
        self.assertRegex(launch.output, "^error: losses: the reference 'E1FSinf' is missing.*--only E1FSinf\n$")
        self.assertIn("0 to be computed", self.study("run", "--only", "unstable").output)
        self.assertIn("1 to be computed", self.study("run", "--only", "unstable", "--retry").output)

    def is_completed(self):
        self.write(STUDY)
        launch = Launch(self.command(), self.folder)
        self.assertEqual(launch.code, 0, launch.output)
        self.assertEqual(self.kept, {key: self.finished()[key] for key in self.kept})
        self.assertTrue(all(row["state"] == "done" for row in self.table().values()))
        self.assertEqual(launch.orphans, [])
        self.assertTrue((self.folder / "out/losses/losses.png").exists())
        # twice alpha, half the loss; two iterations lose less
        table = self.table()
        self.assertEqual(len(table), 5)
        self.assertAlmostEqual(float(table["EFS1_a2500"]["max_V"]) / float(table["EFS1_a5000"]["max_V"]), 2, delta=0.1)
        self.assertLess(float(table["E1FS2_a5000"]["max_V"]), 0.5 * float(table["EFS1_a5000"]["max_V"]))

    def is_not_done_again(self):
        table, finished = self.table(), self.finished()
        launch = self.study()
        self.assertEqual(launch.code, 0, launch.output)
        self.assertIn("0 to be computed", launch.output)
        self.assertEqual(finished, self.finished())
        self.assertEqual(table, self.table())

    def is_asked_for_advice(self):
        table = self.table()
        launch = self.study("pareto")  # of the errors that there are: nothing is ejected
        self.assertEqual(launch.code, 0, launch.output)
        self.assertTrue((self.folder / "out/losses/pareto_p.pdf").exists())
        self.assertFalse((self.folder / "out/losses/pareto_EF.png").exists())
        launch = self.study("advise", "--tolerance", "EF=2%")
        self.assertEqual(launch.code, 2, launch.output)
        self.assertRegex(launch.output, "no finished run has error_EF; known are .*p")

        self.write(STUDY + "pareto: {errors: [error_p], floor: {step: {run: E1FS2_a5000, order: 1, ratio: 3}}}\n")
        floor = float(table["E1FS2_a5000"]["error_p"]) / 2  # the reference's own error, if it is thrice as fine
        launch = self.study("pareto")
        self.assertEqual(launch.code, 0, launch.output)
        self.assertIn(f"floor: error_p {floor:.2g}\n", launch.output)
        launch = self.study("advise", "--tolerance", f"p={0.9 * floor}%")
        self.assertEqual(launch.code, 2, launch.output)
        self.assertIn("the reference 'E1FSinf' is itself off by", launch.output)
        launch = self.study("advise", "--tolerance", "p=100%")
        self.assertEqual(launch.code, 0, launch.output)
        self.assertRegex(launch.output, r"E1?FS\d_a\d+: .* CPU s")
        Launch([Path(os.environ["HEARTBUS_BIN"]) / "coupler", "out/losses/advised.yaml", "--validate"], self.folder)


class Studies(Folder):
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

    def test_the_budget_of_the_piston_finds_what_contributes_what(self):
        command = ["/usr/bin/python3", SOURCE / "tools/study.py", "budget", PISTON, "--out", "out", "--of", "V", "p",
                   "--set", "time.end=8 ms", "--set", "push.pressure.times=[0 ms, 4 ms]"]
        launch = Launch(command, self.folder)
        self.assertEqual(launch.code, 0, launch.output)
        with open(self.folder / "out/budget_efs1/budget.csv", newline="") as file:
            rows = {row["run"]: row for row in csv.DictReader(file)}
        self.assertEqual(set(rows), {"step_finer", "step_coarser", "mesh_finer", "scheme_finer", "tolerances_finer",
                                     "tolerances_coarser"})
        by_finer, by_coarser = (float(rows[f"step_{which}"]["error_V"]) for which in ("finer", "coarser"))
        self.assertAlmostEqual(by_coarser / by_finer, 1, delta=0.2)  # first order: both estimate the same error
        self.assertGreater(float(rows["scheme_finer"]["error_V"]), 100 * float(rows["tolerances_finer"]["error_V"]))
        self.assertGreater(float(rows["tolerances_coarser"]["error_V"]), 0)
        self.assertRegex(launch.output, "Refine next: .*; finer than needed: ")
        self.assertTrue((self.folder / "out/budget_efs1/budget.png").exists())
        self.assertIn("0 to be computed", Forked(command[1], command[2:], self.folder).output)
        launch = Forked(command[1], [*command[2:6], "--of", "EFF"], self.folder)
        self.assertEqual((launch.code, launch.output.count("\n")), (2, 1), launch.output)

    def test_one_calcium_serves_all_steps_and_is_paid_for(self):
        self.write(f"""
base: {SOURCE}/tests/regression/small_heartbeat.yaml
settings: {{time.end: 1.6 ms, stimulus.duration: 1 ms, electrophysiology.refinements: 0,
           participants: {{ep: {{ranks: 1}}, mech: {{ranks: 1}}, ale: {STAND_IN}, fluid: {STAND_IN}}}}}
calcium: {{time.step: 0.4 ms, electrophysiology.substeps: 4}}
vary: {{step: {{dt0.8: {{time.step: 0.8 ms}}, dt0.2: {{time.step: 0.2 ms}}}}}}
reference: dt0.2
""")
        launch = self.study()
        self.assertEqual(launch.code, 0, launch.output)
        self.assertEqual(len(self.finished()), 3)
        rows = self.table()
        self.assertGreater(float(rows["dt0.8"]["cost_s"]), float(rows["dt0.8"]["cpu_s"]))


class StudiesOfTheProject(unittest.TestCase):
    def test_all_can_be_read(self):
        known = defaults()
        for file in sorted(SOURCE.glob("configs/studies/*.yaml")):
            with self.subTest(file.name):
                study = Study(file, known)
                for run in study.runs:
                    study.case(run)

    def test_a_budget_varies_what_auto_comes_to(self):
        scene = SOURCE / "configs/ideal_lv/efs1.yaml"
        for mesh, coarser, finer in (("M0", 1, 3), ("M1", 0, 2)):
            tree = Study(scene, defaults(), scene, [f"mesh={mesh}"], None, {"also": {"scene": {}}}).base_tree
            runs = Plan(tree, defaults()).runs
            self.assertEqual(runs["ep_mesh_finer"]["electrophysiology.refinements"], finer)
            self.assertEqual(runs["ep_mesh_coarser"]["electrophysiology.refinements"], coarser)


if __name__ == "__main__":
    unittest.main(verbosity=2)
