"""Any mesh on any ranks has the numbers of one rank: meshes of one cell on three ranks, where some have no cells, nodes,
interface or constraints; a ventricle of tetrahedra."""
import csv
import tempfile
import unittest
from pathlib import Path

import numpy as np
from launch import SOURCE, run_scene

PISTON = SOURCE / "configs/benchmarks/piston/efs1.yaml"
SLAB = SOURCE / "configs/benchmarks/niederer2011/slab.yaml"
VENTRICLE = SOURCE / "configs/ideal_lv"
TIGHT = ["electrophysiology.tolerance=1e-12", "fluid.tolerance=1e-12", "lifting.tolerance=1e-12",
         "mechanics.solver.residual_tolerance=1e-10", "mechanics.solver.linear_tolerance=1e-6"]
ONE_CELL = ["piston.cells_across=1", "piston.cells_column=1", "piston.cells_fluid=1"]


class SmallMeshes(unittest.TestCase):
    def table(self, scene, settings, columns, ranks=()):
        """On one rank each, but for those named."""
        with tempfile.TemporaryDirectory() as folder:
            settings = [*settings, *(f"{name}.ranks={n}" for name, n in ranks)]
            words = [word for setting in settings for word in ("--set", setting)]
            launch = run_scene(scene, folder, "--out", "out", *words, *(() if ranks else ("--ranks", "1")))
            self.assertEqual(launch.code, 0, launch.output)
            with open(Path(folder) / "out/history.csv", encoding="utf-8") as file:
                rows = list(csv.DictReader(file))
            return {column: np.array([float(row[column]) for row in rows]) for column in columns}

    def compare(self, scene, settings, columns, **ranks):
        """One rank each with these ranks, the others on one."""
        few, many = (self.table(scene, settings, columns, chosen) for chosen in ((), ranks.items()))
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
        for name, path, settings, ranks in [
            ("EFS1-corrected", PISTON, ["scheme=EFS1-corrected", "alpha=auto"], {"ale": 3, "mech": 3, "fluid": 3}),
            ("E1FS3", PISTON, ["scheme=E1FS", "iterations=3", "acceleration=anderson"], {"mech": 3, "fluid": 3}),
            ("E1FSinf", scene, [], {"fsi": 3})]:
            with self.subTest(name):
                self.compare(path, ONE_CELL + end + settings, columns, **ranks)

    def test_the_piston_whose_second_rank_of_blood_has_no_node(self):
        settings = ["piston.cells_across=1", "piston.cells_column=3", "piston.cells_fluid=1", "time.end=2 ms"]
        few = self.compare(PISTON, settings, ["volume [m^3]", "mean_pressure [Pa]"], fluid=2)
        self.assertGreater(few["mean_pressure [Pa]"][-1], 0)

    def test_a_ventricle_of_tetrahedra_with_quadratic_ones_for_electrophysiology(self):
        settings = ["geometry.cells=tetrahedra", "electrophysiology.degree=2", "electrophysiology.refinements=0",
                    "mesh=MXS", "time.end=1 ms", "output.every=1 ms", *TIGHT]
        for scene, ranks in (("tetrahedra.yaml", {"ep": 2, "mech": 2, "ale": 2, "fluid": 2}),
                             ("e1fsinf.yaml", {"ep": 1, "ale": 1, "fsi": 2})):
            with self.subTest(scene):
                few = self.compare(VENTRICLE / scene, settings, ["volume [m^3]", "mean_pressure [Pa]"], **ranks)
                self.assertGreater(few["volume [m^3]"][-1], 1e-4)

    def test_tissue_of_one_cell(self):
        settings = ["slab.size=[1 mm, 1 mm, 1 mm]", "slab.cell=1 mm", "time.end=1 ms", "output.every=1 ms"]
        for preconditioner in "ilu", "amg":
            with self.subTest(preconditioner):
                self.table(SLAB, [*settings, f"electrophysiology.preconditioner={preconditioner}"], ["time [s]"], [("ep", 3)])


if __name__ == "__main__":
    unittest.main(verbosity=2)
