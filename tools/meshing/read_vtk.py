"""VTK's .vtu, .vtp and legacy .vtk, and folders in svMultiPhysics' layout: one .vtu and a .vtp for each surface."""
import mmap
import re
from pathlib import Path

import numpy as np

from .model import Foreign, Refusal, Surface
from .topology import nearest

# VTK's cell type: (kind, corners)
TYPES = {5: ("triangles", 3), 22: ("triangles", 3), 9: ("quadrilaterals", 4), 10: ("tetrahedra", 4), 24: ("tetrahedra", 4),
         12: ("hexahedra", 8), 25: ("hexahedra", 8), 13: ("wedges", 6), 14: ("pyramids", 5)}
CURVED = (22, 24, 25)
REGIONS = ("ModelRegionID", "MaterialID", "CellEntityIds", "gmsh:physical", "medit:ref", "region", "regions", "elemTag",
           "material", "subdomain", "cell_tags")
FACES = ("ModelFaceID", *REGIONS[1:])


COUNTS = re.compile(rb'NumberOf(?:Points|Cells|Polys)="\s*(\d+)|\n(?:POINTS|CELLS|CELL_TYPES|POLYGONS)\s+(\d+)')
DENSEST = 1100  # entries that a compressed byte may stand for


def check_counts(path):
    """VTK allocates what the file claims, and ends the program where that is too much."""
    if path.stat().st_size == 0:
        raise Refusal(f"{path}: is empty")
    with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as text:
        for found in COUNTS.finditer(text):
            if int(found[1] or found[2]) > DENSEST * len(text):
                raise Refusal(f"{path}: claims {int(found[1] or found[2]):,} points or cells, more than {len(text):,} bytes can "
                              "hold; is it damaged?")


def data_set(path):
    """What VTK reads from the file; its own words on errors become ours."""
    import vtk
    check_counts(path)
    complaints = []
    readers = {".vtu": vtk.vtkXMLUnstructuredGridReader, ".vtp": vtk.vtkXMLPolyDataReader, ".vtk": vtk.vtkDataSetReader}
    reader = readers[path.suffix.lower()]()

    def complain(_, __, text):
        complaints.append(text)
    complain.CallDataType = "string0"
    reader.AddObserver("ErrorEvent", complain)
    vtk.vtkObject.GlobalWarningDisplayOff()
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutput()
    if complaints or data is None or data.GetNumberOfPoints() == 0:
        said = " ".join(complaints[0].split()) if complaints else "it has no points"
        raise Refusal(f"{path}: VTK cannot read it: {said}; is it truncated?")
    return data


def arrays(attributes):
    from vtk.util.numpy_support import vtk_to_numpy
    found = {}
    for i in range(attributes.GetNumberOfArrays()):
        array = attributes.GetArray(i)
        if array is not None and array.GetName():
            values = vtk_to_numpy(array)
            found[array.GetName()] = values.reshape(len(values), -1)
    return found


def blocks(data, path):
    """{kind: (indices of the cells, corners (m, k))}, and whether any is curved."""
    from vtk.util.numpy_support import vtk_to_numpy
    n = data.GetNumberOfCells()
    types = np.array([data.GetCellType(i) for i in range(n)]) if not hasattr(data, "GetCellTypesArray") else \
        vtk_to_numpy(data.GetCellTypesArray())
    array = data.GetPolys() if hasattr(data, "GetPolys") else data.GetCells()
    offsets, nodes = vtk_to_numpy(array.GetOffsetsArray()), vtk_to_numpy(array.GetConnectivityArray())
    if len(offsets) != n + 1:
        raise Refusal(f"{path}: {n} cells, of which {len(offsets) - 1} can be read; lines and vertices must go")
    if len(nodes) and (nodes.min() < 0 or nodes.max() >= data.GetNumberOfPoints()):
        raise Refusal(f"{path}: a cell has node {max(nodes.max(), -nodes.min())} of {data.GetNumberOfPoints()}")
    found = {}
    for kind in np.unique(types):
        if kind not in TYPES:
            continue
        name, corners = TYPES[kind]
        cells = np.flatnonzero(types == kind)
        index = np.concatenate([found[name][0], cells]) if name in found else cells
        block = nodes[offsets[cells][:, None] + np.arange(corners)].astype(np.int64)
        found[name] = index, np.concatenate([found[name][1], block]) if name in found else block
    return found, bool(np.isin(types, CURVED).any())


