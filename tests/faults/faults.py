"""The rows of the matrix: how each fault is brought about, and how it must end. All from outside: signals, settings, files."""
import resource
import shutil
import signal
from dataclasses import dataclass, field
from typing import Callable

import h5py
import numpy as np
import sets
from casts import SETS

NOT_CONVERGED, NOT_FINITE, DEADLINE, FILE, HANDSHAKE, MAP = 5, 6, 7, 8, 3, 4
PARTICIPANTS = ("coupler", "ep", "mech", "ale", "fluid", "fsi", "replay")
PUSH = ["push.pressure.times=[0 ms]", "push.pressure.values=[100 kPa]"]


@dataclass
class Fault:
    name: str
    run: Callable                             # of a Trial; gives its Outcome
    absent: dict = field(default_factory=dict)  # by participant: why there is no such fault


def signalled(name, number, code, rank=0):
    def run(trial):
        return trial.judge(name, trial.signalled(number, rank), [code])
    return run


def not_a_number(trial):
    """In its state, where checksums let it pass; in what is replayed."""
    return filled(trial, "NaN in a field", float("nan"), [NOT_FINITE])


def overflow(trial):
    """Finite where it is read; NaN or infinite in the first step."""
    return filled(trial, "overflow in a field", 1e300, [NOT_FINITE, NOT_CONVERGED])


def filled(trial, name, value, codes):
    if trial.participant == "replay":
        return with_recording(trial, name, lambda path: sets.fill(path, value), [FILE])
    sets.fill(trial.state(), value)
    sets.seal(trial.sets / SETS[-1])
    return trial.judge(name, trial.launch(end=20), codes, restart="4 ms")


def no_convergence(trial):
    settings = {"coupler": ["alpha=1e9 kg/(m^2 s)"]}.get(trial.participant, ["mechanics.solver.max_iterations=1", *PUSH])
    culprits = ["coupling is unstable"] if trial.participant == "coupler" else []
    return trial.judge("no convergence", trial.launch(settings=settings, end=20), [NOT_CONVERGED], culprits)


def inverted(trial):
    """The wall moves through the blood's mesh, whose blood hardly resists; the wall's own mesh is so in its state."""
    if trial.participant == "ale":
        settings = ["push.pressure.times=[0 ms]", "push.pressure.values=[20 kPa]", "alpha=1 kg/(m^2 s)"]
        return trial.judge("inverted mesh", trial.launch(settings=settings, end=100), [NOT_FINITE])
    sets.turn_over(trial.state())
    sets.seal(trial.sets / SETS[-1])
    return trial.judge("inverted mesh", trial.launch(end=20), [NOT_FINITE], restart="4 ms")


def no_room(name, *settings):
    """From now on no file of this participant may grow: the same as a full disk for all its writers, for nobody else."""
    def limit(pids):
        for pid in pids:
            resource.prlimit(pid, resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))

    def run(trial):
        launch = trial.meanwhile(limit, settings=settings)
        return trial.judge(name, launch, [FILE])
    return run


def damaged(name, damage):
    """A state whose file no longer has the checksum in its manifest; of a replay, its recording."""
    def run(trial):
        if trial.participant == "replay":
            return with_recording(trial, name, damage, [FILE])
        damage(trial.state())
        return refused(trial, name, [FILE], restart="latest")
    return run


def with_recording(trial, name, damage, codes):
    """What is replayed is damaged, and good again for the restart."""
    good = trial.folder / "good.h5"
    shutil.copy(trial.recording, good)
    damage(trial.recording)
    launch = trial.launch(end=20)
    shutil.copy(good, trial.recording)
    return trial.judge(name, launch, codes)


def refused(trial, name, codes, restart, settings=(), culprits=()):
    """What names this set is refused; what looks for the latest passes it over, or names the one before."""
    launch = trial.launch(restart=f"out/checkpoints/{SETS[-1]}", end=20, settings=settings)
    return trial.judge(name, launch, codes, culprits or [trial.state().name, rf"\b{trial.name}\b"], restart)


