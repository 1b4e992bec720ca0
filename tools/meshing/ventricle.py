"""A left ventricle with inflow and outflow tract, made by gmsh: wall and blood of tetrahedra that share the endocardium.

Lengths in mm; z points from apex to base. Cavity and wall are two half ellipsoids each, a long one below and a dome above
the equator, with a tube through the dome for each valve; the tubes' axes diverge, so that the valves lie in two planes. What
of the wall is above the base of the muscle, roof and tubes, is the region `ring`. The meshed body is then bent and flattened:
the apex lies aside of the axis, and one side, the septum, is flatter than the other. Dimensions are within what is normal for
adults (Lang et al. 2015, doi 10.1016/j.echo.2014.10.003)."""
import numpy as np

from .model import Foreign, Refusal, Surface
from .read_gmsh import library

EQUATOR, DEPTH, DOME = 22.0, 59.0, 20.0      # semi-axes of the cavity: across, down to the apex, up
WALL, WALL_APEX, ROOF = 10.0, 8.5, 8.0       # added to them for the epicardium
MUSCLE_TOP = 9.0                             # z from which on the wall is `ring`
TUBE_WALL = 4.0
# The axis of a tube leaves the equator's plane at x = start, tilted away from the other one.
VALVES = {"mitral": {"start": -6.0, "tilt": -25.0, "radius": 12.0, "length": 31.0},
          "aortic": {"start": 7.0, "tilt": 27.0, "radius": 10.0, "length": 38.0}}
BEND, FLATTEN = 9.0, 0.003                   # shift of the apex; part of x^2 by which the septum is flatter [1/mm]
# Edges [mm] on the endocardium, on other surfaces of the wall, in the middle of the blood.
SIZES = {"coarse": (3.9, 4.6, 2.8), "medium": (2.7, 3.2, 2.1), "paper": (1.85, 2.25, 1.1)}


def direction(valve):
    tilt = np.radians(valve["tilt"])
    return np.array([np.sin(tilt), 0, np.cos(tilt)])


def end(valve):
    return np.array([valve["start"], 0, 0]) + valve["length"] * direction(valve)


def body(occ, across, down, up, more):
    """One solid: two half ellipsoids and the tubes, whose radii are larger by `more`."""
    pieces = []
    for c, low in ((down, True), (up, False)):
        half = occ.addSphere(0, 0, 0, 1, angle1=-np.pi / 2 if low else 0, angle2=0 if low else np.pi / 2)
        occ.dilate([(3, half)], 0, 0, 0, across, across, c)
        occ.rotate([(3, half)], 0, 0, 0, 0, 0, 1, np.pi / 2)  # the seam of the surface away from the tubes
        pieces.append((3, half))
    for valve in VALVES.values():
        axis = valve["length"] * direction(valve)
        pieces.append((3, occ.addCylinder(valve["start"], 0, 0, *axis, valve["radius"] + more)))
    return occ.fuse(pieces[:1], pieces[1:])[0]


def build(gmsh):
    """Volumes of the geometry: {"muscle": tags, "ring": tags, "blood": tags}."""
    occ = gmsh.model.occ
    blood = body(occ, EQUATOR, DEPTH, DOME, 0)
    outside = body(occ, EQUATOR + WALL, DEPTH + WALL_APEX, DOME + ROOF, TUBE_WALL)
    wall = occ.cut(outside, blood, removeTool=False)[0]
    above = [(3, occ.addBox(-100, -100, MUSCLE_TOP, 200, 200, 200))]
    ring = occ.intersect(wall, above, removeObject=False, removeTool=False)[0]
    muscle = occ.cut(wall, above)[0]
    _, pieces = occ.fragment(muscle, ring + blood)
    occ.synchronize()
    n, m = len(muscle), len(ring)
    groups = {"muscle": pieces[:n], "ring": pieces[n:n + m], "blood": pieces[n + m:]}
    return {name: [tag for piece in found for _, tag in piece] for name, found in groups.items()}


def label(gmsh, surface, neighbours, volumes):
    """The boundary part that a surface of the geometry belongs to; empty inside wall or blood."""
    in_blood = [volume in volumes["blood"] for volume in neighbours]
    if len(neighbours) == 2:
        return "interface" if in_blood[0] != in_blood[1] else ""
    box = np.array(gmsh.model.getBoundingBox(2, surface)).reshape(2, 3)
    for name, valve in VALVES.items():
        corners = [np.array([box[i, 0], 0, box[j, 2]]) for i, j in ((0, 1), (1, 0), (0, 0), (1, 1))]
        heights = np.abs([(corner - end(valve)) @ direction(valve) for corner in corners])
        if np.sort(heights)[1] < 1e-3:  # a flat face across the axis: two corners of its box lie in the plane
            return name if in_blood[0] else "base"
    return "epicardium"


