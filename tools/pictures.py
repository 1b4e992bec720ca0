#!/usr/bin/env python3
"""Pictures of a run from its fields: fibres, electric potential, blood flow and pressure, deformation.

    tools/pictures.py results/ideal_lv_efs1 [--times 30 60 100 300] [--out FOLDER]

VTK renders the bodies off screen, matplotlib adds titles and colour bars. Without a display it restarts under xvfb-run.
"""
import argparse
import functools
import os
import shutil
import sys
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

from results import MMHG, History

CELL_TYPES = {8: vtk.VTK_HEXAHEDRON, 4: vtk.VTK_TETRA, 10: vtk.VTK_QUADRATIC_TETRA}
BONE = (0.86, 0.84, 0.82)


class Series:
    """One fields/NAME.h5: a mesh and its fields at a number of instants."""

    def __init__(self, path):
        self.file = h5py.File(path, "r")
        self.points = self.file["mesh/points"][:]
        self.cells = self.file["mesh/cells"][:].astype(np.int64)
        self.groups = sorted(name for name in self.file if name != "mesh")
        self.times = np.array([self.file[name].attrs["time"] for name in self.groups])

    def nearest(self, time):
        return int(np.argmin(abs(self.times - time)))

    def field(self, name, instant):
        values = self.file[self.groups[instant]][name][:]
        return values[:, 0] if values.shape[1] == 1 else values

    def has(self, name):
        return name in self.file[self.groups[0]]

    def grid(self, instant=0, motion=None, **fields):
        """The mesh, moved by the field `motion`, with point data."""
        points = self.points + (self.field(motion, instant) if motion else 0)
        grid, vertices, cells = vtk.vtkUnstructuredGrid(), vtk.vtkPoints(), vtk.vtkCellArray()
        vertices.SetData(numpy_to_vtk(points, deep=True))
        n_cells, n = self.cells.shape
        offsets = numpy_to_vtk(np.arange(n_cells + 1, dtype=np.int64) * n, deep=True, array_type=vtk.VTK_ID_TYPE)
        cells.SetData(offsets, numpy_to_vtk(self.cells.ravel(), deep=True, array_type=vtk.VTK_ID_TYPE))
        grid.SetPoints(vertices)
        grid.SetCells(CELL_TYPES[n], cells)
        for name, values in fields.items():
            array = numpy_to_vtk(np.ascontiguousarray(values, dtype=float), deep=True)
            array.SetName(name)
            grid.GetPointData().AddArray(array)
        return grid


def run(algorithm, data):
    algorithm.SetInputData(data)
    algorithm.Update()
    return algorithm.GetOutput()


def far_half(grid):
    """What lies behind the plane y = 0, seen from the front."""
    plane = vtk.vtkPlane()
    plane.SetNormal(0, 1, 0)
    clip = vtk.vtkTableBasedClipDataSet()
    clip.SetClipFunction(plane)
    return run(clip, grid)


def section(grid):
    plane, cutter = vtk.vtkPlane(), vtk.vtkCutter()
    plane.SetNormal(0, 1, 0)
    plane.SetOrigin(0, 1e-7, 0)  # off the nodes
    cutter.SetCutFunction(plane)
    return run(cutter, grid)


def surface(grid):
    return run(vtk.vtkDataSetSurfaceFilter(), grid)


def actor(data, field=None, limits=(0, 1), colours="viridis", colour=BONE, opacity=1.0, edges=False):
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputData(data)
    if field:
        table = vtk.vtkLookupTable()
        table.SetNumberOfTableValues(256)
        for i, rgba in enumerate(plt.get_cmap(colours)(np.linspace(0, 1, 256))):
            table.SetTableValue(i, *rgba)
        mapper.SetLookupTable(table)
        mapper.UseLookupTableScalarRangeOn()
        table.SetRange(*limits)
        mapper.SetScalarModeToUsePointFieldData()
        mapper.SelectColorArray(field)
        mapper.InterpolateScalarsBeforeMappingOn()
    else:
        mapper.ScalarVisibilityOff()
    body = vtk.vtkActor()
    body.SetMapper(mapper)
    look = body.GetProperty()
    look.SetColor(*colour)
    look.SetOpacity(opacity)
    look.SetAmbient(0.5)
    look.SetDiffuse(0.55)
    if edges:
        look.EdgeVisibilityOn()
        look.SetEdgeColor(0.25, 0.25, 0.25)
        look.SetLineWidth(0.6)
    return body


