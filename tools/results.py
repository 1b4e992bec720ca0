"""Reads what a run leaves in its results folder; shared by the tools."""
import csv
import json
from pathlib import Path

import numpy as np

MMHG = 133.322387415  # Pa
ML = 1e-6  # m^3

# One colour for each phase of the heartbeat, in every picture.
PHASES = {
    "isovolumetric contraction": ("IC", "#f2b8a0"),
    "ejection": ("ejection", "#f7dfa5"),
    "isovolumetric relaxation": ("IR", "#a9cbe8"),
    "filling": ("filling", "#cfe6cf"),
    "diastasis": ("diastasis", "#e6e6e6"),
}


class History:
    """history.csv: columns by name without their unit, in SI units."""

    def __init__(self, folder):
        with open(Path(folder) / "history.csv", newline="") as file:
            header, *rows = list(csv.reader(file))
        self.columns = {name.split(" [")[0]: [row[i] for row in rows] for i, name in enumerate(header)}
        self.time = self["time"]

    def __contains__(self, name):
        return name in self.columns

    def __getitem__(self, name):
        return np.array([float(value) for value in self.columns[name]])

    def phases(self):
        """(name, begin, end) of each stretch of time in one phase."""
        stretches = []
        for i, name in enumerate(self.columns.get("phase", [])):
            before = self.time[max(i - 1, 0)]
            if not stretches or stretches[-1][0] != name:
                stretches.append([name, before, self.time[i]])
            stretches[-1][2] = self.time[i]
        return stretches


def indicators(folder):
    path = Path(folder) / "indicators.json"
    return json.loads(path.read_text()) if path.exists() else {}
