"""Faces, volumes, quality and connectedness of cells, on whole arrays."""
import numpy as np

FACES = {"tetrahedra": [(0, 1, 2), (1, 0, 3), (0, 2, 3), (2, 1, 3)],
         "hexahedra": [(0, 2, 4, 6), (1, 3, 5, 7), (0, 1, 4, 5), (2, 3, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7)]}
EDGES = {"tetrahedra": [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)],
         "hexahedra": [(a, a + step) for step in (1, 2, 4) for a in range(8) if not a & step]}


def lexicographic(cells):
    """VTK goes around quadrilaterals; of hexahedra and quadrilaterals the order here is lexicographic. Its own inverse."""
    order = {8: [0, 1, 3, 2, 4, 5, 7, 6], 4: [0, 1, 3, 2]}[cells.shape[1]]
    return cells[:, order]


def face_keys(faces, n_points):
    """A number for each face, the same however its vertices are ordered; three vertices tell one face from another."""
    v = np.sort(faces.astype(np.int64), axis=1)
    return (v[:, 0] * n_points + v[:, 1]) * n_points + v[:, 2]


def all_faces(kind, cells):
    """((cells x faces), vertices) of all faces of all cells, and the cell of each."""
    local = np.array(FACES[kind])
    return cells[:, local].reshape(-1, local.shape[1]), np.repeat(np.arange(len(cells)), len(local))


def boundary(kind, cells, n_points):
    """(faces that one cell has, their cells, their keys ascending, one face of more than two cells or None)."""
    faces, owners = all_faces(kind, cells)
    keys = face_keys(faces, n_points)
    unique, first, counts = np.unique(keys, return_index=True, return_counts=True)
    once = first[counts == 1]
    crowded = first[counts > 2]
    return faces[once], owners[once], unique[counts == 1], faces[crowded[0]] if len(crowded) else None


def corner_volumes(kind, points, cells):
    """(cells, corners) of the Jacobian's determinant at the corners; six volumes for a tetrahedron."""
    x = points[cells]
    if kind == "tetrahedra":
        return np.linalg.det(x[:, 1:] - x[:, :1])[:, None]
    corners = [np.linalg.det(np.stack([x[:, v | bit] - x[:, v & ~bit] for bit in (1, 2, 4)], axis=1)) for v in range(8)]
    return np.stack(corners, axis=1)


GAUSS = (0.5 - np.sqrt(1 / 12), 0.5 + np.sqrt(1 / 12))


def volumes(kind, points, cells):
    """Exact, of straight and of trilinear cells."""
    if kind == "tetrahedra":
        return corner_volumes(kind, points, cells)[:, 0] / 6
    x, total = points[cells], np.zeros(len(cells))
    for t in np.array(np.meshgrid(GAUSS, GAUSS, GAUSS)).reshape(3, -1).T:
        slopes = np.ones((3, 8))
        for v in range(8):
            for e in range(3):
                for i in range(3):
                    high = v >> i & 1
                    slopes[e, v] *= (1 if high else -1) if i == e else (t[i] if high else 1 - t[i])
        total += np.linalg.det(np.einsum("ev,cvk->cek", slopes, x)) / 8
    return total


def quality(kind, points, cells):
    """From 0, flat, to 1: of tetrahedra the mean ratio 12 (3 V)^(2/3) / (sum of the squares of the edges) (Liu, Joe 1994,
    doi 10.1007/BF01955874); of hexahedra the smallest Jacobian at a corner over the product of its edges."""
    x, edges = points[cells], EDGES[kind]
    if kind == "tetrahedra":
        squares = sum(((x[:, a] - x[:, b]) ** 2).sum(axis=1) for a, b in edges)
        return 12 * np.cbrt(3 * np.maximum(volumes(kind, points, cells), 0)) ** 2 / squares
    determinants, worst = corner_volumes(kind, points, cells), np.full(len(cells), np.inf)
    for v in range(8):
        lengths = np.prod([np.linalg.norm(x[:, v ^ bit] - x[:, v], axis=1) for bit in (1, 2, 4)], axis=0)
        worst = np.minimum(worst, determinants[:, v] / np.maximum(lengths, 1e-300))
    return worst


def edge_lengths(kind, points, cells):
    return np.concatenate([np.linalg.norm(points[cells[:, a]] - points[cells[:, b]], axis=1) for a, b in EDGES[kind]])


def mirrored(kind, cells):
    """The same cells with the other orientation."""
    return cells[:, [1, 0, 2, 3]] if kind == "tetrahedra" else cells[:, [1, 0, 3, 2, 5, 4, 7, 6]]


def parts(cells, n_points):
    """(cells,) the number of the connected part of each cell, 0, 1, ...: cells that share a node are connected."""
    lowest = np.arange(n_points)
    while True:
        in_cells = lowest[cells].min(axis=1)
        after = lowest.copy()
        np.minimum.at(after, cells, in_cells[:, None])
        after = after[after]
        if np.array_equal(after, lowest):
            return np.unique(lowest[cells[:, 0]], return_inverse=True)[1]
        lowest = after


def around(faces):
    """Vertices in the order around the face."""
    return faces if faces.shape[1] == 3 else faces[:, [0, 1, 3, 2]]


def edge_uses(faces):
    """(edges (e, 2), how many faces have each)."""
    ring = around(faces)
    edges = np.sort(np.stack([ring, np.roll(ring, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    return np.unique(edges, axis=0, return_counts=True)


def rims(faces):
    """Closed lines that bound a surface: a list of arrays of nodes, the longest first."""
    edges, uses = edge_uses(faces)
    neighbours = {}
    for a, b in edges[uses == 1]:
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    loops, left = [], set(neighbours)
    while left:
        stack, loop = [left.pop()], []
        while stack:
            node = stack.pop()
            loop.append(node)
            for other in neighbours[node]:
                if other in left:
                    left.remove(other)
                    stack.append(other)
        loops.append(np.array(loop))
    return sorted(loops, key=len, reverse=True)


def areas(points, faces):
    """Areas as vectors (k, 3), halves of the diagonals' cross product for quadrilaterals."""
    x = points[around(faces)]
    if faces.shape[1] == 3:
        return np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]) / 2
    return np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]) / 2


def nearest(points, targets):
    """(index of the nearest of `points`, distance) of each target."""
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk
    data, cloud = vtk.vtkPolyData(), vtk.vtkPoints()
    cloud.SetData(numpy_to_vtk(np.ascontiguousarray(points, dtype=float), deep=True))
    data.SetPoints(cloud)
    locator = vtk.vtkStaticPointLocator()
    locator.SetDataSet(data)
    locator.BuildLocator()
    index = np.array([locator.FindClosestPoint(x) for x in targets], dtype=np.int64)
    return index, np.linalg.norm(points[index] - targets, axis=1)
