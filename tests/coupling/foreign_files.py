"""Writes meshes as other programs do, for the tests of their readers."""
import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk


def values(array):
    return "\n".join(" ".join(repr(x) for x in row) for row in np.atleast_2d(array).tolist())


def xdmf_grid(topology, cells, points, tags):
    def item(array, kind):
        shape = " ".join(str(n) for n in array.shape)
        return f'<DataItem DataType="{kind}" Dimensions="{shape}" Format="XML">{values(array)}</DataItem>'
    return ('<Xdmf Version="3.0"><Domain><Grid Name="Grid">'
            f'<Geometry GeometryType="XYZ">{item(points, "Float")}</Geometry>'
            f'<Topology TopologyType="{topology}" NumberOfElements="{len(cells)}">{item(cells, "Int")}</Topology>'
            f'<Attribute Name="tag" AttributeType="Scalar" Center="Cell">{item(tags[:, None], "Int")}</Attribute>'
            '</Grid></Domain></Xdmf>')


def write_xdmf(path, part, cells):
    """In mm; the labels' numbers in NAME_boundary.xdmf when the name ends with _domain."""
    points = part.points * 1e3
    path.write_text(xdmf_grid("Tetrahedron", cells, points, np.ones(len(cells), int)))
    if path.stem.endswith("_domain"):
        beside = path.with_name(path.name.replace("_domain", "_boundary"))
        beside.write_text(xdmf_grid("Triangle", part.faces, points, part.face_labels))


def write_carp(stem, part, length=1.0, odd=None):
    """In um, all fibres along (0.6, 0.8, 0); that of the cell `odd` has another length."""
    points = part.points * 1e6
    stem.with_suffix(".pts").write_text(f"{len(points)}\n{values(points)}\n")
    stem.with_suffix(".elem").write_text(f"{len(part.cells)}\n" + "".join(
        f"Tt {a} {b} {c} {d} 3\n" for a, b, c, d in part.cells.tolist()))
    fibres = np.tile([0.6, 0.8, 0.0], (len(part.cells), 1))
    if odd is not None:
        fibres[odd] *= length
    stem.with_suffix(".lon").write_text(f"1\n{values(fibres)}\n")
    for label in part.label_names:
        faces = part.faces_of(label)
        stem.with_name(f"{stem.name}.{label}.surf").write_text(f"{len(faces)}\n" + "".join(
            f"Tr {a} {b} {c}\n" for a, b, c in faces.tolist()))


def write_gmsh(path, parts):
    """Wall and blood in one file in format 2.2, in m, nodes of the interface once, a physical group for each part and for
    each label of the wall but `interface`."""
    solid, fluid = parts["solid"], parts["fluid"]
    number = {tuple(x): i for i, x in enumerate(solid.points)}
    twin = np.array([number.setdefault(tuple(x), len(number)) for x in fluid.points])
    points = np.array(list(number))
    groups, elements = [(3, 1, "solid"), (3, 2, "fluid")], []
    for name, part, nodes in (("solid", solid, np.arange(len(solid.points))), ("fluid", fluid, twin)):
        elements += [(4, 1 if name == "solid" else 2, nodes[cell]) for cell in part.cells]
        for label in part.label_names:
            if label != "interface":
                group = next((g for _, g, known in groups if known == label), 10 + len(groups))
                groups += [] if any(known == label for _, _, known in groups) else [(2, group, label)]
                elements += [(2, group, nodes[face]) for face in part.faces_of(label)]
    text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n" + f"{len(groups)}\n"
    text += "".join(f'{dimension} {group} "{name}"\n' for dimension, group, name in groups)
    text += f"$EndPhysicalNames\n$Nodes\n{len(points)}\n"
    text += "".join(f"{i} {x!r} {y!r} {z!r}\n" for i, (x, y, z) in enumerate(points.tolist(), 1))
    text += f"$EndNodes\n$Elements\n{len(elements)}\n"
    text += "".join(f"{i} {kind} 2 {group} {group} {' '.join(str(n + 1) for n in nodes)}\n"
                    for i, (kind, group, nodes) in enumerate(elements, 1))
    path.write_text(text + "$EndElements\n")


def vtk_cells(cells):
    n, width = cells.shape
    array = vtk.vtkCellArray()
    array.SetData(numpy_to_vtk(np.arange(n + 1, dtype=np.int64) * width, deep=True, array_type=vtk.VTK_ID_TYPE),
                  numpy_to_vtk(np.ascontiguousarray(cells.ravel()), deep=True, array_type=vtk.VTK_ID_TYPE))
    return array


