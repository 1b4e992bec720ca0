"""What must hold of a mesh, and of wall and blood together. Each fault is one Refusal: what, where, how to mend it."""
import numpy as np

from . import topology
from .model import UNITS, Refusal, count, place

VOLUMES = (1e-6, 1e-3)  # [m^3] of the smallest and the largest cavity that is taken for a human heart's


def check_connected(name, part):
    pieces = topology.parts(part.cells, len(part.points))
    sizes = np.bincount(pieces)
    if len(sizes) > 1:
        small = sizes.argmin()
        where = part.points[part.cells[pieces == small]].reshape(-1, 3).mean(axis=0)
        raise Refusal(f"{name}: {len(sizes)} parts that share no node, of {', '.join(f'{n:,}' for n in sorted(sizes)[::-1][:5])} "
                      f"cells; the smallest is around {place(where)}. Merge coinciding nodes, or remove what does not belong")


def check_surface(name, part):
    """The boundary is closed, and touches itself nowhere."""
    edges, uses = topology.edge_uses(part.faces)
    bad = np.flatnonzero(uses != 2)
    if len(bad):
        where = part.points[edges[bad[0]]].mean(axis=0)
        raise Refusal(f"{name}: {'open' if uses[bad[0]] < 2 else 'touches itself'}: the edge around {place(where)} belongs to "
                      f"{uses[bad[0]]} faces of the boundary, two must be ({count(len(bad), 'such edge', 'such edges')})")


def check_coincident(name, part):
    order = np.lexsort(part.points.T)
    same = np.flatnonzero((np.diff(part.points[order], axis=0) == 0).all(axis=1))
    if len(same):
        raise Refusal(f"{name}: nodes {order[same[0]]} and {order[same[0] + 1]} are both at {place(part.points[order[same[0]]])} "
                      f"({count(len(same), 'such pair', 'such pairs')}): a crack; merge coinciding nodes")


def check_part(name, part):
    check_coincident(name, part)
    check_connected(name, part)
    check_surface(name, part)


def check_size(volume, unit, any_size):
    """`volume` [m^3] of the blood, or of the wall of a mesh without blood, read in `unit`."""
    if any_size or VOLUMES[0] <= volume <= VOLUMES[1]:
        return
    others = {name: volume * (UNITS[name] / UNITS[unit]) ** 3 * 1e6 for name in UNITS if name != unit}
    likely = [f"with --unit {name} it would be {v:.3g} mL" for name, v in others.items() if 10 < v < 500]
    raise Refusal(f"a volume of {volume * 1e6:.3g} mL is no human heart's (1 to 1000 mL): is {unit} the wrong unit? "
                  f"{'; '.join(likely) + '. ' if likely else ''}--any-size takes it as it is")


def check_interfaces(solid, fluid):
    """The interfaces are the same nodes and the same faces; small differences are rounding, and are taken away: the blood's
    nodes get the wall's coordinates. Returns the largest distance [m]."""
    for name, part in (("solid", solid), ("fluid", fluid)):
        if "interface" not in part.label_names:
            raise Refusal(f"{name}: no label `interface` (the endocardium, on both meshes); it has "
                          f"{', '.join(part.label_names)}: --label FOREIGN=interface names it")
    in_solid, in_fluid = solid.nodes_of("interface"), fluid.nodes_of("interface")
    edges, _ = topology.edge_uses(solid.faces_of("interface"))
    shortest = np.linalg.norm(solid.points[edges[:, 0]] - solid.points[edges[:, 1]], axis=1).min()
    partner, distance = compare(solid, in_solid, fluid, in_fluid, shortest, "fluid", "solid")
    compare(fluid, in_fluid, solid, in_solid, shortest, "solid", "fluid")
    twin = np.full(len(fluid.points), -1)
    twin[in_fluid] = in_solid[partner]
    there = np.sort(topology.face_keys(solid.faces_of("interface"), len(solid.points)))
    faces = fluid.faces_of("interface")
    here = topology.face_keys(twin[faces], len(solid.points))
    lonely = np.flatnonzero(~np.isin(here, there))
    if len(lonely) or len(here) != len(there):
        where = fluid.points[faces[lonely[0]]].mean(axis=0) if len(lonely) else fluid.points[in_fluid].mean(axis=0)
        raise Refusal(f"the interfaces share nodes, but not faces: {len(here):,} faces of the blood, {len(there):,} of the wall, "
                      f"{len(lonely):,} of the blood without partner, one around {place(where)}: mesh both with one surface")
    fluid.points[in_fluid] = solid.points[in_solid[partner]]
    check_sides(solid, fluid)
    return distance.max()


def inward(part):
    """(centres of the faces of the interface, vectors from there to the centres of their cells)."""
    faces, owners, _, _ = topology.boundary(part.kind, part.cells, len(part.points))
    key = topology.face_keys(faces, len(part.points))
    on = np.isin(key, topology.face_keys(part.faces_of("interface"), len(part.points)))
    centres = part.points[faces[on]].mean(axis=1)
    return centres, part.points[part.cells[owners[on]]].mean(axis=1) - centres


def check_sides(solid, fluid):
    (here, into_solid), (there, into_fluid) = inward(solid), inward(fluid)
    partner, _ = topology.nearest(here, there)
    same = np.flatnonzero((into_solid[partner] * into_fluid).sum(axis=1) > 0)
    if len(same) > len(there) // 2:
        raise Refusal("wall and blood lie on the same side of the interface: was one mesh given twice?")


def compare(of, nodes_of, to, nodes_to, shortest, name_to, name_of):
    """Each node of `to` has one of `of` at its place."""
    index, distance = topology.nearest(of.points[nodes_of], to.points[nodes_to])
    apart = np.flatnonzero(distance > 1e-3 * shortest)
    if len(apart):
        worst = distance.argmax()
        raise Refusal(f"the interfaces do not conform: {len(apart):,} of {len(nodes_to):,} nodes of the {name_to}'s are not "
                      f"among the {name_of}'s; the worst is node {nodes_to[worst]} at {place(to.points[nodes_to[worst]])}, "
                      f"{distance[worst] * 1e3:.3g} mm from the nearest. Mesh both with one surface, or look at the labels")
    return index, distance


def check_cells(name, part):
    """Of a mesh file, which may be damaged: finite places, positive cells, a label for each face of the boundary, fibres."""
    bad = np.flatnonzero(~np.isfinite(part.points).all(axis=1))
    if len(bad):
        raise Refusal(f"{name}: node {bad[0]} is at {tuple(part.points[bad[0]])}, no finite place; import the mesh again")
    worst = topology.corner_volumes(part.kind, part.points, part.cells).min(axis=1)
    if not worst.min() > 0:
        cell = worst.argmin()
        raise Refusal(f"{name}: cell {cell} around {place(part.points[part.cells[cell]].mean(axis=0))} is inverted; import the "
                      "mesh again")
    _, _, keys, _ = topology.boundary(part.kind, part.cells, len(part.points))
    if not np.array_equal(np.sort(topology.face_keys(part.faces, len(part.points))), keys):
        raise Refusal(f"{name}: its faces are not its boundary, each once; import the mesh again")
    if part.fibres is not None:
        products = np.einsum("cik,cjk->cij", part.fibres, part.fibres) - np.eye(2)
        cell = np.abs(products).max(axis=(1, 2)).argmax()
        if not np.abs(products[cell]).max() < 1e-6:
            raise Refusal(f"{name}: fibre and sheet of cell {cell} around "
                          f"{place(part.points[part.cells[cell]].mean(axis=0))} are no orthogonal unit vectors")