def missing_part(trial):
    if trial.participant == "replay":
        return damaged("missing part", without_values)(trial)
    name = "history.csv" if trial.participant == "coupler" else trial.state().name
    (trial.sets / SETS[-1] / name).unlink()
    return refused(trial, "missing part", [FILE], "latest", culprits=[name])


def without_values(recording):
    with h5py.File(recording, "r+") as file:
        del file["values"]


def of_another_field(recording):
    with h5py.File(recording, "r+") as file:
        file["points"].attrs["field"] = np.bytes_("potential")


def foreign(trial):
    """With the right checksums: the state of another physics; of the coupler, of another mesh; of a replay, another field."""
    if trial.participant == "coupler":
        return refused(trial, "foreign", [FILE], "latest", ["cells_column=4"], ["cells_column is 3 there and 4 here"])
    if trial.participant == "replay":
        return with_recording(trial, "foreign", of_another_field, [HANDSHAKE])
    other = trial.sets / SETS[-1] / ("mech.h5" if trial.participant == "ale" else "ale.h5")
    if trial.participant == "ep":
        with h5py.File(trial.state(), "r+") as file:
            file.move("tissue", "wall")
    else:
        shutil.copy(other, trial.state())
    sets.seal(trial.sets / SETS[-1])
    return refused(trial, "foreign", [FILE, MAP], "4 ms")


def missing_rank(trial):
    """With the right checksums: half of the points are not there."""
    if trial.participant == "replay":
        return with_recording(trial, "missing rank", sets.drop_rank, [MAP])
    sets.drop_rank(trial.state())
    sets.seal(trial.sets / SETS[-1])
    return refused(trial, "missing rank", [MAP, FILE], "4 ms")


def wrong_version(trial):
    sets.seal(trial.sets / SETS[-1], format=1)
    return refused(trial, "wrong version", [FILE], "latest", culprits=["is of format 1"])


ONE_RANK = {"coupler": "it has one rank"}
NO_FIELD = {"coupler": "it computes no field"}
LINEAR = ("its systems are linear: allowed tolerances, down to 1e-14, were met with all settings that were tried; "
          "a coupling that does not converge is told by the blood, column coupler")
READS_ONLY = {"replay": "it solves nothing"}
NO_MESH = {"coupler": "it has no mesh", "ep": "its mesh does not move", "replay": "it has no mesh",
           "fluid": "ale has looked at the motion before"}
WRITES_NOTHING = {"replay": "it writes nothing"}
IN_MANIFEST = "the set has one version, in its manifest: column coupler"

FAULTS = [
    Fault("SIGKILL of the root", signalled("SIGKILL of the root", signal.SIGKILL, 137)),
    Fault("SIGKILL of another rank", signalled("SIGKILL of another rank", signal.SIGKILL, 137, 1), ONE_RANK),
    Fault("SIGSTOP", signalled("SIGSTOP", signal.SIGSTOP, DEADLINE)),
    Fault("SIGSEGV", signalled("SIGSEGV", signal.SIGSEGV, 139)),
    Fault("NaN in a field", not_a_number, NO_FIELD),
    Fault("overflow in a field", overflow, {**NO_FIELD, "replay": "it computes nothing, who hears it is to blame"}),
    Fault("no convergence", no_convergence, {**READS_ONLY, "ep": LINEAR, "ale": LINEAR, "fluid": LINEAR}),
    Fault("inverted mesh", inverted, NO_MESH),
    Fault("disk full: fields", no_room("disk full: fields", "output.every=0.2 ms"),
          {**WRITES_NOTHING, "ale": "it writes no fields"}),
    Fault("disk full: checkpoint", no_room("disk full: checkpoint"),
          {**WRITES_NOTHING, "coupler": "its history, of each step, is first: row above"}),
    Fault("truncated", damaged("truncated", sets.truncate)),
    Fault("flipped byte", damaged("flipped byte", sets.flip)),
    Fault("foreign", foreign),
    Fault("missing part", missing_part),
    Fault("missing rank", missing_rank, ONE_RANK),
    Fault("wrong version", wrong_version, {name: IN_MANIFEST for name in PARTICIPANTS[1:-1]} |
          {"replay": "a recording names its field, unit and points instead"}),
]
