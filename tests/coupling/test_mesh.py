"""Meshes of other programs become a mesh file, or one message says what, where and how to mend it."""
import csv
import importlib.util
import shutil
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np
from launch import BIN, SOURCE, Forked, Launch, run_crowded
from PIL import Image

sys.path.insert(0, str(SOURCE / "tools"))
from foreign_files import write_carp, write_gmsh, write_hexahedra, write_svmultiphysics, write_xdmf  # noqa: E402
# all that tools/mesh imports, so that its forks find it loaded
from meshing import build, checks, fibres, labels, native, picture, read, report, topology  # noqa: E402, F401

DATA = SOURCE / "tests/data/meshes"
SOLID, FLUID = DATA / "lv_solid.msh", DATA / "lv_fluid.msh"


class Meshes(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name)
        self.parts = native.read(DATA / "lv.h5")

    def tool(self, *words):
        return Forked(SOURCE / "tools/mesh", words, self.folder)

    def imported(self, *words):
        """(parts, output)"""
        launch = self.tool("import", *words, "-o", "out.h5")
        self.assertEqual(launch.code, 0, launch.output)
        return native.read(self.folder / "out.h5"), launch.output

    def refused(self, *words):
        launch = self.tool(*words)
        self.assertEqual(launch.code, 2, launch.output)
        self.assertNotIn("Traceback", launch.output)
        lines = [line for line in launch.output.splitlines() if line.startswith("error: ")]
        self.assertEqual(len(lines), 1, launch.output)
        return lines[0]

    def assert_same(self, parts, part_names=("solid", "fluid")):
        """The same places, volumes and areas as the ventricle of the repository."""
        for name in part_names:
            here, there = parts[name], self.parts[name]
            self.assertEqual(len(here.cells), len(there.cells))
            volume = [topology.volumes(p.kind, p.points, p.cells).sum() for p in (here, there)]
            self.assertAlmostEqual(volume[0] / volume[1], 1, 6)
            self.assertEqual(sorted(here.label_names), sorted(there.label_names))
            for label in there.label_names:
                self.assertEqual(len(here.faces_of(label)), len(there.faces_of(label)), label)


@unittest.skipUnless(importlib.util.find_spec("vtk") and shutil.which("xvfb-run"), "no VTK for Python, or no xvfb")
class Pictures(Meshes):
    def test_a_mesh_is_drawn(self):
        launch = Launch([SOURCE / "tools/mesh", "check", DATA / "lv.h5", "--picture", "lv.png"], self.folder)
        self.assertEqual(launch.code, 0, launch.output)
        with Image.open(self.folder / "lv.png") as picture:
            self.assertRegex(picture.text["Source"], "^a mesh, regions ")


