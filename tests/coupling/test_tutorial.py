"""docs/tutorial.md: its commands, in their order, in an empty folder outside of the source, against what is installed; the
user has no rights beyond that folder where this can be had."""
import csv
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from documents import Document
from launch import BIN, SOURCE, Launch

PAGE = Document(SOURCE / "docs/tutorial.md")
NOBODY = 65534


def scripts():
    """(what the one who builds types, what users type)."""
    first, *others = ["\n".join(lines) for kind, lines in PAGE.blocks if kind == "sh"]
    return first.replace("build/release", str(BIN.parent)), "\n".join(["set -eu", *others])


def as_user(words):
    """The words that run these without rights, and why that cannot be had."""
    if os.getuid() != 0:
        return words, ""
    if not shutil.which("setpriv"):
        return words, "there is no setpriv here (Debian: util-linux)"
    user = ["setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups"]
    tried = subprocess.run([*user, "true"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    return (words, f"users cannot be changed here: {tried.stdout}") if tried.returncode else ([*user, *words], "")


class Tutorial(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        top, cls.own = Path(temporary.name).resolve(), Path(temporary.name).resolve() / "own"
        cls.own.mkdir()
        build, use = scripts()
        variables = {"PATH": f"{Path(sys.executable).parent}:/usr/local/bin:/usr/bin:/bin", "P": str(top / "prefix"), "LC_ALL": "C.UTF-8"}
        subprocess.run(["bash", "-c", build], env=variables, stdout=subprocess.DEVNULL, check=True)
        user, cls.obstacle = as_user(["bash", "-c", use])
        if user[0] == "setpriv":
            top.chmod(0o755)
            os.chown(cls.own, NOBODY, NOBODY)
        own = [f"{name}={value}" for name, value in {**variables, "HOME": str(cls.own), "TMPDIR": "/tmp"}.items()]
        kept = [f"{name}={value}" for name, value in os.environ.items()
                if name.startswith(("OMPI_", "ASAN_", "HEARTBUS_TEST", "HEARTBUS_LIBRARY"))]
        cls.launch = Launch(["env", "-i", *kept, *own, *user], cls.own)

    def history(self, name):
        with open(self.own / f"results/{name}/history.csv") as file:
            return list(csv.DictReader(file))

    def test_every_command_works(self):
        self.assertEqual(self.launch.code, 0, self.launch.output[-3000:])
        self.assertEqual(self.launch.orphans, [])

    def test_without_rights(self):
        if self.obstacle:
            self.skipTest(self.obstacle)
        owners = {file.stat().st_uid for file in self.own.rglob("*")}
        self.assertEqual(owners, {NOBODY if os.getuid() == 0 else os.getuid()})

    def test_a_mistyped_key_is_refused_with_the_nearest(self):
        self.assertIn("did you mean 'alpha'?", self.launch.output)
        self.assertIn("\nrefused\n", self.launch.output)

    def test_numbers_are_those_of_the_page(self):
        small, loose = (json.loads((self.own / f"results/{name}/indicators.json").read_text()) for name in ("small", "loose"))
        said = re.search(r"fraction is ([\d.]+) %.*loses\s+([\d.]+)\s+and\s+([\d.]+) %.*fraction is ([\d.]+) %", PAGE.text, flags=re.S)
        values = (small["EF_percent"], loose["ILI_C_percent"], loose["ILI_R_percent"], loose["EF_percent"])
        for text, value in zip(said.groups(), values):
            place = 10.0 ** -len(text.partition(".")[2])  # one in the last place that the page has
            self.assertAlmostEqual(float(text), value, delta=place, msg="the page says otherwise")
        self.assertTrue(small["beats"][0]["complete"], "the restart has not gone on to the end of the beat")

    def test_what_is_made_is_there(self):
        for name in ("results/small/report/report.html", "comparison/report.html", "results/studies/loss/loss.png", "loop.png",
                     "pictures/deformation.png", "pictures/fibres.png"):
            self.assertGreater((self.own / name).stat().st_size, 5000, name)
        with open(self.own / "results/studies/loss/table.csv") as file:
            errors = {row["run"]: row for row in csv.DictReader(file)}
        self.assertLess(float(errors["a5000"]["error_p"]), float(errors["a2500"]["error_p"]))

    def test_the_own_participant_makes_the_wall_contract(self):
        pressure = [float(row["mean_pressure [Pa]"]) for row in self.history("own")]
        self.assertGreater(max(pressure), 5 * pressure[0])
        before = self.history("small")
        k = next(k for k, row in enumerate(before) if float(row["time [s]"]) > 0.04)
        self.assertGreater(pressure[k], 1.5 * float(before[k]["mean_pressure [Pa]"]))

    def test_what_is_implausible_is_told_with_its_key(self):
        told = re.findall(r"^- (.*)$", self.launch.output, re.M)
        for key in "mechanics.guccione.kappa", "mechanics.active.sarcomere_length", "coupling.alpha":
            self.assertTrue([line for line in told if f"; {key}: " in line], f"{key} is not in {told}")

    def test_a_run_has_all_that_is_looked_at_for_what_is_implausible(self):
        rules = (SOURCE / "tools/reporting/plausibility.py").read_text()
        columns = set(re.findall(r'"(\w+)" in run\.history', rules) + re.findall(r'"(\w+)" not in run\.history', rules))
        self.assertGreater(len(columns), 8)
        self.assertEqual(columns - {name.split(" ")[0] for name in self.history("small")[0]}, set())
        beat = json.loads((self.own / "results/small/indicators.json").read_text())["beats"][0]
        wanted = {"aortic_opens_ms", "mitral_opens_ms", "p_max_mmHg", "ILI_C_percent", "ILI_R_percent", "complete"}
        self.assertEqual(wanted - set(beat), set())


if __name__ == "__main__":
    unittest.main(verbosity=2)
