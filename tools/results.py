"""Reads what a run leaves in its results folder; shared by the tools."""
import csv
import json
import re
from pathlib import Path

import numpy as np
import yaml

MMHG = 133.322387415  # Pa
ML = 1e-6  # m^3

# Indicators of a beat that are shown: name, label, digits, unit.
SHOWN = (("EF_percent", "ejection fraction", 1, "%"), ("EDV_mL", "volume, end of diastole", 1, "mL"),
         ("ESV_mL", "volume, end of systole", 1, "mL"), ("V_max_mL", "largest volume", 2, "mL"),
         ("V_min_mL", "smallest volume", 2, "mL"), ("p_max_mmHg", "largest mean pressure", 1, "mmHg"),
         ("ILI_C_percent", "volume lost in isovolumetric contraction", 2, "%"),
         ("ILI_R_percent", "volume lost in isovolumetric relaxation", 2, "%"),
         ("activation_time_ms", "last point of the wall activated", 1, "ms"),
         ("activated_percent", "wall activated", 1, "%"), ("aortic_opens_ms", "aortic valve opens", 1, "ms"),
         ("aortic_closes_ms", "aortic valve closes", 1, "ms"), ("mitral_opens_ms", "mitral valve opens", 1, "ms"),
         ("J_min", "smallest J of the wall", 3, ""), ("wall_volume_min_percent", "smallest volume of the wall", 1, "%"),
         ("clamped_share_max_percent", "most sarcomeres out of the model's range", 1, "%"))


LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # ten times as fast


class History:
    """history.csv: columns by name without their unit, in SI units."""

    def __init__(self, folder):
        with open(Path(folder) / "history.csv", newline="") as file:
            header, *rows = list(csv.reader(file))
        self.numbers = {}
        self.columns = {name.split(" [")[0]: [row[i] for row in rows] for i, name in enumerate(header)}
        self.time = self["time"]

    def __contains__(self, name):
        return name in self.columns

    def __getitem__(self, name):
        if name not in self.numbers:
            self.numbers[name] = np.array([float(value) for value in self.columns[name]])
        return self.numbers[name]

    def phases(self):
        """(name, begin, end) of each stretch of time in one phase."""
        stretches = []
        for i, name in enumerate(self.columns.get("phase", [])):
            before = self.time[max(i - 1, 0)]
            if not stretches or stretches[-1][0] != name:
                stretches.append([name, before, self.time[i]])
            stretches[-1][2] = self.time[i]
        return stretches


class Run:
    """All that is known of a finished run but its fields."""

    def __init__(self, folder, name=""):
        self.folder = Path(folder)
        self.name = name or self.folder.resolve().name
        self.history = History(folder)
        self.indicators = indicators(folder)
        self.scene = resolved_scene(folder)
        self.milliseconds = 1e3 * self.history.time

    def beats(self):
        """(its indicators, its rows of the history) of each beat; of a run without them, all rows."""
        time = self.history.time
        for beat in self.indicators.get("beats") or [{"start": time[0], "end": time[-1]}]:
            yield beat, (time >= beat["start"] - 1e-9) & (time <= beat["end"] + 1e-9)

    @property
    def scheme(self):
        return scheme(self.scene)

    def warnings(self):
        """(program, line) of all warnings and errors in the logs."""
        found = []
        for file in sorted((self.folder / "logs").glob("*.log")):
            for line in file.read_text(errors="replace").splitlines():
                if match := re.match(r"[\d-]+ [\d:.]+ (warning|error|critical)\s+(.*)", line):
                    found.append((file.stem, match[2]))
        return found


def load(folders):
    """Runs whose names tell them apart."""
    names = [Path(folder).resolve().name for folder in folders]
    parents = [Path(folder).resolve().parent.name for folder in folders]
    return [Run(folder, f"{parent}/{name}" if names.count(name) > 1 else name)
            for folder, name, parent in zip(folders, names, parents)]


def indicators(folder):
    path = Path(folder) / "indicators.json"
    return json.loads(path.read_text()) if path.exists() else {}


def provenance(folder):
    """With which command, where and by which versions; of runs that do not tell nothing."""
    path = Path(folder) / "provenance.json"
    return json.loads(path.read_text()) if path.exists() else {}


def origin(folders):
    """Of what a picture is, which it carries with it: scene, scheme, mesh and version of each run."""
    return "; ".join(origin_of(Path(folder)) for folder in folders)


def origin_of(folder):
    scene, said = resolved_scene(folder), provenance(folder)
    parts = [scene.get("scene", folder.resolve().name), scheme(scene)]
    parts += [f"mesh {scene['geometry.mesh']}"] if "geometry.mesh" in scene else []
    parts += [f"heartbus {said['heartbus']}"] if "heartbus" in said else []
    return ", ".join(filter(None, parts))


def scheme(scene):
    """As docs/schemes.md names it: E1FS2 for two iterations."""
    name, n = scene.get("coupling.scheme", ""), scene.get("coupling.iterations", 1)
    return f"{name}{n}" if name == "E1FS" else name


def flat(tree, prefix=""):
    """{"time.step": "0.2 ms", ...}"""
    result = {}
    for key, value in tree.items():
        result.update(flat(value, prefix + key + ".") if isinstance(value, dict) else {prefix + key: value})
    return result


def resolved_scene(folder):
    """Every key of the scene with its value, flat."""
    path = Path(folder) / "scene.resolved.yaml"
    return flat(yaml.load(path.read_text(), LOADER)) if path.exists() else {}


def quantity(text):
    """The number of '5000 kg/(m^2 s)', as scene.resolved.yaml has it in SI units; None of a word."""
    try:
        return float(str(text).split(" ")[0])
    except ValueError:
        return None
