"""Of a foreign mesh the part that the solvers compute with; what was repaired is said in its notes."""
import numpy as np

from . import labels as naming
from . import topology
from .model import OTHERS, UNITS, VERTICES, Foreign, Part, Refusal, Surface, count, place


def one_kind(mesh):
    """The kind of the cells; Refusal when there are none, or several."""
    kinds = [kind for kind in mesh.cells if len(mesh.cells[kind])]
    if not kinds:
        raise Refusal(f"{mesh.source}: has no cells that fill a volume (tetrahedra or hexahedra): is it a surface, or truncated?")
    if len(kinds) > 1 or kinds[0] in OTHERS:
        rare = min(kinds, key=lambda kind: len(mesh.cells[kind]))
        centre = mesh.points[mesh.cells[rare][0]].mean(axis=0)
        raise Refusal(f"{mesh.source}: mixed cells: " + ", ".join(f"{len(mesh.cells[k]):,} {k}" for k in kinds) +
                      f"; one of the {rare} is at {tuple(np.round(centre, 4))}. All must be tetrahedra, or all hexahedra: "
                      "remesh, or split them into tetrahedra")
    return kinds[0]


def scale(mesh, unit):
    """Metres in one unit of the mesh."""
    if mesh.unit and unit and mesh.unit != unit:
        mesh.notes.append(f"taken in {unit}, though the format says {mesh.unit}")
    unit = unit or mesh.unit
    if not unit:
        size = np.ptp(mesh.points, axis=0).max()
        guesses = [name for name, metres in UNITS.items() if 0.03 < size * metres < 0.3]
        raise Refusal(f"{mesh.source}: in which unit? It measures {size:.4g}: add --unit " +
                      (" or ".join(guesses) if guesses else "m, cm, mm or um") + " (a heart measures 50 to 150 mm)")
    return UNITS[unit]


def check_numbers(mesh, kind):
    bad = np.flatnonzero(~np.isfinite(mesh.points).all(axis=1))
    if len(bad):
        raise Refusal(f"{mesh.source}: node {bad[0]} is at {tuple(mesh.points[bad[0]])}, no finite place "
                      f"({count(len(bad), 'such node', 'such nodes')})")
    cells = mesh.cells[kind]
    twice = np.flatnonzero((np.diff(np.sort(cells, axis=1), axis=1) == 0).any(axis=1))
    if len(twice):
        raise Refusal(f"{mesh.source}: cell {twice[0]} has the same node twice ({count(len(twice), 'such cell', 'such cells')})")


def oriented(mesh, kind, points, cells):
    """All cells positive: those that are mirrored are turned; those that are flat or inverted at a corner end it."""
    corners = topology.corner_volumes(kind, points, cells)
    negative = (corners < 0).all(axis=1)
    if negative.any():
        mesh.notes.append(f"{'all' if negative.all() else 'of ' + format(len(cells), ',')} cells: "
                          f"{count(int(negative.sum()), 'was', 'were')} negatively oriented and turned round")
        cells = cells.copy()
        cells[negative] = topology.mirrored(kind, cells[negative])
        corners[negative] *= -1
    worst = corners.min(axis=1)
    bad = np.flatnonzero(worst <= 1e-12 * np.abs(corners).max())
    if len(bad):
        cell = bad[worst[bad].argmin()]
        raise Refusal(f"{mesh.source}: cell {cell} around {place(points[cells[cell]].mean(axis=0))} is "
                      f"{'flat' if worst[cell] > -1e-12 * np.abs(corners).max() else 'inverted at a corner'} (Jacobian "
                      f"{worst[cell]:.3g} m^3; {count(len(bad), 'such cell', 'such cells')}): improve the mesh there")
    return cells


