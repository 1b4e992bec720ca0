"""Benchmarks: what is run, and what comes out beside what is expected."""
import os
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from results import History
from verification import exact

ROOT = Path(__file__).resolve().parents[2]


class Unknown(Exception):
    """A benchmark that there is not."""


@dataclass
class Row:
    benchmark: str
    source: str
    name: str
    expected: tuple    # the range: low, high
    tolerance: float   # beyond the range, relative to its middle, or absolute where that is zero
    values: dict       # by mesh, from coarse to fine
    seconds: dict      # by mesh, of the run

    def deviation(self, value):
        low, high = self.expected
        beyond = max(low - value, value - high, 0)
        middle = abs(low + high) / 2
        return beyond / middle if middle > 0 else beyond

    @property
    def is_within(self):
        return self.deviation(list(self.values.values())[-1]) <= self.tolerance


def number(text):
    """0.05 or '5 %'."""
    return float(text[:-1]) / 100 if isinstance(text, str) and text.endswith("%") else float(text)


def value_of(expression, columns):
    return float(eval(str(expression), {"np": np, "exact": exact, "abs": abs}, columns))  # of our own file


class Benchmark:
    def __init__(self, name, plan):
        self.name, self.plan = name, plan

    def run(self, out, quick):
        """Rows, after running the coarsest mesh or all of them."""
        meshes = dict(list(self.plan["meshes"].items())[:1]) if quick else self.plan["meshes"]
        histories, seconds = {}, {}
        for mesh, settings in meshes.items():
            begin = time.monotonic()
            histories[mesh] = self.history(out / self.name / mesh.replace(" ", "_"), settings)
            seconds[mesh] = time.monotonic() - begin
        return [self.row(plan, histories, seconds, quick) for plan in self.plan["rows"]]

    def history(self, folder, settings):
        """Columns by name, of a run with these settings."""
        words = [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]
        scene = ROOT / "configs/benchmarks" / self.plan["scene"]
        folder.mkdir(parents=True, exist_ok=True)
        with open(folder / "launch.log", "w") as log:
            code = subprocess.run([sys.executable, ROOT / "tools/launch.py", scene, *words, "--out", folder, "--force"], stdout=log,
                                  stderr=subprocess.STDOUT, check=False, env=environment()).returncode
        if code != 0:
            sys.exit(f"error: {self.name} ended with code {code}; see {folder / 'launch.log'}")
        history = History(folder)
        return {name: history[name] for name in history.columns if name != "phase"}

    def row(self, plan, histories, seconds, quick):
        expected = plan["expected"]
        low, high = expected if isinstance(expected, list) else (expected, expected)
        return Row(self.name, self.plan["source"], plan["name"], (value_of(low, {}), value_of(high, {})),
                   number(plan["quick" if quick else "tolerance"]),
                   {mesh: value_of(plan["value"], columns) for mesh, columns in histories.items()}, seconds)


def environment():
    usual = {"OMPI_MCA_mpi_yield_when_idle": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMP_NUM_THREADS": "1",
             "OMPI_MCA_hwloc_base_binding_policy": "none"}
    if os.getuid() == 0:
        usual.update({"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"})
    return {**usual, **os.environ}


def read(names):
    """The benchmarks of these names; of none, all."""
    plans = yaml.safe_load((Path(__file__).parent / "benchmarks.yaml").read_text())
    for name in names:
        if name not in plans:
            raise Unknown(f"there is no benchmark '{name}'; there are {', '.join(plans)}")
    return [Benchmark(name, plans[name]) for name in names or plans]
