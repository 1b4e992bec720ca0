"""What pictures show: the whole body as it has moved, each body by its own name, lines that begin within it."""
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np
from launch import SOURCE

sys.path.insert(0, str(SOURCE / "tools"))
try:
    import vtk

    import pictures
    from rendering import Series, drawn_inwards, moved_bounds
except (ImportError, SystemExit) as error:
    vtk = None
    print(f"skipped: {error}")


def block(n):
    """Points and hexahedra of a unit cube."""
    x = np.array([(i, j, k) for k in range(n + 1) for j in range(n + 1) for i in range(n + 1)]) / n
    at = lambda i, j, k: i + (n + 1) * (j + (n + 1) * k)  # noqa: E731
    cells = [[at(i + a, j + b, k + c) for c in (0, 1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
             for k in range(n) for j in range(n) for i in range(n)]
    return x, np.array(cells)


@unittest.skipUnless(vtk, "there is no VTK for Python here (Debian: python3-vtk9)")
class Pictures(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def series(self, motion):
        points, cells = block(3)
        with h5py.File(self.folder / "fluid.h5", "w") as file:
            file["mesh/points"], file["mesh/cells"] = points, cells
            group = file.create_group("000000")
            group.attrs["time"] = 0.0
            group["motion"] = motion(points)
        return Series(self.folder / "fluid.h5")

    def test_a_body_that_has_moved_beyond_its_place_at_rest_is_in_view_whole(self):
        fluid = self.series(lambda x: np.where(x[:, 2:] == 0, [[0, 0, -0.4]], [[0.2, 0, 0]]))
        low, high = moved_bounds(fluid, [0])
        moved = fluid.points + fluid.field("motion", 0)
        self.assertTrue((moved.min(axis=0) > low).all() and (moved.max(axis=0) < high).all())
        self.assertLess(low[2], -0.4)

    def test_only_a_heart_has_an_epicardium(self):
        of_a_heart = ("epicardium", "endocardium and section")
        for shape, rule, captions in (("slab", "constant", ("surface", "section")), ("ideal_left_ventricle", "ellipsoid", of_a_heart),
                                      ("file", "apicobasal", of_a_heart), ("file", "file", ("surface", "section"))):
            (self.folder / "scene.resolved.yaml").write_text(f"geometry: {{shape: {shape}}}\nfibres: {{rule: {rule}}}\n")
            self.assertEqual(pictures.sides(self.folder), captions)

    def test_the_helix_angle_is_that_around_the_hearts_own_axis(self):
        """A cone, its fibres wound by 60 degrees inside and -60 outside; upright at the origin, and anywhere else."""
        around, up = (values.ravel() for values in np.meshgrid(np.linspace(0, 2 * np.pi, 24, endpoint=False), np.linspace(1, 4, 7)))
        ring, slope = np.column_stack([np.cos(around), np.sin(around), 0 * around]), 0.4
        circumference = np.column_stack([-np.sin(around), np.cos(around), 0 * around])
        meridian = (slope * ring + [0, 0, 1]) / np.hypot(slope, 1)
        x, f, angles = [], [], []
        for radius, angle in ((0.8, 60), (1.2, -60)):
            x.append((radius + slope * up)[:, None] * ring + up[:, None] * [0, 0, 1])
            f.append(np.cos(np.radians(angle)) * circumference + np.sin(np.radians(angle)) * meridian)
            angles.append(np.full(len(up), angle))
        x, f, angles = map(np.concatenate, (x, f, angles))
        f[::2] *= -1  # the same fibre
        turn, _ = np.linalg.qr(np.array([[1.0, 2, 3], [0, 1, 4], [5, 6, 0]]))
        turn *= np.linalg.det(turn)
        np.testing.assert_allclose(pictures.helix_angle(f, x), angles, atol=1e-6)
        np.testing.assert_allclose(pictures.helix_angle(f @ turn.T, x @ turn.T + [3, 2, 1]), angles, atol=1e-6)

    def test_lines_of_the_surface_begin_within_the_body(self):
        grid = self.series(np.zeros_like).grid()
        seeds = drawn_inwards(grid, 0.1)
        points = np.array([seeds.GetPoint(i) for i in range(seeds.GetNumberOfPoints())])
        x = block(3)[0]
        self.assertTrue((points > 0.01).all() and (points < 0.99).all())
        inside = ((x > 0) & (x < 1)).all(axis=1)
        np.testing.assert_allclose(points[inside], x[inside], atol=1e-12)
        self.assertLess(abs(points - x).max(), 0.1 / 3)


if __name__ == "__main__":
    unittest.main(verbosity=2)