def labelled(gmsh, volumes):
    """{surface: label}"""
    found = {}
    for _, surface in gmsh.model.getEntities(2):
        neighbours, _ = gmsh.model.getAdjacencies(2, surface)
        found[surface] = label(gmsh, surface, list(neighbours), volumes)
    return found


def set_sizes(gmsh, volumes, labels, size):
    """Edges by the distance from the endocardium, into the wall and into the blood."""
    on_endocardium, *farther = SIZES[size]
    field, fields = gmsh.model.mesh.field, []

    def add(kind, numbers, lists):
        tag = field.add(kind)
        for name, value in numbers.items():
            field.setNumber(tag, name, value)
        for name, values in lists.items():
            field.setNumbers(tag, name, values)
        return tag
    interface = [surface for surface, name in labels.items() if name == "interface"]
    distance = add("Distance", {"NNodesByEdge": 40}, {"SurfacesList": interface})
    sides = (volumes["muscle"] + volumes["ring"], volumes["blood"])
    for side, reach, edge in zip(sides, (WALL, 0.6 * EQUATOR), farther):
        surfaces = [s for s in labels if set(gmsh.model.getAdjacencies(2, s)[0]) & set(side)]
        growth = add("Threshold", {"InField": distance, "DistMin": 0, "DistMax": reach, "SizeMin": on_endocardium,
                                   "SizeMax": edge}, {})
        curves = {curve for s in surfaces for curve in gmsh.model.getAdjacencies(2, s)[1]}
        fields.append(add("Restrict", {"InField": growth},
                          {"VolumesList": side, "SurfacesList": surfaces, "CurvesList": sorted(curves)}))
    field.setAsBackgroundMesh(add("Min", {}, {"FieldsList": fields}))
    for option in ("MeshSizeFromPoints", "MeshSizeExtendFromBoundary"):
        gmsh.option.setNumber(f"Mesh.{option}", 0)


def bent(points):
    """The apex aside, the septum (x > 0) flatter; nothing moves above the base of the muscle."""
    x, y, z = points.T
    below = np.maximum(0, MUSCLE_TOP - z) / (DEPTH + MUSCLE_TOP)
    share = np.clip((MUSCLE_TOP - z) / 25, 0, 1)
    share = share ** 2 * (3 - 2 * share)
    return np.stack([x - FLATTEN * share * (x ** 2 - 200) + BEND * below ** 2, y, z], axis=1)


def blocks(gmsh, dimension, tags, number_of_tag):
    """(cells, vertices) of entities."""
    return np.concatenate([number_of_tag[nodes.astype(np.int64)].reshape(-1, dimension + 1) for tag in tags
                           for nodes in gmsh.model.mesh.getElements(dimension, tag)[2]])


def collect(gmsh, volumes, labels):
    """{"solid": Foreign, "fluid": Foreign} [mm] of what gmsh has meshed, bent."""
    tags, x, _ = gmsh.model.mesh.getNodes()
    number_of_tag = np.full(int(tags.max()) + 1, -1)
    number_of_tag[tags.astype(np.int64)] = np.arange(len(tags))
    points, meshes = bent(x.reshape(-1, 3)), {}
    for name, regions in (("solid", ["muscle", "ring"]), ("fluid", ["blood"])):
        cells = [blocks(gmsh, 3, volumes[region], number_of_tag) for region in regions]
        own = {volume for region in regions for volume in volumes[region]}
        surfaces = [Surface(label, blocks(gmsh, 2, [surface], number_of_tag)) for surface, label in labels.items()
                    if label and own & set(gmsh.model.getAdjacencies(2, surface)[0])]
        meshes[name] = Foreign("gmsh", points, {"tetrahedra": np.concatenate(cells)},
                               {"tetrahedra": np.repeat(np.arange(len(cells)), [len(block) for block in cells])}, regions,
                               surfaces)
    return meshes


def make(size):
    """{"solid": Foreign, "fluid": Foreign} [mm]"""
    with library() as gmsh:
        try:
            volumes = build(gmsh)
            labels = labelled(gmsh, volumes)
            set_sizes(gmsh, volumes, labels, size)
            gmsh.option.setNumber("Mesh.Algorithm", 1)  # adapts best where tubes leave the body at small angles
            gmsh.model.mesh.generate(3)
            return collect(gmsh, volumes, labels)
        except Exception as error:  # of whatever class: the library has none of its own
            raise Refusal(f"gmsh cannot make the ventricle: {error}") from None
