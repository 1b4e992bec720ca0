"""heartbus-check finds what a program does wrong, and nothing in those that do nothing wrong."""
import subprocess
import sys
import unittest
from concurrent.futures import ThreadPoolExecutor

from launch import SOURCE, use_library

WRONG = [  # what the dummy does, the check that it fails, the reason
    ("stranger", "joins", "without"),
    ("nameless", "declares what the role needs", "'blood_force' from fluid to mech (fluid declares no such output)"),
    ("other_unit", "units", "is sent by fluid in 'mN', but expected by mech in 'N'"),
    ("shifted", "points conform", "is 0.00173205 m away"),
    ("lingers", "ends when told", "all participants to end"),
    ("accumulates", "iterations start from the old state", "of its range between two solves of step"),
    ("forgets", "a restart gives the same bits", "after a restart from step 20"),
    ("swallows", "what is not finite is refused", "it goes on with NaN from mech"),
]


def check(command, role):
    return subprocess.run([sys.executable, SOURCE / "tools/check.py", command, "--role", role], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, check=False)


ROLES = ("ep", "mech", "ale", "fluid")
AT_ONCE = 3  # most of a check is sleep: partners that take their time, deadlines


class Conformance(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        use_library()
        with ThreadPoolExecutor(AT_ONCE) as pool:
            ours = {role: pool.submit(check, role + "_solver", role) for role in ROLES}
            wrong = {mischief: pool.submit(check, f"{sys.executable} {SOURCE / 'tests/coupling/wrong_fluid.py'} {mischief}", "fluid")
                     for mischief, _, _ in WRONG}
        cls.ours, cls.wrong = ({key: run.result() for key, run in runs.items()} for runs in (ours, wrong))

    def test_ours_pass(self):
        for role, run in self.ours.items():
            with self.subTest(role):
                lines = run.stdout.splitlines()
                self.assertEqual((run.returncode, len(lines)), (0, 12), run.stdout)
                self.assertTrue(all(line.startswith("yes ") for line in lines), run.stdout)

    def test_whoever_does_something_wrong_is_told_what(self):
        for mischief, failed, reason in WRONG:
            with self.subTest(mischief):
                run = self.wrong[mischief]
                self.assertEqual(run.returncode, 1, run.stdout)
                told = [line for line in run.stdout.splitlines() if line.startswith("NO  ")]
                self.assertEqual(len(told), 1, run.stdout)
                self.assertTrue(told[0].startswith(f"NO  {failed}: "), run.stdout)
                self.assertIn(reason, told[0])


if __name__ == "__main__":
    unittest.main(verbosity=2)
