"""Gmsh's .msh 2.2 and 4.1, text or binary, with the names of physical groups, by its own library."""
import contextlib

import numpy as np

from .model import Foreign, Refusal, Surface

# Gmsh's element type: (kind, vertices in the file, corners, dimension)
TYPES = {2: ("triangles", 3, 3), 9: ("triangles", 6, 3), 3: ("quadrilaterals", 4, 4), 10: ("quadrilaterals", 9, 4),
         16: ("quadrilaterals", 8, 4), 4: ("tetrahedra", 4, 4), 11: ("tetrahedra", 10, 4), 5: ("hexahedra", 8, 8),
         12: ("hexahedra", 27, 8), 17: ("hexahedra", 20, 8), 6: ("wedges", 6, 6), 7: ("pyramids", 5, 5)}


@contextlib.contextmanager
def library():
    """Gmsh, silent, for as long as it is needed."""
    try:
        import gmsh
    except ImportError:
        raise Refusal("gmsh is missing; ./run installs it, or apt-get install python3-gmsh") from None
    gmsh.initialize(readConfigFiles=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        yield gmsh
    finally:
        gmsh.finalize()


def read(path):
    with library() as gmsh:
        try:
            gmsh.open(str(path))
            return model(gmsh, path)
        except Refusal:
            raise
        except Exception as error:  # of whatever class: the library has none of its own
            raise Refusal(f"{path}: gmsh cannot read it: {error}; is it truncated, or of another format than .msh 2.2 or "
                          "4.1?") from None


def names_of_entities(gmsh, dimension, what):
    """{entity: name of its physical group}."""
    names = {}
    for _, group in gmsh.model.getPhysicalGroups(dimension):
        name = gmsh.model.getPhysicalName(dimension, group) or f"{what}_{group}"
        for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, group):
            if names.setdefault(entity, name) != name:
                raise Refusal(f"entity {entity} is in two physical groups, '{names[entity]}' and '{name}'; it may be in one")
    return names


def elements(gmsh, dimension, entity, number_of_tag):
    """(kind, corners (m, k) as indices of points) of the elements of an entity."""
    types, _, nodes = gmsh.model.mesh.getElements(dimension, entity)
    for kind, tags in zip(types, nodes):
        if kind not in TYPES:
            raise Refusal(f"elements of gmsh's type {kind} are not known here; tetrahedra, hexahedra and their faces are")
        name, width, corners = TYPES[kind]
        yield name, width > corners, number_of_tag[tags.astype(np.int64)].reshape(-1, width)[:, :corners]


def model(gmsh, path):
    tags, x, _ = gmsh.model.mesh.getNodes()
    number_of_tag = np.full(int(tags.max(initial=0)) + 1, -1)
    number_of_tag[tags.astype(np.int64)] = np.arange(len(tags))
    mesh = Foreign(str(path), x.reshape(-1, 3), {}, {}, [])
    names, curved, cells = names_of_entities(gmsh, 3, "region"), False, {}
    for _, entity in gmsh.model.getEntities(3):
        name = names.get(entity, "unnamed")
        for kind, is_curved, corners in elements(gmsh, 3, entity, number_of_tag):
            curved |= is_curved
            if name not in mesh.region_names:
                mesh.region_names.append(name)
            cells.setdefault(kind, []).append((corners, np.full(len(corners), mesh.region_names.index(name))))
    for kind, blocks in cells.items():
        mesh.cells[kind] = np.concatenate([block for block, _ in blocks])
        mesh.regions[kind] = np.concatenate([regions for _, regions in blocks])
    names = names_of_entities(gmsh, 2, "surface")
    for _, entity in gmsh.model.getEntities(2):
        for _, is_curved, corners in elements(gmsh, 2, entity, number_of_tag):
            curved |= is_curved
            if entity in names:
                mesh.surfaces.append(Surface(names[entity], corners))
    if curved:
        mesh.notes.append("cells of second order: their corners are taken, edges become straight")
    return mesh