class Imports(Meshes):
    def test_the_pair_of_gmsh_is_the_mesh_file_of_the_repository(self):
        parts, said = self.imported(SOLID, FLUID, "--unit", "mm")
        self.assertIn("label 'endo_wall' is taken for interface", said)
        self.assertIn("cavity 116.7 mL, closed", said)
        self.assertIn("interfaces: the same 138 nodes and 248 faces", said)
        self.assertIn("geometry: {shape: file, mesh: out.h5}", said)
        for name, part in parts.items():
            np.testing.assert_array_equal(part.points, self.parts[name].points)
            np.testing.assert_array_equal(part.cells, self.parts[name].cells)
        self.assertEqual(self.tool("check", "out.h5").code, 0)

    def test_mirrored_cells_are_turned_and_said(self):
        mirrored = topology.mirrored("tetrahedra", self.parts["solid"].cells)
        write_xdmf(self.folder / "lv_domain.xdmf", self.parts["solid"], mirrored)
        labels = [f"{i}={name}" for i, name in enumerate(self.parts["solid"].label_names)]
        parts, said = self.imported("lv_domain.xdmf", "--unit", "mm", "--label", *labels)
        self.assertIn("all cells: 1,838 were negatively oriented and turned round", said)
        self.assert_same(parts, ["solid"])

    def test_folders_of_svmultiphysics_by_number_and_by_place(self):
        for with_ids in (True, False):
            for name, part in self.parts.items():
                write_svmultiphysics(self.folder / name, part, with_ids)
            parts, said = self.imported("solid", "fluid", "--unit", "cm")
            self.assertIn("region region_7: 1,838 cells", said)
            self.assert_same(parts)

    def test_fibres_by_node_are_the_same_whatever_their_sense(self):
        write_svmultiphysics(self.folder / "solid", self.parts["solid"], True)
        parts, _ = self.imported("solid", "--unit", "cm", "--fibres", "fibre", "--sheets", "sheet")
        f, s = parts["solid"].fibres.transpose(1, 0, 2)
        np.testing.assert_allclose(np.abs(f @ [0.6, 0.8, 0]), 1, atol=1e-12)
        np.testing.assert_allclose(np.abs(s @ [0.8, -0.6, 0]), 1, atol=1e-12)
        self.assertIn("no array 'fib'", self.refused("import", "solid", "--unit", "cm", "--fibres", "fib", "-o", "x.h5"))
        self.assertRegex(self.refused("import", "solid", "--unit", "cm", "--fibres", "fibre", "--sheets", "fibre", "-o", "x.h5"),
                         r"not orthogonal: the worst is cell \d+ around \(.* mm, where f.s is 1")

    def test_carp_brings_its_unit_and_its_fibres(self):
        write_carp(self.folder / "lv", self.parts["solid"])
        parts, said = self.imported("lv.elem")
        self.assertIn("fibres: one pair a cell", said)
        self.assert_same(parts, ["solid"])
        np.testing.assert_allclose(parts["solid"].fibres[:, 0], np.tile([0.6, 0.8, 0], (1838, 1)), atol=1e-12)
        np.testing.assert_allclose((parts["solid"].fibres.prod(axis=1)).sum(axis=1), 0, atol=1e-9)

    def test_hexahedra_of_vtk_become_lexicographic(self):
        write_hexahedra(self.folder / "cube.vtu", 3, 60, mirrored=[4, 13])
        parts, said = self.imported("cube.vtu", "--unit", "mm", "--label", "9=interface")
        self.assertIn("of 27 cells: 2 were negatively oriented", said)
        cube = parts["solid"]
        np.testing.assert_allclose(topology.volumes(cube.kind, cube.points, cube.cells), 8e-6)
        np.testing.assert_allclose(topology.quality(cube.kind, cube.points, cube.cells), 1)
        self.assertEqual(len(cube.faces_of("interface")), 54)
        np.testing.assert_allclose(np.linalg.norm(topology.areas(cube.points, cube.faces), axis=1), 4e-4)

    def test_one_file_with_wall_and_blood_is_split_at_its_regions(self):
        write_gmsh(self.folder / "whole.msh", self.parts)
        parts, _ = self.imported("whole.msh", "--blood", "fluid", "--unit", "m")
        self.assert_same(parts)
        self.assertEqual(parts["fluid"].region_names, ["fluid"])

    def test_the_realistic_ventricle_has_human_dimensions(self):
        launch = self.tool("realistic", "--size", "coarse", "-o", "real.h5")
        self.assertEqual(launch.code, 0, launch.output)
        parts = native.read(self.folder / "real.h5")
        self.assertEqual(parts["solid"].region_names, ["muscle", "ring"])
        self.assertEqual(set(parts["fluid"].label_names), {"interface", "mitral", "aortic"})
        for part, n, volume in ((parts["solid"], 10e3, 124e-6), (parts["fluid"], 12e3, 93e-6)):
            self.assertLess(abs(len(part.cells) / n - 1), 0.15)
            self.assertAlmostEqual(topology.volumes(part.kind, part.points, part.cells).sum() / volume, 1, 1)
            self.assertGreater(topology.quality(part.kind, part.points, part.cells).min(), 0.1)


