"""One run as a process: its scene written out, mpirun started as ./run does, how it ended."""
import json
import math
import os
import shlex
import subprocess
from pathlib import Path

import numpy as np
import yaml

from launching.programs import ROOT, programs  # noqa: F401  (ROOT is for others of this folder)
from results import History

from .scene import StudyError, lay_over

BIN = programs()
SCENE, CONVERGENCE, NOT_FINITE = 2, 5, 6  # exit codes that say something about the run itself
LASTING = (SCENE, 3, 4, CONVERGENCE, NOT_FINITE)

# Waiting ranks sleep and may share cores.
ENVIRONMENT = {"OMPI_MCA_mpi_yield_when_idle": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1",
               "OMPI_MCA_hwloc_base_binding_policy": "none", "OMP_NUM_THREADS": "1"}
if os.geteuid() == 0:
    ENVIRONMENT.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")


def coupler(*arguments):
    """What the coupler prints; its complaint as an error."""
    program = BIN / "coupler"
    if not program.exists():
        raise StudyError(f"{program} is not built: ./run builds it")
    result = subprocess.run([str(word) for word in (program, *arguments)], stdin=subprocess.DEVNULL, text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    if result.returncode != 0:
        raise StudyError(result.stderr.strip().removeprefix("error: "))
    return result.stdout


def defaults():
    """All keys of a scene with their defaults."""
    return yaml.safe_load(coupler("--print-defaults"))


def checkpoint(folder, when, apart):
    """(folder, time) of a checkpoint: the one nearest to a time, not farther than `apart`; the last one; or the last one
    before what ("before", phase, time from its beginning, grid) names."""
    sets = sorted((json.loads(manifest.read_text())["time"], manifest.parent)
                  for manifest in Path(folder).glob("checkpoints/*/manifest.json"))
    if isinstance(when, float):
        sets = sorted((found for found in sets if abs(found[0] - when) <= apart), key=lambda found: abs(found[0] - when))
    else:
        limit = np.inf if when == "last" else beginning(folder, *when[1:])
        sets = [found for found in reversed(sets) if found[0] < limit - 1e-9]
    if not sets:
        raise StudyError(f"no checkpoint of {when} in {folder}: does that run come to it, with output.checkpoint.every and "
                         "keep?")
    return sets[0][1], sets[0][0]


def beginning(folder, phase, after, grid=0):
    """The instant [s] so long after a phase of the heartbeat has begun, which it has when its first step begins; the next
    multiple of `grid` [s], if that is given."""
    begun = [begin for name, begin, _ in History(folder).phases() if name == phase]
    if not begun:
        raise StudyError(f"there is no {phase} in {folder}: does that run come to it?")
    when = begun[0] + after
    return grid * math.ceil(when / grid - 1e-6) if grid else when


class Launch:
    """A case being computed in the store."""

    def __init__(self, case, store):
        self.case, self.folder, self.start = case, store.begin(case), None  # time of the checkpoint [s]
        arguments, tree = self.scene(case, store)
        (self.folder / "scene.yaml").write_text(yaml.safe_dump(tree, sort_keys=False))
        line = coupler(self.folder / "scene.yaml", "--launch-line", "--out", self.folder, *arguments)
        # mpirun ends when this program does, however it ends
        command = ["setpriv", "--pdeathsig", "TERM", "mpirun", "--quiet", *shlex.split(line)]
        with open(self.folder / "console.log", "w") as console:
            self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=console,
                                            stderr=subprocess.STDOUT, cwd=self.folder, start_new_session=True,
                                            env={**ENVIRONMENT, **os.environ})

    def scene(self, case, store):
        """Arguments of the coupler and the scene, with paths and times that are known now only."""
        arguments, tree = [], case.tree
        if case.calcium:
            played = {"program": "replay", "ranks": 1, "settings": {"file": str(store.of(case.calcium) / "calcium.h5")}}
            tree = lay_over(tree, {"participants": {"ep": played}})
        if case.start:
            found, self.start = checkpoint(store.of(case.start.case), case.start.when, 20 * case.start.case.step)
            arguments += ["--restart", found]
        if case.steps:
            tree = lay_over(tree, {"time": {"end": f"{(self.start or 0) + case.steps * case.step:.9g} s"}})
        if case.until:
            tree = lay_over(tree, {"time": {"end": f"{beginning(store.of(case.start.case), *case.until):.9g} s"}})
        if case.records:
            arguments += ["--record", f"{case.records}={self.folder / (case.records + '.h5')}"]
        return arguments, tree

    def steps_done(self):
        try:
            with open(self.folder / "history.csv", "rb") as file:
                return sum(1 for _ in file)
        except OSError:
            return 0

    def stop(self):
        if self.process.poll() is None:
            self.process.terminate()
        self.process.wait()

    def outcome(self):
        """None while it runs, then (exit code, reason)."""
        code = self.process.poll()
        if code is None:
            return None
        text = (self.folder / "console.log").read_text(errors="replace").strip().splitlines()
        reasons = [line for line in text if line.startswith("heartbus:")] or text[-1:] or ["no output"]
        if code == 0 and not (self.folder / "indicators.json").exists():
            return 1, "ended without indicators.json"
        return code, "" if code == 0 else reasons[0].removeprefix("heartbus: ")
