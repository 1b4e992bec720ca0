"""One fault in one run: what it came to, and whether the last checkpoint restarts."""
import json
import os
import re
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from casts import CAST_OF, NAME_OF, SETS, SOURCE, STATE_OF, STEP, settings_words
from launch import Launch, children, launch_words, wait_for

DEADLINE = 8  # [s] of the runs, generous: machines of tests are loaded


@dataclass
class Outcome:
    fault: str
    participant: str
    seconds: float        # from the fault, or from the launch when the fault is in what it reads, to the end
    code: int
    causes: list          # lines that say why
    named: bool           # one of them names the culprit
    expected: bool        # the exit code is one that the fault should have
    orphans: int
    restarts: bool
    output: str

    def complaints(self):
        found = [] if self.expected else [f"ended with {self.code}"]
        found += [] if self.named else ["the culprit is not named"]
        found += [f"{self.orphans} processes are left"] if self.orphans else []
        return found + ([] if self.restarts else ["the last checkpoint does not restart"])


class Trial:
    """A copy of the participant's cast, and what can be done to it."""

    def __init__(self, casts, participant):
        self.participant, self.name = participant, NAME_OF.get(participant, participant)
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = Path(self.temporary.name) / "run"
        casts.copy(CAST_OF[participant], self.folder)
        self.sets = self.folder / "out/checkpoints"
        self.recording = self.folder / "calcium.h5"
        self.since = None

    def state(self, step=SETS[-1]):
        return self.sets / step / STATE_OF.get(self.participant, f"{self.name}.h5")

    def launch(self, *words, settings=(), restart="latest", end=90000, n_ranks=1, during=None):
        """With ./run's launcher."""
        settings = [f"deadline={DEADLINE} s", "checkpoint.every=4 ms", "checkpoint.keep=10", f"time.end={end} ms", *settings]
        self.since = time.monotonic()
        return Launch([sys.executable, SOURCE / "tools/launch.py", "scene.yaml", "--oversubscribe", "--out", "out", "--ranks",
                       str(n_ranks), "--restart", restart, *settings_words(settings), *words], self.folder, during)

    def ranks(self, launcher):
        """Process ids of the participant, its root first."""
        name = f"--name\0{self.name}\0".encode()
        found = {rank: pid for rank, pid in children(launcher).items() if self.is_named(pid, name)}
        return [found[rank] for rank in sorted(found)]

    def is_named(self, pid, name):
        words = Path(f"/proc/{pid}/cmdline").read_bytes()
        return b"/coupler\0" in words if self.name == "coupler" else words.endswith(name)

    def meanwhile(self, action, **options):
        """A run, and what is done to a participant's ranks once five steps and a checkpoint of its own are done."""
        history = self.folder / "out/history.csv"
        rows = round(8 / STEP) + 6

        def is_under_way():
            return history.exists() and history.read_text().count("\n") > rows and len(list(self.sets.glob("??????"))) > 2

        def during(launcher):
            wait_for(is_under_way, 90)
            action(self.ranks(launcher))
            self.since = time.monotonic()
        return self.launch(during=during, **options)

    def signalled(self, number, rank=0):
        return self.meanwhile(lambda pids: os.kill(pids[rank], number), n_ranks=rank + 1)

    def restarts(self, restart):
        """Whether the run goes on, 1 ms from the state."""
        if restart == "latest":
            sets = [json.loads(path.read_text()) for path in self.sets.glob("*/manifest.json") if is_json(path)]
            begin = max(manifest["time"] for manifest in sets)
        else:
            begin = 4e-3
        words = launch_words("scene.yaml", self.folder, "--out", "out", "--ranks", "1", *settings_words(
            [f"time.end={1e3 * begin + 1:g} ms", "deadline=60 s"]), "--restart", restart)
        launch = Launch(words, self.folder)
        return launch.code == 0 and "goes on from t = " in launch.output

    def judge(self, fault, launch, codes, culprits=(), restart="latest", seconds=None):
        """`culprits`: one of these expressions must be in a line that gives the cause; default: the participant's name."""
        seconds = time.monotonic() - self.since if seconds is None else seconds
        causes = [line for line in launch.output.splitlines() if re.match(r"heartbus: |error: ", line)]
        culprits = culprits or [rf"\b{self.name}\b"]
        named = any(re.search(culprit, line) for line in causes for culprit in culprits)
        return Outcome(fault, self.participant, seconds, launch.code, causes, named, launch.code in codes,
                       len(launch.orphans), self.restarts(restart), launch.output)


def is_json(path):
    try:
        return bool(json.loads(path.read_text()))
    except ValueError:
        return False
