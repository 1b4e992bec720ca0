"""Who can stand for whom: electrophysiologies, bloods and walls, each as words of a scene, and how a combination is run."""
import csv
import json
import os
import subprocess
import sys
from pathlib import Path

BIN, SOURCE = Path(os.environ["HEARTBUS_BIN"]), Path(os.environ["HEARTBUS_SOURCE"])
DOLFINX = SOURCE / "examples/dolfinx"
ALL_AT_ONCE = {"sites": [{"centre": ["0 mm", "0 mm", "-20 mm"], "radius": "200 mm"}]}


def python(file):
    return {"command": f"{sys.executable} {file}", "program": None, "ranks": 1}


ELECTROPHYSIOLOGIES = {
    "ttp06": {},
    "bueno_orovio": {"electrophysiology": {"ionic_model": "bueno_orovio_epi"}},
    "eikonal": {"electrophysiology": {"model": "eikonal"}},
    "prescribed": {"base": "prescribed.yaml"},
    "replay": {"participants": {"ep": {"program": "replay", "ranks": 1, "settings": {"file": "calcium.h5"}}}},
}
BLOODS = {
    "3D": {"base": "efs1.yaml", "participants": {}},
    "3D, DOLFINx lifting": {"base": "efs1.yaml", "participants": {"ale": python(DOLFINX / "lifting.py")}},
    "0D": {"base": "circulation.yaml", "participants": {}},
    "0D in Python": {"base": "circulation.yaml",
                     "participants": {"circulation": python(SOURCE / "examples/circulation/circulation.py")}},
}
WALLS = {"ours": {}, "DOLFINx": {"mech": python(DOLFINX / "mechanics.py")}}
# Codes for the same physics give the same pressure, up to this share of its range. DOLFINx answers to pressure with the
# tangent of now, ours with one that may be older: a difference of second order in the pressure of a step.
SAME = {("3D", "ours"): 1e-6, ("3D", "DOLFINx"): 1e-6, ("0D", "ours"): 1e-6, ("0D", "DOLFINx"): 1e-3}


def merged(one, two):
    """Blocks joined, the second wins."""
    both = dict(one)
    for key, value in two.items():
        both[key] = merged(both[key], value) if isinstance(value, dict) and isinstance(both.get(key), dict) else value
    return both


def scene(electrophysiology, blood, wall, name):
    spatial = blood.startswith("3D")
    own = ELECTROPHYSIOLOGIES[electrophysiology]
    blocks = {
        "base": str(SOURCE / "configs/ideal_lv" / BLOODS[blood]["base"]), "scene": name,
        "geometry": {"mesh": "MXS"}, "fibres": {"rule": "ellipsoid"},
        "time": {"end": "20 ms", "step": "0.4 ms" if spatial else "1 ms"},
        "participants": merged(BLOODS[blood]["participants"], WALLS[wall]),
        "mechanics": {"solver": {"residual_tolerance": 1e-10, "update_tolerance": 1e-9}},
        "electrophysiology": {"refinements": 0, "stimulus": ALL_AT_ONCE},
        "lifting": {"tolerance": 1e-12}, "fluid": {"tolerance": 1e-11},
        "output": {"every": "0 ms", "checkpoint": {"every": "0 ms"}},
    }
    if electrophysiology == "prescribed":
        import yaml
        table = yaml.safe_load((SOURCE / "configs/ideal_lv/prescribed.yaml").read_text(encoding="utf-8"))["electrophysiology"]
        own = {"electrophysiology": table}
    return merged(blocks, own)


class Combination:
    """A finished run: whether it came to its end, pressures and volumes of its steps [Pa, m^3], CPU seconds of all programs."""

    def __init__(self, folder, electrophysiology, blood, wall, *words):
        self.parts = (electrophysiology, blood, wall)
        name = "_".join(part.replace(" ", "_").replace(",", "") for part in self.parts)
        file = Path(folder) / f"{name}.yaml"
        file.write_text(json.dumps(scene(*self.parts, name)), encoding="utf-8")  # which is YAML
        command = [sys.executable, SOURCE / "tools/check.py", "--launch", file, "--oversubscribe", "--ranks", "1", "--out",
                   name, "--force", *words]
        environment = dict(os.environ, PYTHONPATH=str(BIN.parent / "share/heartbus/python"))
        run = subprocess.run([str(word) for word in command], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        self.code, self.output, self.seconds = run.returncode, run.stdout, 0
        self.pressure = self.volume = []
        if self.code == 0:
            with open(Path(folder) / name / "history.csv", encoding="utf-8") as history:
                columns = {title.split(" ")[0]: values for title, *values in zip(*csv.reader(history))}
            self.seconds = json.loads((Path(folder) / name / "indicators.json").read_text(encoding="utf-8"))["cpu_s"]
            self.pressure, self.volume = ([float(value) for value in columns[title]] for title in ("mean_pressure", "volume"))

    def differs(self, other):
        """The largest difference of pressures over their range."""
        extent = max(self.pressure) - min(self.pressure)
        if len(self.pressure) != len(other.pressure) or extent <= 0:
            return float("inf")
        return max(abs(a - b) for a, b in zip(self.pressure, other.pressure)) / extent


def prepare(folder):
    """What some combinations need: the meshes for DOLFINx, the calcium to be replayed, whose run this returns."""
    computed = Combination(folder, "ttp06", "0D", "ours", "--record", "calcium=calcium.h5")
    subprocess.run([BIN / "coupler", SOURCE / "configs/ideal_lv/efs1.yaml", "--set", "mesh=MXS", "--write-mesh",
                    Path(folder) / "ventricle.h5"], check=True)
    return computed


def limit(one, two):
    """How much two combinations with the same electrophysiology may differ; None when their physics differ. What is replayed
    has been computed with blood of one pressure, and steps of the same size."""
    kinds = {blood.split(",")[0].split(" ")[0] for _, blood, _ in (one.parts, two.parts)}
    if len(kinds) > 1:
        return None
    kind = kinds.pop()
    if len({"ttp06" if part == "replay" and kind == "0D" else part for part, _, _ in (one.parts, two.parts)}) > 1:
        return None
    return max(SAME[kind, one.parts[2]], SAME[kind, two.parts[2]])
