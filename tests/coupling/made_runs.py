"""Results of runs that nobody has computed, for tests of what is made of them."""
import json
import tempfile
import unittest
from pathlib import Path

import numpy as np
import yaml

PHASES = ((0.09, "isovolumetric contraction"), (0.3, "ejection"), (0.4, "isovolumetric relaxation"), (0.8, "filling"))


def healthy():
    """Columns and indicators of a beat without fault, in steps of 10 ms."""
    time = np.linspace(0, 0.8, 81)
    phase = [next(name for end, name in PHASES if t <= end + 1e-9) for t in time]
    volume = np.interp(time, [0, 0.09, 0.3, 0.4, 0.8], [120e-6, 119e-6, 60e-6, 61e-6, 119e-6])
    pressure = np.interp(time, [0, 0.09, 0.2, 0.3, 0.4, 0.8], [1333, 9000, 16000, 9000, 1300, 1333])
    columns = {"step": range(81), "time [s]": time, "lifting_iterations": [1] * 81, "mesh_min_J": [0.6] * 81,
               "activated_share": np.clip(time / 0.11, 0, 1), "volume [m^3]": volume, "mean_pressure [Pa]": pressure,
               "mitral_flow [m^3/s]": np.where(time > 0.4, 3e-4, 0), "aortic_flow [m^3/s]": np.where(abs(time - 0.2) < 0.1, 3e-4, 0),
               "phase": phase, "volume_defect [m^3/s]": np.full(81, 1e-6), "disagreement [Pa]": np.full(81, 10.0),
               "alpha [kg/(m^2 s)]": [5000] * 81, "coupling_iterations": [1] * 81, "alpha_limit [kg/(m^2 s)]": [14000] * 81,
               "min_J": np.full(81, 0.9), "peak_tension [Pa]": np.full(81, 1e4), "wall_volume": np.full(81, 0.99),
               "clamped_share": np.zeros(81)}
    beat = {"beat": 1, "start": 0.0, "end": 0.8, "complete": True, "EDV_mL": 120.0, "ESV_mL": 60.0, "EF_percent": 50.0,
            "ILI_C_percent": 1.0, "ILI_R_percent": 1.5, "p_max_mmHg": 120.0, "activation_time_ms": 110.0,
            "aortic_opens_ms": 90.0, "aortic_closes_ms": 300.0, "mitral_opens_ms": 400.0}
    return {name: list(values) for name, values in columns.items()}, [beat]


def write(folder, columns, beats, scene=None):
    folder.mkdir(parents=True, exist_ok=True)
    rows = zip(*columns.values())
    (folder / "history.csv").write_text(",".join(columns) + "\n" + "".join(",".join(map(str, row)) + "\n" for row in rows))
    works = {"mech": {"assembly": 3.0, "waiting": 4.0}, "fluid": {"linear solve": 2.0, "waiting": 5.0}}
    (folder / "indicators.json").write_text(json.dumps({
        **beats[-1], "beats": beats, "wall_s_by_part": {"mech": 3.0, "fluid": 2.0}, "wall_s_by_work": works, "steps_timed": 80,
        "wall_s": 8.0, "cpu_s": 12.0}))
    (folder / "scene.resolved.yaml").write_text(yaml.safe_dump(scene or {
        "scene": "made", "geometry": {"shape": "ideal_left_ventricle", "mesh": "M0"}, "coupling": {"scheme": "EFS1", "iterations": 1},
        "mechanics": {"law": "guccione", "guccione": {"kappa": "50000 Pa"}, "active": {"sarcomere_length": "1.75 um"}}}))
    return folder


class Temporary(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
