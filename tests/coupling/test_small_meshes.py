"""Any mesh on any ranks has the numbers of one rank: meshes of one cell on three ranks, where some have no cells, nodes,
interface or constraints; a ventricle of tetrahedra."""
import csv
import tempfile
import unittest
from pathlib import Path

import numpy as np
from launch import SOURCE, run_crowded

PISTON = SOURCE / "configs/benchmarks/piston/efs1.yaml"
SLAB = SOURCE / "configs/benchmarks/niederer2011/slab.yaml"
VENTRICLE = SOURCE / "configs/ideal_lv"
TIGHT = ["electrophysiology.tolerance=1e-12", "fluid.tolerance=1e-12", "lifting.tolerance=1e-12",
         "mechanics.solver.residual_tolerance=1e-10", "mechanics.solver.linear_tolerance=1e-6"]
ONE_CELL = ["piston.cells_across=1", "piston.cells_column=1", "piston.cells_fluid=1"]


class SmallMeshes(unittest.TestCase):
    def table(self, scene, ranks, settings, columns):
        with tempfile.TemporaryDirectory() as folder:
            words = [word for setting in settings for word in ("--set", setting)]
            launch = run_crowded(scene, folder, ranks, "--out", "out", *words)
            self.assertEqual(launch.code, 0, launch.output)
            with open(Path(folder) / "out/history.csv", encoding="utf-8") as file:
                rows = list(csv.DictReader(file))
            return {column: np.array([float(row[column]) for row in rows]) for column in columns}

    def compare(self, scene, settings, columns, ranks=(1, 3)):
        few, many = (self.table(scene, n, settings, columns) for n in ranks)
        for column, values in few.items():
            np.testing.assert_allclose(many[column], values, rtol=1e-6, atol=1e-9 * np.abs(values).max(), err_msg=column)
        return few

    def test_a_piston_of_two_cells_with_each_scheme(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        scene = Path(folder.name) / "merged.yaml"
        scene.write_text(f"base: {PISTON}\ncoupling: {{scheme: E1FSinf}}\n"
                         "participants: {mech: , fluid: , fsi: {program: fsi_solver, ranks: 1}}\n")
        columns, end = ["volume [m^3]", "mean_pressure [Pa]"], ["time.end=1 ms", "output.every=1 ms"]
        for name, path, settings in [("EFS1-corrected", PISTON, ["scheme=EFS1-corrected", "alpha=auto"]),
                                     ("E1FS3", PISTON, ["scheme=E1FS", "iterations=3", "acceleration=anderson"]),
                                     ("E1FSinf", scene, [])]:
            with self.subTest(name):
                self.compare(path, ONE_CELL + end + settings, columns)

    def test_the_piston_whose_second_rank_of_blood_has_no_node(self):
        settings = ["piston.cells_across=1", "piston.cells_column=3", "piston.cells_fluid=1", "time.end=2 ms"]
        few = self.compare(PISTON, settings, ["volume [m^3]", "mean_pressure [Pa]"], ranks=(1, 2))
        self.assertGreater(few["mean_pressure [Pa]"][-1], 0)

    def test_a_ventricle_of_tetrahedra_with_quadratic_ones_for_electrophysiology(self):
        settings = ["geometry.cells=tetrahedra", "electrophysiology.degree=2", "electrophysiology.refinements=0",
                    "mesh=MXS", "time.end=1 ms", "output.every=1 ms", *TIGHT]
        for scene in "tetrahedra.yaml", "e1fsinf.yaml":
            with self.subTest(scene):
                few = self.compare(VENTRICLE / scene, settings, ["volume [m^3]", "mean_pressure [Pa]"], ranks=(1, 2))
                self.assertGreater(few["volume [m^3]"][-1], 1e-4)

    def test_tissue_of_one_cell(self):
        settings = ["slab.size=[1 mm, 1 mm, 1 mm]", "slab.cell=1 mm", "time.end=1 ms", "output.every=1 ms"]
        for preconditioner in "ilu", "amg":
            with self.subTest(preconditioner):
                self.table(SLAB, 3, [*settings, f"electrophysiology.preconditioner={preconditioner}"], ["time [s]"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
