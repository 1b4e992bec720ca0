"""XDMF grids, values in the text or in HDF5; the boundary may be a second file beside it, NAME_boundary.xdmf."""
import xml.etree.ElementTree as xml
from pathlib import Path

import h5py
import numpy as np

from .model import Foreign, Refusal, Surface

# name in lower case: (kind, vertices in the file, corners)
TOPOLOGIES = {"tetrahedron": ("tetrahedra", 4, 4), "tetrahedron_10": ("tetrahedra", 10, 4), "tet_10": ("tetrahedra", 10, 4),
              "hexahedron": ("hexahedra", 8, 8), "triangle": ("triangles", 3, 3), "triangle_6": ("triangles", 6, 3),
              "tri_6": ("triangles", 6, 3), "quadrilateral": ("quadrilaterals", 4, 4), "wedge": ("wedges", 6, 6),
              "pyramid": ("pyramids", 5, 5)}


def item(node, path):
    """The values of a DataItem, in its dimensions."""
    found = node.find("DataItem")
    if found is None:
        raise Refusal(f"{path}: <{node.tag}> has no DataItem")
    try:
        shape = tuple(int(n) for n in found.get("Dimensions", "").split())
        text = (found.text or "").strip()
        if found.get("Format", "XML").upper() == "HDF":
            file, _, name = text.partition(":")
            with h5py.File(path.parent / file, "r") as data:
                return data[name][()].reshape(shape)
        values = np.array(text.split(), dtype=np.int64 if found.get("DataType", found.get("NumberType")) in ("Int", "UInt")
                          else float)
        return values.reshape(shape)
    except (ValueError, OSError, KeyError) as error:
        raise Refusal(f"{path}: the values of <{node.tag}> cannot be read: {error}; is the file truncated?") from None


def grid_of(path):
    try:
        root = xml.parse(path).getroot()
    except (xml.ParseError, OSError, UnicodeDecodeError) as error:
        raise Refusal(f"{path}: is no XDMF: {error}; is it truncated?") from None
    grids = [grid for grid in root.iter("Grid") if grid.find("Topology") is not None and grid.find("Geometry") is not None]
    if len(grids) != 1:
        raise Refusal(f"{path}: has {len(grids)} grids with topology and geometry; one is read")
    return grids[0]


def pieces(path):
    """(points, kind, corners, tags, {name: values} of cells, of nodes)"""
    grid = grid_of(path)
    topology = grid.find("Topology")
    name = topology.get("TopologyType", topology.get("Type", "")).lower()
    if name not in TOPOLOGIES:
        raise Refusal(f"{path}: its topology is '{name}'; read are {', '.join(sorted(TOPOLOGIES))}")
    kind, width, corners = TOPOLOGIES[name]
    points, cells = item(grid.find("Geometry"), path).astype(float), item(topology, path).astype(np.int64)
    if points.ndim != 2 or points.shape[1] != 3 or cells.size % width:
        raise Refusal(f"{path}: points must be (n, 3) and cells (m, {width})")
    cells = cells.reshape(-1, width)[:, :corners]
    if cells.min(initial=0) < 0 or cells.max(initial=0) >= len(points):
        raise Refusal(f"{path}: a cell has node {cells.max()} of {len(points)}")
    fields = {"Cell": {}, "Node": {}}
    for attribute in grid.findall("Attribute"):
        values = item(attribute, path)
        fields.setdefault(attribute.get("Center", "Node"), {})[attribute.get("Name")] = values.reshape(len(values), -1)
    return points, kind, cells, fields


def tags_of(fields, n):
    whole = [values[:, 0] for values in fields.values() if values.shape[1] == 1 and len(values) == n
             and np.array_equal(values, np.round(values))]
    return whole[0].astype(np.int64) if whole else np.ones(n, dtype=np.int64)


def read(path):
    points, kind, cells, fields = pieces(path)
    tags = tags_of(fields["Cell"], len(cells))
    ids = np.unique(tags)
    mesh = Foreign(str(path), points, {kind: cells}, {kind: np.searchsorted(ids, tags)}, [f"region_{i}" for i in ids],
                   point_fields=fields["Node"], cell_fields=fields["Cell"])
    stem = path.stem.removesuffix("_domain")
    for beside in (f"{stem}_boundary.xdmf", f"{stem}_facets.xdmf"):
        if (path.parent / beside).is_file() and beside != path.name:
            add_boundary(mesh, path.parent / beside)
    return mesh


def add_boundary(mesh, path):
    points, _, faces, fields = pieces(path)
    if points.shape != mesh.points.shape or np.abs(points - mesh.points).max() > 1e-6 * np.ptp(points):
        raise Refusal(f"{path}: its nodes are not those of {mesh.source}")
    tags = tags_of(fields["Cell"], len(faces))
    for tag in np.unique(tags):
        mesh.surfaces.append(Surface(str(tag), faces[tags == tag]))
    mesh.notes.append(f"surfaces from {path.name}")
