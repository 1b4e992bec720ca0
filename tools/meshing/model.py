"""What the parts of this package hand to each other."""
from dataclasses import dataclass, field

import numpy as np

UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6}
VERTICES = {"tetrahedra": 4, "hexahedra": 8}
OTHERS = ("wedges", "pyramids")  # kinds of cells that nobody here computes with


class Refusal(Exception):
    """What is wrong, where, how to mend it."""


@dataclass
class Surface:
    """A named part of a boundary: faces (k, 3 or 4), around the face, as indices of points."""
    name: str
    faces: np.ndarray


@dataclass
class Foreign:
    """A mesh as another program wrote it, in its own unit."""
    source: str
    points: np.ndarray                            # (n, 3)
    cells: dict                                   # kind: (m, vertices), around the faces as VTK has it
    regions: dict                                 # kind: (m,) indices into region_names
    region_names: list
    surfaces: list = field(default_factory=list)
    point_fields: dict = field(default_factory=dict)  # name: (n, c)
    cell_fields: dict = field(default_factory=dict)   # name: (m, c), of the one kind of cells
    unit: str = ""                                # where the format says it
    notes: list = field(default_factory=list)


@dataclass
class Part:
    """A mesh that the solvers can compute with: one kind of cells, positive, all of the boundary labelled, in metres."""
    points: np.ndarray       # (n, 3) float [m]
    kind: str
    cells: np.ndarray        # (m, 4 or 8); hexahedra in lexicographic order, x fastest
    regions: np.ndarray      # (m,)
    region_names: list
    faces: np.ndarray        # (k, 3 or 4); quadrilaterals in lexicographic order
    face_labels: np.ndarray  # (k,)
    label_names: list
    fibres: np.ndarray = None  # (m, 2, 3) unit vectors along fibre and sheet

    def faces_of(self, label):
        if label not in self.label_names:
            return self.faces[:0]
        return self.faces[self.face_labels == self.label_names.index(label)]

    def nodes_of(self, label):
        return np.unique(self.faces_of(label))


def place(x, unit="mm"):
    """Coordinates [m], for people."""
    return "(" + ", ".join(f"{value / UNITS[unit]:.4g}" for value in x) + f") {unit}"


def count(n, one, many):
    return f"{n:,} {one if n == 1 else many}"
