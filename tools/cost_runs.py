"""Runs a window of a scene and gathers what its steps cost; see tools/cost."""
import json
import os
import shlex
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from results import History

ENVIRONMENT = dict(os.environ, OMPI_MCA_mpi_yield_when_idle="1", OMPI_MCA_rmaps_base_oversubscribe="1",
                   OMPI_MCA_hwloc_base_binding_policy="none", OMP_NUM_THREADS="1",
                   OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
# The mesh of the potential becomes no finer than it has to be.
REFINEMENTS = {"M1": 1, "M2": 0, "M3": 0}
PHASES = {"contraction": "isovolumetric contraction", "relaxation": "isovolumetric relaxation"}
FLUID_AND_SOLID = ("mech", "ale", "fluid", "fsi")


class Case:
    """One combination of what is varied, and what its runs have cost."""

    def __init__(self, scene, mesh, scheme, ranks, window, programs, variant, options):
        self.scene, self.mesh, self.scheme, self.ranks, self.window = Path(scene).resolve(), mesh, scheme, ranks, window
        self.programs, self.variant, self.options, self.runs = Path(programs).resolve(), variant, options, []

    def name(self):
        parts = [self.scene.stem, self.mesh, self.scheme, f"{self.ranks} rank{'s' * (self.ranks > 1)}", self.window,
                 self.variant, str(self.programs) if len(self.options.bin) > 1 else ""]
        return ", ".join(part for part in parts if part)

    def settings(self):
        settings = [f"time.step={self.options.dt} ms", "output.every=0 ms"]
        if self.mesh:
            settings += [f"mesh={self.mesh}", f"refinements={REFINEMENTS.get(self.mesh, 2)}"]
        if self.scheme and self.scheme != "E1FSinf":
            iterations = self.scheme.removeprefix("E1FS")
            settings.append("coupling.scheme=" + ("E1FS" if iterations.isdigit() else self.scheme))
            settings += [f"coupling.iterations={iterations}"] * iterations.isdigit()
        return settings + self.options.set + [setting for setting in self.variant.split(";") if setting]

    def scene_file(self, folder):
        """The scene itself, or one that has `fsi` in place of `mech` and `fluid`."""
        if self.scheme != "E1FSinf":
            return self.scene
        file = Path(folder) / "scene.yaml"
        file.write_text(f"base: {self.scene}\ncoupling: {{scheme: E1FSinf}}\n"
                        "participants: {mech: , fluid: , fsi: {program: fsi_solver}}\n")
        return file

    def launch(self, folder):
        words = [self.programs / "coupler", self.scene_file(folder), "--ranks", self.ranks, "--out", f"{folder}/out"]
        begin = 0.0
        if self.window != "start":
            begin, checkpoint = find_checkpoint(Path(self.options.results.format(mesh=self.mesh)), self.window)
            words += ["--restart", checkpoint]
        for setting in [*self.settings(), f"time.end={begin + self.options.steps * self.options.dt:.10g} ms"]:
            words += ["--set", setting]
        line = subprocess.run([*map(str, words), "--launch-line"], stdout=subprocess.PIPE, text=True)
        if line.returncode != 0:
            sys.exit(line.returncode)
        programs = shlex.split(line.stdout)
        return ["nice", "-n", str(self.options.nice), "mpirun", "--quiet",
                *(on_own_core(programs, "ep") if self.options.own_core else programs)]

    def run(self):
        with tempfile.TemporaryDirectory() as folder:
            launch = self.launch(folder)
            if subprocess.run(launch, env=ENVIRONMENT, stdout=subprocess.DEVNULL).returncode != 0:
                sys.exit(f"{self.name()}: the run failed: {shlex.join(launch)}")
            self.runs.append(costs(Path(folder) / "out", self.ranks))


def on_own_core(programs, name):
    """The arguments of mpirun, with this participant on the second core and all others on the first."""
    contexts = [[]]
    for word in programs:
        contexts[-1].append(word)
        if word == ":":
            contexts.append([])
    for context in contexts: # -n RANKS PROGRAM ... --name NAME
        context[2:2] = ["taskset", "-c", "1" if name in context[3:] else "0"]
    return [word for context in contexts for word in context]


def find_checkpoint(results, window):
    """The first one within a phase: its time [ms] and its folder."""
    wanted = PHASES.get(window, window)
    for manifest in sorted(results.glob("checkpoints/*/manifest.json")):
        time = json.loads(manifest.read_text())["time"]
        for name, begin, end in History(results).phases():
            if name == wanted and begin <= time < end:
                return 1e3 * time, manifest.parent
    sys.exit(f"there is no checkpoint of '{wanted}' in {results}")


def costs(results, ranks):
    """Means over the steps of one run."""
    indicators = json.loads((results / "indicators.json").read_text())
    history, n = History(results), indicators["steps_timed"]
    step_ms = 1e3 * indicators["wall_s"] / n
    points = indicators["points"]
    unknowns = sum(4 * p.get("cavity", 0) for name, p in points.items() if name in ("fluid", "fsi"))
    unknowns += sum(3 * p.get("tissue", 0) for name, p in points.items() if name in ("mech", "fsi"))
    result = {"step_ms": step_ms, "unknowns": unknowns, "memory_MiB": indicators["peak_memory_MiB"], "parts": {}, "points": points,
              "iterations": {name: float(history[name][-n:].mean()) for name in history.columns if "iterations" in name}}
    for name, works in indicators["wall_s_by_work"].items():
        result["parts"][name] = {
            "ms": {work: 1e3 * seconds / n for work, seconds in works.items()},
            "busy_ms": 1e3 * indicators["wall_s_by_part"][name] / n,
            "cpu_ms": 1e3 * indicators["cpu_s_by_part"][name] / n / ranks,
            "memory_MiB": indicators["peak_memory_MiB_by_part"][name]}
    if unknowns:
        result["us_per_unknown"] = 1e3 * step_ms / unknowns
        result["fsi_us_per_unknown"] = 1e3 / unknowns * sum(
            part["busy_ms"] for name, part in result["parts"].items() if name in FLUID_AND_SOLID)
    result["cpu_ms"] = sum(part["cpu_ms"] for part in result["parts"].values())
    return result


def medians(values):
    """Of dictionaries of the same shape, number by number."""
    if isinstance(values[0], dict):
        return {key: medians([value.get(key, 0) for value in values]) for key in values[0]}
    return statistics.median(values)
