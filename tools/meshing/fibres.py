"""Fibres and sheets of a solid from arrays by node or by cell."""
from pathlib import Path

import numpy as np

from . import read_vtk
from .model import Refusal, place
from .topology import nearest

TOLERANCE = 1e-3  # of lengths and products: what rounding in files may do


def array(mesh, word):
    """(values (k, 3), whether by cell) of "NAME", an array of the mesh, or of "FILE.vtu:NAME"."""
    file, _, name = word.rpartition(":")
    source = read_vtk.read(Path(file)) if file else mesh
    for fields, by_cell in ((source.cell_fields, True), (source.point_fields, False)):
        if name in fields:
            wanted = len(next(iter(mesh.cells.values()))) if by_cell else len(mesh.points)
            if fields[name].shape != (wanted, 3):
                raise Refusal(f"{source.source}: '{name}' has {fields[name].shape[0]} vectors of {fields[name].shape[1]}, where "
                              f"{wanted} of 3 must be, one a {'cell' if by_cell else 'node'}")
            return fields[name].astype(float), by_cell
    known = sorted({*source.cell_fields, *source.point_fields})
    raise Refusal(f"{source.source}: has no array '{name}'; it has {', '.join(known) or 'none'}")


def check_unit(mesh, word, values, by_cell):
    lengths = np.linalg.norm(values, axis=1)
    off = np.abs(lengths - 1)
    off[~np.isfinite(off)] = np.inf
    worst = off.argmax()
    if off[worst] > TOLERANCE:
        cells = next(iter(mesh.cells.values()))
        where = mesh.points[cells[worst]].mean(axis=0) if by_cell else mesh.points[worst]
        raise Refusal(f"{mesh.source}: '{word}' is not unit: the worst is {'cell' if by_cell else 'node'} {worst} around "
                      f"{tuple(np.round(where, 4))}, of length {lengths[worst]:.4g} ({(off > TOLERANCE).sum():,} of {len(off):,} "
                      "differ from 1 by more than 0.001): divide each vector by its length; none may be zero")
    return values / lengths[:, None]


def by_cells(values, by_cell, cells):
    """Of nodes the principal direction of the sum of f (x) f in each cell: f and -f are the same fibre."""
    if by_cell:
        return values
    corners = values[cells]
    _, vectors = np.linalg.eigh(np.einsum("cvi,cvj->cij", corners, corners))
    return vectors[:, :, 2]


def across(part):
    """Towards each cell's centre from the nearest node of the interface: through the wall, nearly."""
    nodes = part.nodes_of("interface")
    if not len(nodes):
        raise Refusal("fibres without sheets need the label `interface`, from which the sheets lead away; give --sheets")
    centres = part.points[part.cells].mean(axis=1)
    index, _ = nearest(part.points[nodes], centres)
    return centres - part.points[nodes[index]]


def attach(part, mesh, fibre_word, sheet_word):
    """Puts (cells, 2, 3) orthonormal vectors on the part. The cells of part and mesh are in the same order."""
    cells = next(iter(mesh.cells.values()))
    values, by_cell = array(mesh, fibre_word)
    f = by_cells(check_unit(mesh, fibre_word, values, by_cell), by_cell, cells)
    if sheet_word:
        values, by_cell = array(mesh, sheet_word)
        s = by_cells(check_unit(mesh, sheet_word, values, by_cell), by_cell, cells)
        product = np.abs((f * s).sum(axis=1))
        worst = product.argmax()
        if product[worst] > (10 * TOLERANCE if by_cell else 0.1):
            raise Refusal(f"{mesh.source}: fibre and sheet are not orthogonal: the worst is cell {worst} around "
                          f"{place(part.points[part.cells[worst]].mean(axis=0))}, where f.s is {product[worst]:.3g}")
    else:
        s = across(part)
        mesh.notes.append("no sheets given: they lead away from the endocardium, orthogonal to the fibres")
    s = s - (s * f).sum(axis=1)[:, None] * f
    length = np.linalg.norm(s, axis=1)
    if not length.min() > 1e-6 * length.max():
        raise Refusal(f"{mesh.source}: cell {length.argmin()} has its sheet along its fibre; give --sheets")
    part.fibres = np.stack([f, s / length[:, None]], axis=1)