class Runs(Meshes):
    SITES = "[{centre: [2.4 mm, 23.3 mm, -22.5 mm], radius: 12 mm}]"

    def launched(self, mesh, ranks=1):
        (self.folder / "scene.yaml").write_text(
            f"base: {SOURCE / 'configs/ideal_lv/efs1.yaml'}\nscene: own\ngeometry: {{shape: file, mesh: {mesh}}}\n"
            f"electrophysiology: {{degree: 2, refinements: 0, stimulus: {{sites: {self.SITES}}}}}\n"
            "time: {end: 2 ms}\noutput: {every: 0 s, checkpoint: {every: 0 s}}\n")
        return run_crowded(self.folder / "scene.yaml", self.folder, ranks, "--out", f"on_{ranks}")

    def history(self, ranks):
        with open(self.folder / f"on_{ranks}/history.csv", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def test_the_pair_runs_the_same_on_one_rank_and_on_two(self):
        for ranks in (1, 2):
            launch = self.launched(DATA / "lv.h5", ranks)
            self.assertEqual(launch.code, 0, launch.output)
        for one, two in zip(self.history(1), self.history(2)):
            self.assertAlmostEqual(float(one["volume [m^3]"]) / float(two["volume [m^3]"]), 1, 7)
        self.assertGreater(float(self.history(1)[0]["volume [m^3]"]), 1.1 * 116.7e-6)  # inflated to the atrial pressure

    def test_what_a_program_finds_wrong_in_the_mesh_ends_the_launch(self):
        (self.folder / "nan.h5").write_bytes((DATA / "lv.h5").read_bytes())
        with h5py.File(self.folder / "nan.h5", "r+") as file:
            file["fluid/points"][3] = np.nan
        launch = self.launched("nan.h5", 2)
        self.assertEqual(launch.code, 8, launch.output)
        self.assertIn("fluid: node 3 is at nan m", launch.output)
        self.assertEqual(launch.orphans, [])


class BadInput(Meshes):
    def changed(self, name, file, change):
        path = self.folder / name
        path.write_text(change(file.read_text()))
        return path

    def test_units(self):
        self.assertIn("in which unit? It measures 94.32: add --unit mm", self.refused("import", SOLID, FLUID, "-o", "x.h5"))
        said = self.refused("import", SOLID, FLUID, "--unit", "cm", "-o", "x.h5")
        self.assertIn("with --unit mm it would be 117 mL", said)

    def test_labels(self):
        said = self.refused("import", SOLID, FLUID, "--unit", "mm", "--label", "base=", "-o", "x.h5")
        self.assertRegex(said, r"open: 113 of 744 faces of the boundary have no label.*around \(15.54, 27.97, 20\) mm")
        said = self.refused("import", SOLID, FLUID, "--unit", "mm", "--label", "endo_wall=inside", "-o", "x.h5")
        self.assertIn("no label `interface`", said)
        self.assertIn("there are aortic_valve", self.refused("import", SOLID, FLUID, "--unit", "mm", "--label", "a=b", "-o", "x.h5"))

    def test_interfaces_that_do_not_conform(self):
        moved = self.changed("moved.msh", FLUID, lambda text: text.replace("\n8 -15.9695864 ", "\n8 -14.4695864 "))
        said = self.refused("import", SOLID, moved, "--unit", "mm", "-o", "x.h5")
        self.assertIn("the worst is node 7 at (-14.47, 17.63, 20) mm, 1.5 mm from the nearest", said)
        self.assertIn("one mesh given twice", self.refused("import", SOLID, SOLID, "--unit", "mm", "-o", "x.h5"))

    def test_cells(self):
        part = self.parts["solid"]
        points = part.points.copy()
        points[part.cells[40]] = points[part.cells[40]].mean(axis=0) + 1e-3 * np.eye(4, 3) @ np.diag([1, 1, 0])
        part.points = points
        write_xdmf(self.folder / "flat.xdmf", part, part.cells)
        self.assertRegex(self.refused("import", "flat.xdmf", "--unit", "mm", "--rest", "all", "-o", "x.h5"),
                         r"cell 40 around \(.*\) mm is flat")

    def test_several_parts_and_cracks(self):
        part = self.parts["solid"]
        n = len(part.points)
        part.points = np.concatenate([part.points, part.points + [0.2, 0, 0]])
        write_xdmf(self.folder / "two.xdmf", part, np.concatenate([part.cells, part.cells[:100] + n]))
        self.assertRegex(self.refused("import", "two.xdmf", "--unit", "mm", "--rest", "all", "-o", "x.h5"),
                         r"parts that share no node, of 1,838,")

    def test_fibres_must_be_unit(self):
        write_carp(self.folder / "lv", self.parts["solid"], length=1.2, odd=17)
        said = self.refused("import", "lv.elem", "-o", "x.h5")
        self.assertRegex(said, r"'fibre' is not unit: the worst is cell 17 around .*, of length 1.2 \(1 of 1,838")

    def test_damaged_files(self):
        text = SOLID.read_text()
        damaged = {"truncated": text[:40000], "huge": text.replace("\n530\n", "\n53000000000\n"), "noise": "\x00\x7f" * 500,
                   "node": text.replace("\n1 2 2 101 101 25 ", "\n1 2 2 101 101 99999 ")}
        for name, content in damaged.items():
            (self.folder / f"{name}.msh").write_text(content)
            self.assertIn(f"{name}.msh", self.refused("import", f"{name}.msh", "--unit", "mm", "-o", "x.h5"))
        write_svmultiphysics(self.folder / "solid", self.parts["solid"], False)
        grid = (self.folder / "solid/mesh-complete.mesh.vtu").read_bytes()
        damaged = {"cut": grid[:len(grid) // 2], "huge": grid.replace(b'Points="530"', b'Points="99999999999"'), "empty": b""}
        for name, content in damaged.items():
            (self.folder / f"{name}.vtu").write_bytes(content)
            self.assertIn(f"{name}.vtu", self.refused("import", f"{name}.vtu", "--unit", "cm", "-o", "x.h5"))
        nan = self.changed("nan.msh", SOLID, lambda text: text.replace("\n1 15.2405958 ", "\n1 nan "))
        self.assertIn("node 0 is at (nan, ", self.refused("import", nan, "--unit", "mm", "-o", "x.h5"))
        self.assertFalse((self.folder / "x.h5").exists())

    def test_damaged_mesh_files(self):
        whole = (DATA / "lv.h5").read_bytes()
        for n in (0, 100, 30000, len(whole) - 1):
            (self.folder / "cut.h5").write_bytes(whole[:n])
            self.assertIn("cut.h5", self.refused("check", "cut.h5"))
        (self.folder / "nan.h5").write_bytes(whole)
        with h5py.File(self.folder / "nan.h5", "r+") as file:
            file["fluid/points"][3] = np.nan
        self.assertIn("fluid: node 3 is at (nan, nan, nan)", self.refused("check", "nan.h5"))
        with h5py.File(self.folder / "nan.h5", "r+") as file:
            file["fluid/points"][3] = 0, 0, 0
            file["solid/cells"][5] = file["solid/cells"][5][[1, 0, 2, 3]]
        self.assertIn("solid: cell 5 around", self.refused("check", "nan.h5"))

    def test_the_command_itself(self):
        launch = Launch([SOURCE / "tools/mesh", "check", DATA / "lv.h5"], self.folder)
        self.assertEqual(launch.code, 0, launch.output)
        self.assertIn("interfaces: the same 138 nodes and 248 faces", launch.output)
        launch = Launch([SOURCE / "tools/mesh", "import", SOLID, FLUID, "-o", "x.h5"], self.folder)
        self.assertEqual((launch.code, launch.output.count("\n")), (2, 1), launch.output)

    def test_scenes_name_the_import(self):
        scene = self.folder / "scene.yaml"
        scene.write_text(f"geometry: {{shape: file, mesh: {SOLID}}}\n")
        launch = Launch([BIN / "coupler", scene, "--validate"], self.folder)
        self.assertEqual(launch.code, 2)
        self.assertIn("tools/mesh import", launch.output)


if __name__ == "__main__":
    unittest.main(verbosity=2)