def tags(fields, names, n):
    for name in names:
        if name in fields and fields[name].shape[1] == 1:
            return np.asarray(fields[name][:, 0]).astype(np.int64)
    return np.ones(n, dtype=np.int64)


def read(path):
    from vtk.util.numpy_support import vtk_to_numpy
    data = data_set(path)
    if not data.IsA("vtkUnstructuredGrid"):
        raise Refusal(f"{path}: is a surface, or no unstructured grid; give the .vtu of the volume, or the folder with both")
    fields, (found, curved) = arrays(data.GetCellData()), blocks(data, path)
    all_tags = tags(fields, REGIONS, data.GetNumberOfCells())
    mesh = Foreign(str(path), vtk_to_numpy(data.GetPoints().GetData()).astype(float), {}, {}, [])
    volumes = {kind: block for kind, block in found.items() if kind not in ("triangles", "quadrilaterals")}
    ids = np.unique(np.concatenate([all_tags[index] for index, _ in volumes.values()])) if volumes else []
    mesh.region_names = [f"region_{i}" for i in ids]
    for kind, (index, corners) in volumes.items():
        mesh.cells[kind], mesh.regions[kind] = corners, np.searchsorted(ids, all_tags[index])
    for kind in set(found) - set(volumes):
        index, corners = found[kind]
        for tag in np.unique(all_tags[index]):
            mesh.surfaces.append(Surface(str(tag), corners[all_tags[index] == tag]))
    mesh.point_fields = arrays(data.GetPointData())
    if len(volumes) == 1:
        index, _ = next(iter(volumes.values()))
        mesh.cell_fields = {name: values[index] for name, values in fields.items()}
    if curved:
        mesh.notes.append("cells of second order: their corners are taken, edges become straight")
    return mesh


def matched(surface, points, ids, mesh):
    """Indices, in the mesh, of the nodes of a surface: by GlobalNodeID where both have it, else by coordinates."""
    known = mesh.point_fields.get("GlobalNodeID")
    scale = np.ptp(mesh.points, axis=0).max()
    if ids is not None and known is not None:
        known, ids = known[:, 0].astype(np.int64), ids[:, 0].astype(np.int64)
        order = np.argsort(known)
        at = np.searchsorted(known[order], ids).clip(max=len(known) - 1)
        index = order[at]
        if (known[index] == ids).all() and np.linalg.norm(mesh.points[index] - points, axis=1).max() < 1e-5 * scale:
            return index
        mesh.notes.append(f"{surface}: GlobalNodeID does not lead to the same places, coordinates were matched instead")
    index, distance = nearest(mesh.points, points)
    worst = distance.argmax()
    if distance[worst] > 1e-5 * scale:
        raise Refusal(f"{surface}: node {worst} at {tuple(points[worst])} is {distance[worst]:.3g} from the nearest node of "
                      f"{mesh.source}; is the surface of another mesh?")
    return index


def surfaces_of(folder):
    inside = folder / "mesh-surfaces"
    if inside.is_dir():
        return sorted(inside.glob("*.vtp"))
    return [file for file in sorted(folder.glob("*.vtp")) if "exterior" not in file.stem and "combined" not in file.stem]


def read_folder(folder):
    from vtk.util.numpy_support import vtk_to_numpy
    volumes = sorted(folder.glob("*.vtu"))
    if len(volumes) > 1:
        volumes = [file for file in volumes if file.name == "mesh-complete.mesh.vtu"]
    if len(volumes) != 1:
        raise Refusal(f"{folder}: a folder must hold one .vtu, or mesh-complete.mesh.vtu, and a .vtp for each surface "
                      "(in mesh-surfaces/)")
    mesh = read(volumes[0])
    for file in surfaces_of(folder):
        data = data_set(file)
        points = vtk_to_numpy(data.GetPoints().GetData()).astype(float)
        index = matched(file, points, arrays(data.GetPointData()).get("GlobalNodeID"), mesh)
        found, _ = blocks(data, file)
        for kind in found:
            mesh.surfaces.append(Surface(file.stem, index[found[kind][1]]))
    if not mesh.surfaces:
        mesh.notes.append("no surfaces (.vtp) beside it")
    return mesh
