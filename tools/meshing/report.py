"""What is said of meshes."""
import numpy as np

from . import labels as naming
from . import topology
from .model import UNITS, count, place


def size(points, unit="m"):
    lengths = np.ptp(points, axis=0) * UNITS[unit] * 1e3
    return " x ".join(f"{length:.4g}" for length in lengths) + " mm"


def of_part(name, part):
    """Lines on one mesh of a mesh file."""
    volumes = topology.volumes(part.kind, part.points, part.cells)
    edges, quality = topology.edge_lengths(part.kind, part.points, part.cells), topology.quality(part.kind, part.points, part.cells)
    worst = quality.argmin()
    measure = "mean ratio" if part.kind == "tetrahedra" else "scaled Jacobian"
    yield f"{name}: {len(part.cells):,} {part.kind}, {len(part.points):,} nodes, {size(part.points)}"
    yield f"  {'volume of the wall' if name == 'solid' else 'cavity'} {volumes.sum() * 1e6:.4g} mL, closed; all cells positive"
    yield (f"  edges {edges.min() * 1e3:.3g} to {edges.max() * 1e3:.3g} mm; quality ({measure}) {quality[worst]:.2f} to "
           f"{quality.max():.2f}, the worst in cell {worst} around {place(part.points[part.cells[worst]].mean(axis=0))}"
           + (": a poor cell, expect slow solvers" if quality[worst] < 0.05 else ""))
    for label in part.label_names:
        faces = part.faces_of(label)
        area = np.linalg.norm(topology.areas(part.points, faces), axis=1).sum()
        yield f"  label {label}: {len(faces):,} faces, {area * 1e6:,.0f} mm^2"
    lacking = naming.missing(name, part.label_names)
    if lacking:
        yield f"  without the label{'s' if len(lacking) > 1 else ''} {', '.join(lacking)}, which scenes use unless they name others"
    for region, n in zip(part.region_names, np.bincount(part.regions, minlength=len(part.region_names))):
        yield f"  region {region}: {count(int(n), 'cell', 'cells')}"
    if name == "solid":
        yield f"  fibres: {'one pair a cell (fibres.rule: file)' if part.fibres is not None else 'none'}"


def of_foreign(mesh, unit):
    """Lines on a mesh of another program, as it is."""
    extent = np.ptp(mesh.points, axis=0)
    yield f"{mesh.source}: {len(mesh.points):,} nodes, {' x '.join(f'{x:.4g}' for x in extent)} " + \
        (unit or mesh.unit or "(in which unit?)")
    for kind, cells in mesh.cells.items():
        line = f"  {len(cells):,} {kind}"
        if kind in topology.FACES:
            ordered = topology.lexicographic(cells) if kind == "hexahedra" else cells
            negative = (topology.corner_volumes(kind, mesh.points, ordered) < 0).all(axis=1).sum()
            volume = abs(topology.volumes(kind, mesh.points, ordered)).sum()
            line += f", {negative:,} negatively oriented; volume " + (
                f"{volume * UNITS[unit or mesh.unit] ** 3 * 1e6:.4g} mL" if unit or mesh.unit else
                " or ".join(f"{volume * factor ** 3 * 1e6:.3g} mL (in {name})" for name, factor in UNITS.items()))
            faces = len(topology.boundary(kind, ordered, len(mesh.points))[0])
            line += f"; {faces:,} faces on the boundary"
        yield line
        for i, region in enumerate(mesh.region_names):
            if (mesh.regions[kind] == i).any():
                yield f"    region {region}: {(mesh.regions[kind] == i).sum():,}"
    for name in dict.fromkeys(surface.name for surface in mesh.surfaces):
        faces = [surface.faces for surface in mesh.surfaces if surface.name == name]
        middle = np.mean([mesh.points[f].mean(axis=(0, 1)) for f in faces], axis=0)
        label = naming.guess(name)
        yield f"  surface {name}: {sum(map(len, faces)):,} faces around ({', '.join(f'{x:.4g}' for x in middle)})" + \
            (f", taken for {label}" if label != name else "")
    for what, fields in (("node", mesh.point_fields), ("cell", mesh.cell_fields)):
        for name, values in fields.items():
            yield f"  array {name}: {values.shape[1]} a {what}"
    for note in mesh.notes:
        yield f"  {note}"


