"""Rules of the source code that no compiler checks."""
import os
import re
import unittest
from pathlib import Path

SOURCE = Path(os.environ["HEARTBUS_SOURCE"])


def sources(*folders):
    return [file for folder in folders for pattern in ("*.h", "*.cpp") for file in (SOURCE / folder).rglob(pattern)]


def with_pattern(files, pattern):
    return [str(file.relative_to(SOURCE)) for file in files if re.search(pattern, file.read_text(encoding="utf-8"))]


ALL = ["api", "common", "coupler", "replay", "stand_in", *(folder.name for folder in SOURCE.glob("*_solver"))]


class Conventions(unittest.TestCase):
    def test_only_one_class_knows_the_world_of_all_programs(self):
        users = with_pattern([*sources(*ALL), *(SOURCE / "tools").rglob("*.py")], "MPI_COMM_WORLD")
        self.assertEqual([user for user in users if not user.startswith("common/bus/world.")], [])

    def test_bus_coupler_and_scene_know_no_deal_ii(self):
        files = sources("common/base", "common/bus", "common/mapping", "common/units", "common/config", "common/settings", "scene",
                        "common/io", "common/geometry", "api", "coupler", "replay", "stand_in", "ep_solver/ionic", "mech_solver/constitutive", "mech_solver/active")
        self.assertEqual(with_pattern(files, r"#include <deal\.II"), [])

    def test_the_library_leaves_the_process_of_others_alone(self):
        of_our_programs = {"common/bus/" + name + ".cpp" for name in ("process", "placement", "participant", "coordinator")}
        forbidden = r"\b(_?exit|quick_exit|signal|sigaction|setenv|putenv|prctl|sched_setaffinity|setitimer|atexit)\s*\("
        users = with_pattern(sources("api", "common/bus", "common/mapping"), forbidden)
        self.assertEqual(sorted(set(users) - of_our_programs), [])

    def test_no_solver_knows_a_scheme(self):
        """What differs from scheme to scheme comes as tasks or plain settings: common/interface/README.md."""
        settings = (SOURCE / "common/settings/coupling.cpp").read_text(encoding="utf-8")
        names = re.findall(r'"([\w-]+)"', re.search(r'choice\("scheme", scheme,\s*\{(.*?)\}', settings, flags=re.S)[1])
        self.assertIn("EFS1", names)
        own_words = {"adaptive", "circulation", "custom"}  # of step sizes; a participant; a mesh
        words = [rf"\b{re.escape(name)}\b" for name in names if name not in own_words]
        pattern = "|".join([*words, r"\bE1FS", r"scheme\s*[!=]=", r"\bCouplingParameters\b", r"\bscene\.coupling\b"])
        folders = [name for name in ALL if name not in ("coupler", "common")]
        files = [file for file in sources(*folders, "common") if file.parent.name != "settings" or "common" not in str(file)]
        self.assertEqual(with_pattern(files, pattern), [])

    def test_a_scheme_is_a_function_of_at_most_twenty_lines(self):
        text = (SOURCE / "coupler/sequence/schemes.cpp").read_text(encoding="utf-8")
        lengths = {name: body.count("\n") + 1
                   for body, name in re.findall(r"^(Nodes (\w+)\(.*?^})", text, flags=re.S | re.M)}
        self.assertTrue({"EFS1", "E1FS", "E1FS_until", "E1FSinf", "EFS1_corrected", "one_way"} <= set(lengths))
        self.assertEqual({name: n for name, n in lengths.items() if n > 20}, {})

    def test_imports_point_downwards(self):
        """A folder includes from itself and from those before it, solvers from none beside them but fsi_solver."""
        order = ["common/base", "common/simd", "common/mapping", "common/units", "common/bus", "common/log", "common/io",
                 "common/config", "common/geometry", "common/settings", "common/nonlinear", "mech_solver/constitutive",
                 "ep_solver/ionic", "mech_solver/active", "fluid_solver/models",
                 "ep_solver/settings", "mech_solver/settings", "ale_solver/settings", "fluid_solver/settings", "scene",
                 "common/interface", "common/fem",
                 "common/linear_algebra", "common/fibres", "common/interface/nodal", "ep_solver", "mech_solver", "ale_solver",
                 "fluid_solver", "fsi_solver", "cavity_solver", "coupler/sequence", "coupler", "replay", "stand_in", "api"]
        beside = {(a, b) for a in order for b in order if a.endswith("_solver") and b.endswith("_solver") and a != b}
        beside -= {("fsi_solver", "mech_solver"), ("fsi_solver", "fluid_solver")}
        upwards = []
        for file in sources(*ALL, "scene"):
            folder = str(file.parent.relative_to(SOURCE))
            self.assertIn(folder, order)
            for name in re.findall(r'#include "([^"]+)"', file.read_text(encoding="utf-8")):
                other = str(Path(name).parent)
                mains_read_the_scene = other == "scene" and file.name.startswith("main")
                below = order.index(other) <= order.index(folder) if other in order else other == "."
                if (not below or (folder, other) in beside or
                        (other == "scene" and folder.endswith("_solver") and not mains_read_the_scene)):
                    upwards.append(f"{file.relative_to(SOURCE)} includes {name}")
        self.assertEqual(upwards, [])

    def test_lines_are_short(self):
        files = [*sources(*ALL, "scene", "tests"), *(SOURCE / "api").glob("*.hpp"), *(SOURCE / "examples").rglob("*.c*")]
        long = [f"{file.relative_to(SOURCE)}:{number}" for file in files
                for number, line in enumerate(file.read_text(encoding="utf-8").split("\n"), 1) if len(line) > 120]
        self.assertEqual(long, [])

    def test_headers_are_included_once(self):
        headers = [file for file in sources(*ALL) if file.suffix == ".h"]
        once = re.compile(r"#pragma once|#ifndef HEARTBUS_H\n#define HEARTBUS_H\n")  # the latter is C
        self.assertEqual(sorted(str(f.relative_to(SOURCE)) for f in headers if not once.search(f.read_text())), [])


if __name__ == "__main__":
    unittest.main(verbosity=2)