def add(attributes, name, array):
    data = numpy_to_vtk(np.ascontiguousarray(array), deep=True)
    data.SetName(name)
    attributes.AddArray(data)


def write_vtk(path, data):
    """Appended, compressed by zlib, as svMultiPhysics' tools do."""
    writer = vtk.vtkXMLUnstructuredGridWriter() if path.suffix == ".vtu" else vtk.vtkXMLPolyDataWriter()
    writer.SetDataModeToAppended()
    writer.SetCompressorTypeToZLib()
    writer.SetFileName(str(path))
    writer.SetInputData(data)
    writer.Write()


def place(data, points):
    nodes = vtk.vtkPoints()
    nodes.SetData(numpy_to_vtk(points, deep=True))
    data.SetPoints(nodes)


def write_hexahedra(path, n, edge, mirrored=()):
    """A cube of n^3 hexahedra, the cells in `mirrored` the other way round; its boundary as quadrilaterals of tag 9."""
    i = np.arange(n + 1)
    points = np.array([(x, y, z) for z in i for y in i for x in i], dtype=float) * edge / n
    first = np.array([x + (n + 1) * (y + (n + 1) * z) for z in range(n) for y in range(n) for x in range(n)])
    steps = [0, 1, n + 2, n + 1]
    ring = np.array(steps + [step + (n + 1) ** 2 for step in steps])
    cells = first[:, None] + ring
    for cell in mirrored:
        cells[cell] = cells[cell][[4, 5, 6, 7, 0, 1, 2, 3]]
    faces = np.concatenate([cells[:, face] for face in ([0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [3, 2, 6, 7], [0, 3, 7, 4],
                                                        [1, 2, 6, 5])])
    _, index, counts = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    faces = faces[index[counts == 1]]
    grid = vtk.vtkUnstructuredGrid()
    place(grid, points)
    both = vtk.vtkCellArray()
    nodes = np.concatenate([cells.ravel(), faces.ravel()]).astype(np.int64)
    offsets = np.concatenate([np.arange(len(cells)) * 8, 8 * len(cells) + np.arange(len(faces) + 1) * 4]).astype(np.int64)
    both.SetData(numpy_to_vtk(offsets, deep=True, array_type=vtk.VTK_ID_TYPE),
                 numpy_to_vtk(nodes, deep=True, array_type=vtk.VTK_ID_TYPE))
    kinds = np.repeat([vtk.VTK_HEXAHEDRON, vtk.VTK_QUAD], [len(cells), len(faces)]).astype(np.uint8)
    grid.SetCells(numpy_to_vtk(kinds, deep=True, array_type=vtk.VTK_UNSIGNED_CHAR), both)
    add(grid.GetCellData(), "MaterialID", np.repeat([2, 9], [len(cells), len(faces)]).astype(np.int32))
    write_vtk(path, grid)


def write_svmultiphysics(folder, part, with_ids):
    """In cm, with fibres and sheets by node, the fibres of either sense. With ids, GlobalNodeID are the numbers of the nodes from 1, in shuffled order; without, places alone count."""
    (folder / "mesh-surfaces").mkdir(parents=True, exist_ok=True)
    ids = np.random.default_rng(1).permutation(len(part.points)).astype(np.int32) + 1
    grid = vtk.vtkUnstructuredGrid()
    place(grid, part.points * 100)
    grid.SetCells(vtk.VTK_TETRA, vtk_cells(part.cells))
    add(grid.GetCellData(), "ModelRegionID", np.full(len(part.cells), 7, np.int32))
    add(grid.GetCellData(), "GlobalElementID", np.arange(1, len(part.cells) + 1, dtype=np.int32))
    add(grid.GetPointData(), "fibre", np.tile([0.6, 0.8, 0.0], (len(part.points), 1)) * (-1.0) ** ids[:, None])
    add(grid.GetPointData(), "sheet", np.tile([0.8, -0.6, 0.0], (len(part.points), 1)))
    if with_ids:
        add(grid.GetPointData(), "GlobalNodeID", ids)
    write_vtk(folder / "mesh-complete.mesh.vtu", grid)
    for label in part.label_names:
        faces = part.faces_of(label)
        nodes, own = np.unique(faces, return_inverse=True)
        surface = vtk.vtkPolyData()
        place(surface, part.points[nodes] * 100)
        surface.SetPolys(vtk_cells(own.reshape(faces.shape).astype(np.int64)))
        add(surface.GetCellData(), "ModelFaceID", np.full(len(faces), 3, np.int32))
        if with_ids:
            add(surface.GetPointData(), "GlobalNodeID", ids[nodes])
        write_vtk(folder / "mesh-surfaces" / f"{label}.vtp", surface)
