"""docs/own_code.md: its commands alone make a participant of each example, outside of the source and against what is installed."""
import csv
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from launch import BIN, SOURCE, unless_sanitized

sys.path.insert(0, str(SOURCE / "api"))
import generate  # noqa: E402

DOCUMENT = (SOURCE / "docs/own_code.md").read_text()


def commands():
    return re.findall(r"^```sh\n(.*?)^```$", DOCUMENT, re.S | re.M)


def history(folder):
    with open(folder / "history.csv") as file:
        rows = list(csv.DictReader(file))
    return {title.split(" ")[0]: [row[title] for row in rows] for title in rows[0]}


@unless_sanitized
class OwnCode(unittest.TestCase):
    def test_listings_are_the_examples_and_tables_are_those_of_the_header(self):
        self.assertEqual(generate.renewed(DOCUMENT), DOCUMENT, "run api/generate.py document docs/own_code.md")

    def test_the_commands_of_the_page_work_and_all_languages_give_the_same(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder).resolve()
            (folder / "own").mkdir()
            script = "set -eu\n" + "".join(commands()).replace("build/release", str(BIN.parent))
            run = subprocess.run(["bash", "-c", script], cwd=folder / "own", stdin=subprocess.DEVNULL,
                                 env={**self.environment(), "P": str(folder / "prefix")},
                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
            self.assertEqual(run.returncode, 0, run.stdout)
            python = history(folder / "own/in_python")
            self.assertGreater(float(python["highest_calcium"][-1]), 0.3)
            for language in ("in_c", "in_cpp", "in_fortran"):
                other = history(folder / "own" / language)
                for name in ("highest_calcium", "min_J"):
                    for one, two in zip(python[name], other[name]):
                        self.assertAlmostEqual(float(one), float(two), delta=1e-9, msg=f"{language}, {name}")

    @staticmethod
    def environment():
        kept = {name: value for name, value in os.environ.items() if not name.startswith("HEARTBUS_")}
        return {**kept, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}

    def test_the_library_needs_mpi_only_and_hides_its_inside(self):
        library = next((BIN.parent / "lib").glob("libheartbus.so.*.*.*"))
        needed = subprocess.run(["readelf", "-d", library], stdout=subprocess.PIPE, text=True, check=True).stdout
        names = re.findall(r"\(NEEDED\).*\[lib([\w+-]+)\.so", needed)
        self.assertLessEqual(set(names), {"mpi_cxx", "mpi", "stdc++", "m", "gcc_s", "c", "ld-linux-x86-64"})
        symbols = subprocess.run(["nm", "-D", "--defined-only", library], stdout=subprocess.PIPE, text=True,
                                 check=True).stdout
        shown = {line.split()[-1].split("@")[0] for line in symbols.splitlines()} - {"HEARTBUS_1"}
        self.assertEqual(shown, {function.name for function in generate.read().functions})

    def test_the_library_is_part_of_another_build(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            (folder / "CMakeLists.txt").write_text(
                "cmake_minimum_required(VERSION 3.25)\nproject(other C CXX)\n"
                "find_package(MPI REQUIRED COMPONENTS C)\n"
                f"add_subdirectory({SOURCE} heartbus)\nadd_executable(wave {SOURCE}/examples/wave/wave.c)\n"
                "target_link_libraries(wave PRIVATE heartbus::heartbus MPI::MPI_C m)\n")
            run = subprocess.run("cmake -G Ninja -S . -B b -DCMAKE_BUILD_TYPE=None && ninja -C b wave", shell=True, cwd=folder,
                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
            self.assertEqual(run.returncode, 0, run.stdout)


if __name__ == "__main__":
    unittest.main(verbosity=2)
