"""Bodies of a run rendered off screen by VTK, put together with titles and colour bars by matplotlib."""
import functools
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

from reporting.style import metadata
from results import origin

CELL_TYPES = {8: vtk.VTK_HEXAHEDRON, 4: vtk.VTK_TETRA, 10: vtk.VTK_QUADRATIC_TETRA}
BONE = (0.86, 0.84, 0.82)


class Series:
    """One fields/NAME.h5: a mesh and its fields at a number of instants."""

    def __init__(self, path):
        self.origin = origin([Path(path).parents[1]])
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


def middle(grid):
    """y of the plane that cuts the body: 0 where it lies around, else that of its centre."""
    _, _, low, high, _, _ = grid.GetBounds()
    return 0.0 if low * high < 0 else 0.5 * (low + high)


def far_half(grid):
    """What lies behind the middle, seen from the front."""
    plane = vtk.vtkPlane()
    plane.SetNormal(0, 1, 0)
    plane.SetOrigin(0, middle(grid), 0)
    clip = vtk.vtkTableBasedClipDataSet()
    clip.SetClipFunction(plane)
    return run(clip, grid)


def opened(grid):
    """A hollow body cut open, another one whole."""
    locator = vtk.vtkStaticCellLocator()
    locator.SetDataSet(grid)
    locator.BuildLocator()
    return far_half(grid) if locator.FindCell(grid.GetCenter()) < 0 else grid


def section(grid):
    plane, cutter = vtk.vtkPlane(), vtk.vtkCutter()
    plane.SetNormal(0, 1, 0)
    plane.SetOrigin(0, middle(grid) + 1e-7, 0)  # off the nodes
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


def drawn_inwards(grid, share):
    """The points, those on the surface moved by this share of the way to the middle of their cells, so that lines can begin."""
    centres, average = vtk.vtkCellCenters(), vtk.vtkCellDataToPointData()
    copy = vtk.vtkUnstructuredGrid()
    copy.CopyStructure(grid)
    middles = numpy_to_vtk(vtk_to_numpy(run(centres, grid).GetPoints().GetData()), deep=True)
    middles.SetName("middle")
    copy.GetCellData().AddArray(middles)
    x = vtk_to_numpy(grid.GetPoints().GetData())
    mean = vtk_to_numpy(run(average, copy).GetPointData().GetArray("middle"))
    points, cloud = vtk.vtkPoints(), vtk.vtkPolyData()
    points.SetData(numpy_to_vtk(x + share * (mean - x), deep=True))
    cloud.SetPoints(points)
    return cloud


def lattice(grid, spacing, box):
    """The grid's fields on an even lattice of points in the plane of the section."""
    x, z = np.meshgrid(*(np.arange(box[0][c] + 0.5 * spacing, box[1][c], spacing) for c in (0, 2)))
    points, cloud, probe = vtk.vtkPoints(), vtk.vtkPolyData(), vtk.vtkProbeFilter()
    points.SetData(numpy_to_vtk(np.column_stack([x.ravel(), np.full(x.size, middle(grid) + 1e-7), z.ravel()]), deep=True))
    cloud.SetPoints(points)
    probe.SetSourceData(grid)
    return run(probe, cloud)  # zero outside: no arrow


def arrows(points, vectors, length):
    """Scaled by the vectors' length."""
    points.GetPointData().SetActiveVectors(vectors)
    source, glyph = vtk.vtkArrowSource(), vtk.vtkGlyph3D()
    source.SetTipLength(0.35)
    source.SetTipRadius(0.1)
    source.SetShaftRadius(0.03)
    glyph.SetSourceConnection(source.GetOutputPort())
    glyph.SetVectorModeToUseVector()
    glyph.SetScaleModeToScaleByVector()
    glyph.SetScaleFactor(length)
    return run(glyph, points)


def streamlines(grid, vectors, seeds, length, radius):
    """Tubes along the vectors, through these points; with the other fields of the grid."""
    grid.GetPointData().SetActiveVectors(vectors)
    tracer, tube = vtk.vtkStreamTracer(), vtk.vtkTubeFilter()
    tracer.SetInputData(grid)
    tracer.SetSourceData(seeds)
    tracer.SetIntegrationDirectionToBoth()
    tracer.SetIntegratorTypeToRungeKutta4()
    tracer.SetInitialIntegrationStep(0.15)  # of a cell
    tracer.SetMaximumPropagation(length)
    tracer.SetComputeVorticity(False)
    tracer.Update()
    tube.SetRadius(radius)
    tube.SetNumberOfSides(6)
    return run(tube, tracer.GetOutput())


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


def moved_bounds(fluid, instants):
    """Of the body as it is then, which may reach beyond that at rest, with room for arrows that leave it."""
    low, high = bounds(np.concatenate([fluid.points + fluid.field("motion", i) for i in instants]))
    return low - 0.06 * (high - low), high + 0.06 * (high - low)


def values_of(grid, name):
    return vtk_to_numpy(grid.GetPointData().GetArray(name))


def compose(panels, bars, title, path, source):
    """Panels [(image, caption)] side by side; bars [(label, limits, colours, first panel, last panel)] below."""
    compose_rows([panels], [bars], title, path, source)


def compose_rows(rows, bars_of_rows, title, path, source):
    """Rows of panels, each with its colour bars below. `source`: of what they are."""
    n = max(len(row) for row in rows)
    height = 5.9 * len(rows)
    figure = plt.figure(figsize=(3.1 * n + 0.2, height))
    for k, (panels, bars) in enumerate(zip(rows, bars_of_rows)):
        top, bottom = 1 - (5.9 * k + 0.77) / height, 1 - (5.9 * k + 5.31) / height
        columns = figure.add_gridspec(2, n, height_ratios=[1, 0.025], left=0.01, right=0.99, top=top, bottom=bottom,
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
    figure.savefig(path, dpi=200 if len(rows) == 1 else 130, metadata=metadata("png", source))
    figure.savefig(path.with_suffix(".pdf"), dpi=300, metadata=metadata("pdf", source))
    plt.close(figure)
    print(path)


def milliseconds(time):
    return f"t = {1e3 * time:.0f} ms"
