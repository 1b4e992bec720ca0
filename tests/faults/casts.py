"""The smallest runs in which each participant takes part, with two checkpoints of their own from which faults begin."""
import shutil
import sys
import tempfile
from pathlib import Path

import h5py

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "coupling"))
from launch import SOURCE, Launch, launch_words  # noqa: E402

PISTON = SOURCE / "configs/benchmarks/piston/efs1.yaml"
HEARTBEAT = SOURCE / "tests/regression/small_heartbeat.yaml"
ALONE = "coupling: {scheme: one_way}\nparticipants: {ep: {ranks: 1}, %s ale: , fluid: }\n"
SCENES = {
    "piston": f"base: {PISTON}\n",
    "merged": f"base: {PISTON}\ncoupling: {{scheme: E1FSinf}}\n"
              "participants: {mech: , fluid: , fsi: {program: fsi_solver}}\n",
    "tissue": f"base: {HEARTBEAT}\n" + ALONE % "mech: ,",
    "replayed": f"base: {HEARTBEAT}\n" + ALONE % "mech: {ranks: 1},",
}
CAST_OF = {"coupler": "piston", "ep": "tissue", "mech": "piston", "ale": "piston", "fluid": "piston", "fsi": "merged",
           "replay": "replayed"}
NAME_OF = {"replay": "ep"}                     # in its cast; all others have their own
STATE_OF = {"fsi": "mech.h5", "coupler": "manifest.json"}  # all others: NAME.h5
STEP = 0.2                                     # [ms]
SETS = ("000020", "000040")                    # after 4 and 8 ms


def settings_words(settings):
    return [word for setting in settings for word in ("--set", setting)]


class Casts:
    """Runs each cast once, well; hands out copies."""

    def __init__(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.ready = {}

    def copy(self, cast, folder):
        if cast not in self.ready:
            self.ready[cast] = self.prepare(cast)
        shutil.copytree(self.ready[cast], folder)

    def prepare(self, cast):
        folder = Path(self.temporary.name) / cast
        folder.mkdir()
        scene = SCENES[cast]
        if cast == "replayed":
            (folder / "scene.yaml").write_text(scene)
            self.run(folder, "--record", "calcium=calcium.h5", "--out", "recorded", end=0.4)
            hold(folder / "calcium.h5")
            scene = scene.replace("ep: {ranks: 1}", "ep: {program: replay, settings: {file: calcium.h5}}")
        (folder / "scene.yaml").write_text(scene)
        self.run(folder, "--out", "out", end=8)
        return folder

    @staticmethod
    def run(folder, *words, end):
        words = launch_words("scene.yaml", folder, *words, "--ranks", "1", *settings_words([
            f"time.end={end} ms", "checkpoint.every=4 ms", "checkpoint.keep=10"]))
        launch = Launch(words, folder)
        if launch.code != 0:
            raise RuntimeError(launch.output)


def hold(recording):
    """Its last value, for a minute and a half: a run with it does not end before its fault."""
    with h5py.File(recording, "r+") as file:
        n = len(file["step"])
        for name, late in (("values", file["values"][n - 1]), ("step", 500000), ("time", 100.)):
            file[name].resize(n + 1, axis=0)
            file[name][n] = late
