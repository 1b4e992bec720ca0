"""Wall and blood of a mesh file, cut open, with their cells."""
import os
import shutil
import sys

import numpy as np

from .model import Refusal
from .topology import lexicographic

COLOURS = [(0.80, 0.42, 0.40), (0.93, 0.83, 0.55), (0.62, 0.72, 0.50), (0.70, 0.60, 0.75)]
BLOOD = (0.62, 0.78, 0.88)
TYPES = {"tetrahedra": 10, "hexahedra": 12}  # of VTK


def grid(part, chosen):
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk
    cells = part.cells[chosen] if part.kind == "tetrahedra" else lexicographic(part.cells[chosen])
    mesh, points, array = vtk.vtkUnstructuredGrid(), vtk.vtkPoints(), vtk.vtkCellArray()
    points.SetData(numpy_to_vtk(part.points, deep=True))
    offsets = np.arange(len(cells) + 1, dtype=np.int64) * cells.shape[1]
    array.SetData(*(numpy_to_vtk(values, deep=True, array_type=vtk.VTK_ID_TYPE) for values in (offsets, cells.ravel())))
    mesh.SetPoints(points)
    mesh.SetCells(TYPES[part.kind], array)
    return mesh


def bodies(part, colours, cut):
    """The regions of a part in their colours; `cut`: the cells that lie behind the plane through the middle."""
    from rendering import actor, surface
    y = part.points[part.cells].mean(axis=1)[:, 1]
    behind = y > (part.points[:, 1].min() + part.points[:, 1].max()) / 2 if cut else np.ones(len(y), bool)
    return [actor(surface(grid(part, behind & (part.regions == region))), colour=colours[region % len(colours)], edges=True)
            for region in range(len(part.region_names)) if (behind & (part.regions == region)).any()]


def draw(parts, path):
    """Restarts the program under a virtual display where there is none."""
    if not os.environ.get("DISPLAY"):
        if not shutil.which("xvfb-run"):
            raise Refusal("pictures need a display: set DISPLAY or install xvfb")
        os.execvp("xvfb-run", ["xvfb-run", "-a", "-s", "-screen 0 1280x1024x24 -noreset", sys.executable, *sys.argv])
    from rendering import bounds, compose, render
    box = bounds(np.concatenate([part.points for part in parts.values()]))
    solid, fluid = parts.get("solid"), parts.get("fluid")
    panels = []
    if solid:
        panels += [(render(bodies(solid, COLOURS, cut), box), caption) for cut, caption in ((False, "wall"), (True, "cut"))]
    if solid and fluid:
        panels.append((render(bodies(solid, COLOURS, True) + bodies(fluid, [BLOOD], True), box), "with blood"))
    if fluid:
        panels.append((render(bodies(fluid, [BLOOD], False), box), "blood"))
    regions = ", ".join(solid.region_names) if solid else ", ".join(fluid.region_names)
    compose(panels, [], f"{path.stem}: {regions}", path, f"a mesh, regions {regions}")
