#!/usr/bin/python3
"""Looks whether a program can take a part: launches it with partners that have no physics, on the smallest ventricle.

    heartbus-check COMMAND --role ep|mech|ale|fluid|fsi|circulation [--ranks N]

COMMAND is what the scene would have: "python3 my_ep.py --fast", or a program of heartbus. Prints a table of all that can be
looked at, "-" before what something else that is wrong hides; exit code 0 when all is well, 1 otherwise.
"""
import argparse
import csv
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import uuid
from pathlib import Path

import launch

ROLES = {  # role: (its partners, scheme, field that is compared, or its pressure in the history; who sends to it)
    "ep": (["mech"], "EFS1", "calcium", None),
    "mech": (["ep", "ale", "fluid"], "E1FS", "wall_velocity", "fluid"),
    "ale": (["mech", "fluid"], "EFS1", "mesh_motion", "mech"),
    "fluid": (["mech", "ale"], "E1FS", "blood_force", "mech"),
    "fsi": (["ep", "ale"], "E1FSinf", "displacement", "ep"),
    "circulation": (["mech"], "circulation", None, "mech"),
}
PRESSURE = "mean_pressure"
CHECKS = ["joins", "declares what the role needs", "units", "points conform", "runs", "ends when told",
          "waits asleep", "iterations start from the old state", "a restart gives the same bits",
          "what is not finite is refused", "obeys a deadline", "ends when a partner fails"]
DEADLINE = 10         # [s]
STEPS, SAVED = 25, 20  # a checkpoint is possible at every twentieth step
WRONG_STEP = 3        # of a partner
DELAY = 0.05          # [s] for which partners take their time in each solve
ALIKE = 1e-3          # of the field's range: solvers of others begin at their last guess
PATIENCE = 10         # [s] to end after the cause


class Wrong(Exception):
    """What is wrong."""


class Hidden(Exception):
    """It cannot be looked at, because of something else that is wrong."""


class Run:
    """A launch with stand-ins: exit code, output, seconds, and whoever is left."""

    def __init__(self, folder, scene, name, *words):
        file = folder / f"{name}.yaml"
        file.write_text(json.dumps(scene))  # which is YAML
        mark = "HEARTBUS_CHECK=" + uuid.uuid4().hex
        begin = time.monotonic()
        command = [sys.executable, __file__, "--launch", file, "--oversubscribe", "--force", "--out", folder / "results"]
        process = subprocess.run([*command, *words], env=dict(os.environ, **dict([mark.split("=")])),
                                 stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                 check=False)
        self.code, self.output, self.seconds = process.returncode, process.stdout, time.monotonic() - begin
        self.left = [p.parent.name for p in Path("/proc").glob("[0-9]*/environ") if has_mark(p, mark)]

    @property
    def launched(self):
        """Whether programs were started: what the coupler refuses before says error."""
        return not any(line.startswith("error: ") for line in self.output.splitlines())

    @property
    def cause(self):
        lines = [line for line in self.output.splitlines() if line.startswith(("heartbus: ", "error: "))]
        return lines[0].split(": ", 1)[1] if lines else self.output.strip().splitlines()[-1] if self.output.strip() else ""


def recorded(file, after=0):
    """(steps, values) of the transfers of a recording after a step."""
    import h5py  # takes its time, and is not needed by who fails before
    with h5py.File(file) as recording:
        late = recording["step"][:] > after
        return recording["step"][:][late], recording["values"][:][late]


def told(history, after):
    """(steps, pressures) of a history after a step."""
    import numpy
    with open(history, encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if int(row["step"]) > after]
    column = next(title for title in rows[0] if title.split(" ")[0] == PRESSURE)
    return [int(row["step"]) for row in rows], numpy.array([float(row[column]) for row in rows])


def has_mark(environ, mark):
    try:
        return mark.encode() in environ.read_bytes()
    except OSError:
        return False


