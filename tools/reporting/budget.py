"""The error budget of a run's scene, where `heartbus study budget` has made one: tools/study/budget.py."""
import csv
from pathlib import Path

from results import provenance, resolved_scene

NOT_MEANT = ("scene", "output.", "participants.", "time.end", "time.beats", "coupling.deadline")  # say nothing about errors
MEASURES = {"EF": "points", "p_max": "mmHg", "V": "%", "p": "%", "activation": "ms"}


def find(run):
    """The newest budget.csv, of a scene with the file name of the run's, beside its results or in this folder."""
    words = provenance(run.folder).get("command", [])
    stems = {Path(word).stem for word in words[1:2]} | {str(run.scene.get("scene", ""))}
    folders = {run.folder.resolve().parent / "studies", Path("results/studies").resolve()}
    found = [file for folder in folders for stem in stems if (file := folder / f"budget_{stem}/budget.csv").exists()]
    return max(found, key=lambda file: file.stat().st_mtime, default=None)


def differences(run, file):
    """Keys in which the scene of the budget differs from that of the run, with its value; None when it is not known."""
    scene = resolved_scene(file.parent / "runs/scene")
    if not scene:
        return None
    return {key: value for key, value in scene.items()
            if not key.startswith(NOT_MEANT) and key in run.scene and run.scene[key] != value}


def table(file):
    """Heading and rows: what was made finer or coarser, the estimated error of each measure, the cost."""
    with open(file, newline="") as opened:
        rows = [row for row in csv.DictReader(opened) if row["state"] == "done"]
    measures = [name for name in MEASURES if any(row.get(f"error_{name}") for row in rows)]
    def shown(row, name):
        text = row.get(f"error_{name}", "")
        return f"{float(text):.2g}" if text else ""
    return (["discretisation", "changed", *(f"error of {name}, {MEASURES[name]}" for name in measures), "cost"],
            [[row["part"], row["change"], *(shown(row, name) for name in measures),
              f"x {float(row['cost_ratio']):.2f}"] for row in rows])