def line(data, colour, width):
    """Lines that lie in a surface, drawn in front of it."""
    body = actor(data, colour=colour)
    body.GetProperty().SetLineWidth(width)
    body.GetProperty().LightingOff()
    body.GetMapper().SetResolveCoincidentTopologyToPolygonOffset()
    body.GetMapper().SetRelativeCoincidentTopologyLineOffsetParameters(0, -500)
    return body


def warped(data, vectors):
    data.GetPointData().SetActiveVectors(vectors)
    return run(vtk.vtkWarpVector(), data)


def thinned(data, n):
    """About n of the points, the same in every picture."""
    mask = vtk.vtkMaskPoints()
    mask.SetOnRatio(max(1, data.GetNumberOfPoints() // n))
    mask.RandomModeOn()
    mask.SetRandomModeType(1)
    return run(mask, data)


def lattice(grid, spacing, box):
    """The grid's fields on an even lattice of points in the plane y = 0."""
    x, z = np.meshgrid(*(np.arange(box[0][c] + 0.5 * spacing, box[1][c], spacing) for c in (0, 2)))
    points, cloud, probe = vtk.vtkPoints(), vtk.vtkPolyData(), vtk.vtkProbeFilter()
    points.SetData(numpy_to_vtk(np.column_stack([x.ravel(), np.full(x.size, 1e-7), z.ravel()]), deep=True))
    cloud.SetPoints(points)
    probe.SetSourceData(grid)
    return run(probe, cloud)  # zero outside: no arrow


def glyphs(points, vectors, length, arrow):
    """Rods, or arrows scaled by the vectors' length."""
    points.GetPointData().SetActiveVectors(vectors)
    if arrow:
        source = vtk.vtkArrowSource()
        source.SetTipLength(0.35)
        source.SetTipRadius(0.1)
        source.SetShaftRadius(0.03)
        shape = source.GetOutputPort()
    else:
        source, rotate, turn = vtk.vtkCylinderSource(), vtk.vtkTransformPolyDataFilter(), vtk.vtkTransform()
        source.SetRadius(0.09)
        source.SetResolution(8)
        turn.RotateZ(90)  # a cylinder stands along y, glyphs along x
        rotate.SetTransform(turn)
        rotate.SetInputConnection(source.GetOutputPort())
        shape = rotate.GetOutputPort()
    glyph = vtk.vtkGlyph3D()
    glyph.SetSourceConnection(shape)
    glyph.SetVectorModeToUseVector()
    glyph.SetScaleModeToScaleByVector() if arrow else glyph.SetScaleModeToDataScalingOff()
    glyph.SetScaleFactor(length)
    return run(glyph, points)


@functools.lru_cache(maxsize=None)
def off_screen_window(size):
    """One for the whole program: a virtual display may vanish with its last window."""
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(8)
    window.SetSize(*size)
    return window


def render(actors, box, size=(560, 860)):
    """An RGB image of the actors, seen along +y with x to the right and z up."""
    scene, window, grab = vtk.vtkRenderer(), off_screen_window(size), vtk.vtkWindowToImageFilter()
    scene.SetBackground(1, 1, 1)
    for body in actors:
        scene.AddActor(body)
    window.AddRenderer(scene)
    low, high = box
    centre, extent = (low + high) / 2, high - low
    camera = scene.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetFocalPoint(*centre)
    camera.SetPosition(centre[0], centre[1] - 1, centre[2] + 0.12)
    camera.SetViewUp(0, 0, 1)
    camera.SetParallelScale(0.54 * max(extent[2], extent[0] * size[1] / size[0]))
    scene.ResetCameraClippingRange()
    window.Render()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    grab.Update()
    image = grab.GetOutput()
    window.RemoveRenderer(scene)
    width, height, _ = image.GetDimensions()
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1)[::-1].copy()


def bounds(points):
    return points.min(axis=0), points.max(axis=0)


def compose(panels, bars, title, path):
    """Panels [(image, caption)] side by side; bars [(label, limits, colours, first panel, last panel)] below."""
    n = len(panels)
    figure = plt.figure(figsize=(3.1 * n + 0.2, 5.9))
    columns = figure.add_gridspec(2, n, height_ratios=[1, 0.025], left=0.01, right=0.99, top=0.87, bottom=0.1,
                                  hspace=0.02, wspace=0.02)
    for i, (image, caption) in enumerate(panels):
        axis = figure.add_subplot(columns[0, i])
        axis.imshow(image)
        axis.set_title(caption, fontsize=10)
        axis.axis("off")
    for label, limits, colours, first, last in bars:
        slot = columns[1, first:last + 1].get_position(figure)
        width = min(0.75 * slot.width, 4 / figure.get_figwidth())
        axis = figure.add_axes([slot.x0 + (slot.width - width) / 2, slot.y0, width, slot.height])
        scale = matplotlib.cm.ScalarMappable(matplotlib.colors.Normalize(*limits), colours)
        figure.colorbar(scale, cax=axis, orientation="horizontal", label=label)
    figure.suptitle(title, fontsize=13)
    figure.savefig(path, dpi=150)
    plt.close(figure)
    print(path)


def milliseconds(time):
    return f"t = {1e3 * time:.0f} ms"


def picture_fibres(mech, path):
    f, x = mech.field("fibres", 0), mech.points
    around = (f[:, 1] * x[:, 0] - f[:, 0] * x[:, 1]) / np.maximum(np.hypot(x[:, 0], x[:, 1]), 1e-12)
    angle = np.degrees(np.arctan(f[:, 2] / np.where(abs(around) < 1e-12, 1e-12, around)))
    grid = mech.grid(0, fibre=f, angle=angle)
    panels = []
    for half, caption in ((grid, "epicardium"), (far_half(grid), "endocardium and section")):
        skin = surface(half)
        rods = glyphs(thinned(skin, 3000), "fibre", 3.2e-3, arrow=False)
        panels.append((render([actor(skin, colour=(0.93, 0.88, 0.86)), actor(rods, "angle", (-60, 60), "coolwarm")],
                              bounds(x)), caption))
    compose(panels, [("helix angle [degrees]", (-60, 60), "coolwarm", 0, 1)], "Fibres", path)


def picture_potential(ep, times, path):
    limits, panels = (-90, 40), []
    for instant in sorted({ep.nearest(time) for time in times}):
        wall = surface(far_half(ep.grid(instant, v=1e3 * ep.field("potential", instant))))
        image = render([actor(wall, "v", limits, "inferno")], bounds(ep.points))
        panels.append((image, milliseconds(ep.times[instant])))
    bar = ("transmembrane potential [mV]", limits, "inferno", 0, len(panels) - 1)
    compose(panels, [bar], "Electric activity", path)


def picture_activation(activation, path):
    times = 1e3 * activation.field("activation_time", 0)
    limits = (0, max(1.0, np.nanmax(times)))
    grid = activation.grid(0, t=np.where(np.isfinite(times), times, limits[1]))
    isochrones = vtk.vtkContourFilter()
    isochrones.SetInputArrayToProcess(0, 0, 0, 0, "t")
    isochrones.GenerateValues(int(limits[1] // 10), 10, 10 * (limits[1] // 10))
    panels = []
    for half, caption in ((grid, "epicardium"), (far_half(grid), "endocardium and section")):
        skin = surface(half)
        lines = line(run(isochrones, skin), (0.1, 0.1, 0.1), 1.5)
        panels.append((render([actor(skin, "t", limits, "viridis_r"), lines], bounds(activation.points)), caption))
    compose(panels, [("activation time [ms], a line every 10 ms", limits, "viridis_r", 0, 1)], "Activation", path)


def picture_flow(fluid, instant, what, path):
    u, p = fluid.field("velocity", instant), fluid.field("pressure", instant) / MMHG
    speed = np.linalg.norm(u, axis=1)
    fastest = max(np.ceil(20 * speed.max()) / 20, 0.05)
    low, high = np.percentile(p, [0.5, 99.5])
    limits = (low, max(high, low + 0.1))
    grid = fluid.grid(instant, "motion", u=u, speed=speed, p=p)
    cut, box = section(grid), bounds(fluid.points)
    arrows = glyphs(lattice(grid, 3.5e-3, box), "u", 8e-3 / fastest, arrow=True)
    velocity = [actor(cut, "speed", (0, fastest), "Spectral_r"), actor(arrows, colour=(0.1, 0.1, 0.1))]
    panels = [(render(velocity, box), "velocity"), (render([actor(cut, "p", limits, "viridis")], box), "pressure")]
    compose(panels, [("speed [m/s]", (0, fastest), "Spectral_r", 0, 0), ("pressure [mmHg]", limits, "viridis", 1, 1)],
            f"Blood in {what}, {milliseconds(fluid.times[instant])}", path)


def picture_deformation(mech, times, path):
    instants = sorted({mech.nearest(time) for time in times})
    sizes = {i: 1e3 * np.linalg.norm(mech.field("displacement", i), axis=1) for i in instants}
    limits = (0, max(1.0, max(size.max() for size in sizes.values())))
    rest = run(vtk.vtkFeatureEdges(), surface(far_half(mech.grid())))
    moved = np.concatenate([mech.points + mech.field("displacement", i) for i in instants] + [mech.points])
    panels = []
    for i in instants:
        d = mech.field("displacement", i)
        wall = surface(warped(far_half(mech.grid(d=d, size=sizes[i])), "d"))  # the same half of the tissue always
        panels.append((render([actor(wall, "size", limits, "cividis", edges=True), line(rest, (0.75, 0.1, 0.1), 1.5)],
                              bounds(moved)), milliseconds(mech.times[i])))
    compose(panels, [("displacement [mm]; red: shape at rest", limits, "cividis", 0, len(panels) - 1)], "Deformation",
            path)


def restart_with_display():
    if os.environ.get("DISPLAY"):
        return
    if not shutil.which("xvfb-run"):
        sys.exit("pictures need a display: set DISPLAY or install xvfb")
    os.execvp("xvfb-run", ["xvfb-run", "-a", "-s", "-screen 0 1280x1024x24 -noreset", sys.executable, *sys.argv])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="results folder of a run")
    parser.add_argument("--times", nargs="+", type=float, default=[30, 60, 100, 300], metavar="MS",
                        help="instants of the potential and the deformation [ms]")
    parser.add_argument("--out", help="folder for the pictures; default: FOLDER/report")
    options = parser.parse_args()
    restart_with_display()
    folder, times = Path(options.folder), [1e-3 * time for time in options.times]
    out = Path(options.out or folder / "report")
    out.mkdir(parents=True, exist_ok=True)
    series = {path.stem: Series(path) for path in sorted((folder / "fields").glob("*.h5"))}
    if "mech" in series:
        if series["mech"].has("fibres"):
            picture_fibres(series["mech"], out / "fibres.png")
        picture_deformation(series["mech"], times, out / "deformation.png")
    if "ep" in series:
        picture_potential(series["ep"], times, out / "potential.png")
    if "activation" in series:
        picture_activation(series["activation"], out / "activation.png")
    if "fluid" in series:
        history = History(folder)
        for flow, what in (("aortic_flow", "ejection"), ("mitral_flow", "filling")):
            if flow in history and history[flow].max() > 0:
                peak = history.time[np.argmax(history[flow])]
                picture_flow(series["fluid"], series["fluid"].nearest(peak), what, out / f"{what}.png")


if __name__ == "__main__":
    main()