def stimulus_sites(part):
    """Three places [m] on the endocardium, spread around it, about half way from apex to base; None without."""
    nodes = part.nodes_of("interface")
    base = part.nodes_of("base")
    if not len(nodes) or not len(base):
        return None
    x, middle = part.points[nodes], part.points[base].mean(axis=0)
    apex = x[np.linalg.norm(x - middle, axis=1).argmax()]
    axis = (middle - apex) / np.linalg.norm(middle - apex)
    e = np.eye(3)[np.abs(axis).argmin()]
    u = np.cross(axis, e) / np.linalg.norm(np.cross(axis, e))
    v, height = np.cross(axis, u), 0.45 * np.linalg.norm(middle - apex)
    off = x - apex - ((x - apex) @ axis)[:, None] * axis
    radius = np.median(np.linalg.norm(off, axis=1))
    wanted = [apex + height * axis + radius * (np.cos(t) * u + np.sin(t) * v) for t in 2 * np.pi / 3 * np.arange(3)]
    return [x[np.linalg.norm(x - place_wanted, axis=1).argmin()] for place_wanted in wanted]


def resolution(part):
    """Elements of electrophysiology whose nodes are 3 mm apart at most at the median of all edges: the front is steep."""
    degree = 2 if part.kind == "tetrahedra" else 1
    apart, n = np.median(topology.edge_lengths(part.kind, part.points, part.cells)) / degree, 0
    while apart > 3e-3:
        apart, n = apart / 2, n + 1
    if degree == 2:
        yield "    degree: 2"
    yield f"    refinements: {n}                    # nodes {apart * 1e3:.1f} mm apart; {len(part.cells) * 8 ** n:,} elements"


def fibre_rule(part):
    """The rule transmural, which scenes have by themselves, needs a flat base with normal +z."""
    if part is None or "base" not in part.label_names:
        return
    normals = topology.areas(part.points, part.faces_of("base"))
    upright = np.abs(normals[:, 2]) > 0.999 * np.linalg.norm(normals, axis=1)
    height = np.ptp(part.points[part.nodes_of("base"), 2])
    apex_below = part.points[part.nodes_of("base"), 2].mean() > part.points[:, 2].mean()
    if part.fibres is not None:
        yield "  fibres: {rule: file}"
    elif not (upright.all() and apex_below and height < 1e-3 * np.ptp(part.points)):
        yield "  fibres: {rule: apicobasal, rings: [base]}"


def labels_in_use(parts):
    """Lines for what scenes take for granted and this mesh has otherwise."""
    solid, fluid = (set(parts[name].label_names) if name in parts else None for name in ("solid", "fluid"))
    if solid is not None and "base" not in solid:
        yield f"  mechanics: {{fixed: []}}              # or some of {', '.join(sorted(solid - {'interface'}))}"
    if fluid is not None and not {"base", "mitral", "aortic"} <= fluid:
        others = sorted(fluid - {"interface"})
        walls = [label for label in others if label not in ("mitral", "aortic")]
        yield f"  lifting: {{fixed: [{', '.join(others)}]}}"
        yield f"  fluid: {{no_slip: [{', '.join(walls)}]}}"


def for_scene(path, parts):
    """What to write into the scene."""
    yield "In the scene:"
    yield f"  geometry: {{shape: file, mesh: {path.name}}}      # the path is relative to the scene"
    yield from fibre_rule(parts.get("solid"))
    sites = stimulus_sites(parts["solid"]) if "solid" in parts else None
    if sites:
        yield "  electrophysiology:"
        yield from resolution(parts["solid"])
        yield "    stimulus:"
        yield "      sites:                            # for a start: three places on the endocardium"
        for site in sites:
            x = ", ".join(f"{value * 1e3:.1f} mm" for value in site)
            yield f"        - {{centre: [{x}], radius: 12 mm}}"
    yield from labels_in_use(parts)
    if "solid" in parts and len(parts["solid"].region_names) > 1:
        yield f"  # regions of the wall: {', '.join(parts['solid'].region_names)}"
