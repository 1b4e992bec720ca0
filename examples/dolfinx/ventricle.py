"""Meshes of heartbus in DOLFINx, and the fibres of the ideal ventricle."""
import gc
import os

import h5py
import numpy as np

import heartbus

ACROSS, ALONG, WALL = 22e-3, 62e-3, 10e-3                      # of the ellipsoid: endocardium, thickness, m
ENDO, EPI, DISPERSION = np.deg2rad([60.0, -60.0, 30.0])         # angles of the fibres


def take_part(name, program, part):
    """Joins a run and does `part(bus)`. PETSc gets the ranks of this participant before it is first imported: it would
    take those of all programs. What it and DOLFINx hold is freed before MPI ends."""
    with heartbus.join(name, program) as bus:
        import petsc4py
        petsc4py.init([], comm=bus.communicator)
        from petsc4py import PETSc
        part(bus)
        gc.collect()
        PETSc._finalize()


class Body:
    """The solid or the fluid of a mesh file (coupler SCENE --write-mesh FILE), and linear vectors on it, whose nodes
    are the points of the bus: `x`, the owned ones first [m], and by label nodes and facets of a boundary part."""

    def __init__(self, communicator, path, part):
        import dolfinx
        import ufl
        if not os.path.exists(path):
            raise heartbus.Failure(heartbus.FILE, f"there is no {path}: coupler SCENE --write-mesh {path} makes it")
        with h5py.File(path) as file:
            group = file[part]
            self._points, cells, faces = (group[name][()] for name in ("points", "cells", "faces"))
            self._faces = dict(enumerate(group.attrs["label_names"].decode().split("\n")))
            self._faces = {label: faces[group["face_labels"][()] == index] for index, label in self._faces.items()}
        mine = cells[communicator.rank::communicator.size].astype(np.int64)
        domain = ufl.Mesh(ufl.VectorElement("Lagrange", ufl.hexahedron, 1))
        self.mesh = dolfinx.mesh.create_mesh(communicator, mine, self._points, domain)
        self.space = dolfinx.fem.VectorFunctionSpace(self.mesh, ("Lagrange", 1))
        self.x = self.space.tabulate_dof_coordinates()
        self.n_owned = self.space.dofmap.index_map.size_local
        edges = self._points[cells[:, [[0, 1], [0, 2], [0, 4]]]]
        self.spacing = np.linalg.norm(edges[:, :, 0] - edges[:, :, 1], axis=2).min()

    def facets(self, label):
        import dolfinx
        return dolfinx.mesh.locate_entities_boundary(self.mesh, 2, lambda x: self._on(label, x.T))

    def nodes(self, label):
        return np.flatnonzero(self._on(label, self.x))

    def _on(self, label, x):
        here = set(map(place, self._points[np.unique(self._faces[label])]))
        return np.array([place(point) in here for point in x], dtype=bool)


def place(point):
    """A point up to what rounding makes of it [nm]."""
    return tuple(np.round(1e9 * point).astype(int))


def fibres(x):
    """f, s, n and nu at points x (k, 3): on the ellipsoid through each point, its angle linear through the wall."""
    r, low, high = np.hypot(x[:, 0], x[:, 1]), np.full(len(x), -0.9 * ACROSS / WALL), np.full(len(x), 2.0)
    for _ in range(60):
        t = (low + high) / 2
        outside = np.hypot(r / (ACROSS + t * WALL), x[:, 2] / (ALONG + t * WALL)) > 1
        low, high = np.where(outside, t, low), np.where(outside, high, t)
    a, c = (ACROSS + low * WALL)[:, None], (ALONG + low * WALL)[:, None]
    s = unit(np.hstack([x[:, :2] / a**2, x[:, 2:] / c**2]))
    up = np.array([0.0, 0.0, 1.0]) - s[:, 2:] * s
    angle = (ENDO * (1 - low) + EPI * low)[:, None]
    f = np.cos(angle) * np.cross(unit(up), s) + np.sin(angle) * unit(up)
    share = np.where(s[:, 2] < 0, np.minimum(1, (up**2).sum(1) / np.sin(DISPERSION)**2), 1)
    return f, s, np.cross(f, s), (1 - share * (2 - share)) / 2


def unit(a):
    return a / np.linalg.norm(a, axis=1, keepdims=True)
