"""heartbus-check finds what a program does wrong, and nothing in those that do nothing wrong."""
import re
import subprocess
import sys
import unittest
from concurrent.futures import ThreadPoolExecutor

from launch import SANITIZED, SOURCE, use_library

WRONG = [  # what the dummy does, the checks that it fails with the reason of each
    ("stranger", [("joins", "without")]),
    ("nameless", [("declares what the role needs", "'blood_force' from fluid to mech (fluid declares no such output)")]),
    ("other_unit", [("units", "is sent by fluid in 'mN', but expected by mech in 'N'")]),
    ("shifted", [("points conform", "is 0.00173205 m away")]),
    ("lingers", [("ends when told", "all participants to end")]),
    ("spins", [("waits asleep", "of a core while it waits")]),
    ("accumulates", [("iterations start from the old state", "of its range between two solves of step")]),
    ("forgets", [("a restart gives the same bits", "after a restart from step 20")]),
    ("swallows", [("what is not finite is refused", "it goes on with NaN from mech")]),
]


def check(command, role):
    return subprocess.run([sys.executable, SOURCE / "tools/check.py", command, "--role", role], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, check=False)


OURS = {"ep": "ep_solver", "mech": "mech_solver", "ale": "ale_solver", "fluid": "fluid_solver", "fsi": "fsi_solver",
        "circulation": "cavity_solver"}
AT_ONCE = 6  # most of a check is sleep: partners that take their time, deadlines


class Conformance(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        use_library()
        with ThreadPoolExecutor(AT_ONCE) as pool:
            ours = {role: pool.submit(check, program, role) for role, program in OURS.items()}
            wrong = {mischief: pool.submit(check, f"{sys.executable} {SOURCE / 'tests/coupling/wrong_fluid.py'} {mischief}", "fluid")
                     for mischief, _ in WRONG}
        cls.ours, cls.wrong = ({key: run.result() for key, run in runs.items()} for runs in (ours, wrong))

    def test_ours_pass(self):
        for role, run in self.ours.items():
            if SANITIZED and re.findall("^NO  (.*?):.* exit code 255", run.stdout, re.M) == ["what is not finite is refused"]:
                continue  # deal.II's debug library aborts where a norm is not finite
            with self.subTest(role):
                lines = run.stdout.splitlines()
                self.assertEqual((run.returncode, len(lines)), (0, 12), run.stdout)
                self.assertTrue(all(line.startswith("yes ") for line in lines), run.stdout)

    def test_whoever_does_something_wrong_is_told_all_of_it(self):
        for mischief, failed in WRONG:
            with self.subTest(mischief):
                run = self.wrong[mischief]
                self.assertEqual(run.returncode, 1, run.stdout)
                lines = run.stdout.splitlines()
                self.assertEqual(len(lines), 12, run.stdout)
                told = [line for line in lines if line.startswith("NO  ")]
                self.assertEqual(len(told), len(failed), run.stdout)
                for line, (check, reason) in zip(told, failed, strict=True):
                    self.assertTrue(line.startswith(f"NO  {check}: "), run.stdout)
                    self.assertIn(reason, line)

    def test_a_program_that_is_not_there_does_not_join(self):
        lines = check("no_such_program", "ep").stdout.splitlines()
        self.assertRegex(lines[0], "NO  joins: .*there is no executable 'no_such_program'")
        self.assertTrue(all(line.startswith("-   ") for line in lines[1:]), lines)

    def test_what_can_still_be_looked_at_is(self):
        words = {mischief: "".join(line[0] for line in run.stdout.splitlines()) for mischief, run in self.wrong.items()}
        self.assertEqual(words, {"stranger": "N-----------", "nameless": "yN----------", "other_unit": "yyN---------",
                                 "shifted": "yyyN--------", "lingers": "yyyyyN---yyy", "spins": "yyyyyyNyyyyy", "accumulates": "yyyyyyyNyyyy",
                                 "forgets": "yyyyyyyyNyyy",
                                 "swallows": "yyyyyyyyyNyy"})


if __name__ == "__main__":
    unittest.main(verbosity=2)