def label_faces(mesh, kind, points, cells, mapping, rest):
    """(faces, label of each, names) of all of the boundary."""
    faces, owners, keys, crowded = topology.boundary(kind, cells, len(points))
    if crowded is not None:
        raise Refusal(f"{mesh.source}: a face around {place(points[crowded].mean(axis=0))} belongs to more than two cells: "
                      "cells overlap; remove the doubles")
    label, names, inside = np.full(len(faces), -1), [], 0
    for name, found in naming.rename(mesh.surfaces, mapping, mesh.notes):
        if found.shape[1] != faces.shape[1]:
            raise Refusal(f"{mesh.source}: '{name}' has {'triangles' if found.shape[1] == 3 else 'quadrilaterals'}, which are "
                          f"no faces of {kind}")
        key = topology.face_keys(found, len(points))
        at = np.searchsorted(keys, key).clip(max=len(keys) - 1)
        on = keys[at] == key
        inside += int((~on).sum())
        if name not in names and on.any():
            names.append(name)
        other = on & (label[at] >= 0) & (label[at] != (names.index(name) if name in names else -1))
        if other.any():
            first = np.flatnonzero(other)[0]
            raise Refusal(f"{mesh.source}: the face around {place(points[found[first]].mean(axis=0))} is in "
                          f"'{names[label[at[first]]]}' and in '{name}'; drop one with --label FOREIGN=")
        label[at[on]] = names.index(name) if on.any() else 0
    if inside:
        mesh.notes.append(f"{count(inside, 'labelled face lies', 'labelled faces lie')} inside, not on the boundary: left out")
    bare = np.flatnonzero(label < 0)
    if len(bare) and rest:
        names += [rest] if rest not in names else []
        label[bare] = names.index(rest)
    elif len(bare):
        area = np.linalg.norm(topology.areas(points, faces[bare]), axis=1).sum()
        raise Refusal(f"{mesh.source}: open: {len(bare):,} of {len(faces):,} faces of the boundary have no label, "
                      f"{area * 1e6:.4g} mm^2 in all, one around {place(points[faces[bare[0]]].mean(axis=0))}. "
                      f"{'Labels: ' + ', '.join(names) if names else 'There are no labels'}. Label them in the mesher, or "
                      "name them all with --rest LABEL")
    return faces, label, names


def part(mesh, unit, mapping=None, rest=""):
    """A Part of a Foreign mesh. Nodes that no cell has are dropped."""
    kind, metres = one_kind(mesh), scale(mesh, unit)
    check_numbers(mesh, kind)
    cells, points = mesh.cells[kind], mesh.points * metres
    if VERTICES[kind] == 8:
        cells = topology.lexicographic(cells)
    cells = oriented(mesh, kind, points, cells)
    faces, label, names = label_faces(mesh, kind, points, cells, mapping or {}, rest)
    used, inverse = np.unique(cells, return_inverse=True)
    if len(used) < len(points):
        mesh.notes.append(f"{count(len(points) - len(used), 'node belongs', 'nodes belong')} to no cell: dropped")
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))
    return Part(points[used], kind, inverse.reshape(cells.shape), mesh.regions[kind], mesh.region_names, number[faces], label,
                names)


def split(mesh, blood):
    """(wall, blood) of one mesh: the cells of the regions `blood` are the fluid; what they share with others is the
    interface."""
    kind = one_kind(mesh)
    unknown = [name for name in blood if name not in mesh.region_names]
    if unknown:
        raise Refusal(f"{mesh.source}: has no region '{unknown[0]}'; it has {', '.join(mesh.region_names)}")
    is_blood = np.isin(mesh.regions[kind], [mesh.region_names.index(name) for name in blood])
    cells = mesh.cells[kind]
    ordered = topology.lexicographic(cells) if kind == "hexahedra" else cells
    sides = [topology.boundary(kind, ordered[chosen], len(mesh.points)) for chosen in (~is_blood, is_blood)]
    shared = np.isin(topology.face_keys(sides[1][0], len(mesh.points)), sides[0][2])
    interface = Surface("interface", sides[1][0][shared])
    both = []
    for chosen, (_, _, keys, _) in zip((~is_blood, is_blood), sides):
        regions = mesh.regions[kind][chosen]
        present = np.unique(regions)
        own = [Surface(s.name, s.faces[np.isin(topology.face_keys(s.faces, len(mesh.points)), keys)]) for s in mesh.surfaces]
        fields = {name: values[chosen] for name, values in mesh.cell_fields.items()}
        both.append(Foreign(mesh.source, mesh.points, {kind: cells[chosen]}, {kind: np.searchsorted(present, regions)},
                            [mesh.region_names[i] for i in present], [s for s in own if len(s.faces)] + [interface],
                            mesh.point_fields, fields, mesh.unit, list(mesh.notes)))
    return both