class Check:
    def __init__(self, command, role, ranks, folder):
        self.command, self.role, self.ranks, self.folder = command, role, ranks, folder
        self.partners, self.scheme, self.field, self.sender = ROLES[role]

    def scene(self, mischief="none", who=None):
        participants = {name: None for name in ("ep", "mech", "ale", "fluid")}  # of the base
        for name in self.partners:
            wrong = name == who
            participants[name] = {"program": "stand_in", "ranks": 1, "settings": {
                "mischief": mischief if wrong else "none", "step": str(WRONG_STEP), "delay": str(DELAY)}}
        participants[self.role] = {"command": self.command, "ranks": self.ranks}
        return {"base": str(launch.ROOT / "configs/ideal_lv/efs1.yaml"), "scene": "check",
                "geometry": {"mesh": "MXS"}, "electrophysiology": {"refinements": "1"},
                "time": {"end": f"{STEPS} ms", "step": "1 ms"},
                "coupling": {"scheme": self.scheme, "iterations": "2" if self.scheme == "E1FS" else "1",
                             "deadline": f"{DEADLINE} s"},
                "participants": participants,
                "output": {"every": "0 ms", "checkpoint": {"every": f"{SAVED} ms"}}}

    def verdicts(self):
        """(check, "yes", "NO" or "-", what is wrong) of all, in the order of CHECKS."""
        self.whole = self.run_and_keep("whole")
        history = self.folder / "whole.csv"
        self.steps = len(history.read_text().splitlines()) - 2 if history.is_file() else 0
        looks = [self.idle, self.iterations, self.restart, self.refuses,
                 lambda: self.ends_with(7, "silence", DEADLINE), lambda: self.ends_with(5, "fail", 0)]
        yield from self.of_the_whole_run(CHECKS[:-len(looks)])
        for check, look in zip(CHECKS[-len(looks):], looks, strict=True):
            try:
                look()
                yield check, "yes", ""
            except Wrong as wrong:
                yield check, "NO", str(wrong)
            except Hidden:
                yield check, "-", ""

    def run_and_keep(self, name, *words):
        """A launch whose history and recording later ones do not replace."""
        record = ["--record", f"{self.field}={self.folder / name}.h5"] if self.field else []
        run = Run(self.folder, self.scene(), name, *record, *words)
        history = self.folder / "results/history.csv"
        if history.is_file():
            shutil.copy(history, self.folder / f"{name}.csv")
        return run

    def values(self, name, after=0):
        """(steps, values) that the program has sent in the run of this name."""
        return recorded(self.folder / f"{name}.h5", after) if self.field else told(self.folder / f"{name}.csv", after)

    def of_the_whole_run(self, checks):
        """Each is passed before the next one."""
        run = self.whole
        wrong = blamed(run) if run.code else "ends when told" if run.left else None
        reason = run.cause if run.code else "processes are left: " + " ".join(run.left)
        passed = checks.index(wrong) if wrong else len(checks)
        for k, check in enumerate(checks):
            yield check, "yes" if k < passed else "NO" if k == passed else "-", reason if k == passed else ""

    def needs_the_whole_run(self):
        if self.whole.code:
            raise Hidden

    def needs_steps(self):
        """Up to where a partner does something wrong."""
        if self.steps < WRONG_STEP:
            raise Hidden

    def idle(self):
        self.needs_the_whole_run()
        share = self.idle_share()
        if share > 0.3:
            raise Wrong(f"it uses {100 * share:.0f} % of a core while it waits")

    def idle_share(self):
        costs = json.loads((self.folder / "results/indicators.json").read_text())
        waiting = costs["wall_s_by_work"][self.role].get("waiting", 0)
        beyond = costs["cpu_s_by_part"][self.role] / self.ranks - costs["wall_s_by_part"][self.role]
        return beyond / waiting if waiting > 0 else 0

    def iterations(self):
        self.needs_the_whole_run()
        if self.scheme != "E1FS":
            return
        steps, values = self.values("whole")
        span = values.max() - values.min()
        for step in range(1, STEPS + 1):
            first, second = values[steps == step][-2:]
            difference = abs(first - second).max()
            if difference > ALIKE * span:
                raise Wrong(f"'{self.field}' differs by {difference / span:.2g} of its range between two solves of step {step} "
                            "that received the same")

    def restart(self):
        self.needs_the_whole_run()
        run = self.run_and_keep("again", "--restart", "latest")
        if run.code:
            raise Wrong(run.cause)
        steps, whole = self.values("whole", SAVED)
        for step, one, other in zip(steps, whole, self.values("again", SAVED)[1], strict=True):
            if (one != other).any():
                raise Wrong(f"'{self.field or PRESSURE}' of step {step} differs by {abs(one - other).max():.2g} after a restart "
                            f"from step {SAVED}")

    def refuses(self):
        self.needs_steps()
        if self.sender:
            run = Run(self.folder, self.scene("nan", self.sender), "nan")
            if run.code == 0:
                raise Wrong(f"it goes on with NaN from {self.sender}")
            if not run.cause.startswith(self.role):
                raise Wrong(f"it is somebody else who notices: {run.cause}")

    def ends_with(self, code, mischief, seconds):
        """All end in time when a partner behaves so."""
        self.needs_steps()
        run = Run(self.folder, self.scene(mischief, self.partners[0]), mischief)
        if run.code != code:
            raise Wrong(f"exit code {run.code} in place of {code}: {run.cause}")
        if run.left:
            raise Wrong("processes are left: " + " ".join(run.left))
        if run.seconds > seconds + 2 * PATIENCE:
            raise Wrong(f"the launch ends after {run.seconds:.0f} s only")


def blamed(run):
    """Which check a run that has failed belongs to."""
    text = run.output
    if not run.launched:
        return "joins"
    if run.code == 4:
        return "points conform"
    if any(words in text for words in ("without joining", "it was starting", "it was meeting", "all programs to meet",
                                       "is missing", "protocol")):
        return "joins"
    if run.code == 3 and "is sent by" in text:
        return "units"
    if run.code == 3 and ("needs" in text or "declares no" in text or "must be solved and committed" in text):
        return "declares what the role needs"
    if "participants to end" in text or "programs to end" in text:
        return "ends when told"
    return "runs"


def main():
    if sys.argv[1:2] == ["--launch"]:
        return launch.run(sys.argv[2:])[0]
    parser = argparse.ArgumentParser(prog="heartbus-check", description=__doc__.split("\n", 1)[0])
    parser.add_argument("command", help="of the program, with its words in quotes")
    parser.add_argument("--role", choices=ROLES, required=True)
    parser.add_argument("--ranks", type=int, default=1)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        words = []
        for check, word, reason in Check(options.command, options.role, options.ranks, Path(folder)).verdicts():
            words.append(word)
            print(f"{word:4}{check}{': ' + reason if reason else ''}", flush=True)
    return int(words.count("yes") < len(CHECKS))


if __name__ == "__main__":
    sys.exit(main())
