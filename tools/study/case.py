"""What a run computes, however studies call it: one scene, perhaps with recorded calcium, perhaps from a checkpoint."""
import hashlib
import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from .scene import lay_over, mesh_file, quantity


def content(file):
    """Tells a mesh from another, whatever its file is called; its name, where there is no such file."""
    try:
        return hashlib.sha256(Path(file).read_bytes()).hexdigest()
    except OSError:
        return file


@dataclass
class Start:
    case: "Case"
    when: object  # time [s]; ["before", phase, time from its beginning, grid]; "last"


@dataclass
class Case:
    tree: dict
    calcium: "Case" = None  # whose recording is played in place of electrophysiology
    start: Start = None
    steps: int = None  # from the start; to the end of the scene, when none
    records: str = None  # a field that is recorded
    identity: dict = None  # what tells it from others, if not all of the scene
    until: list = None  # ends [phase, time from its beginning, grid] of the run that it starts from
    repetition: int = 0  # the same again, to see how much its times vary

    @cached_property
    def fingerprint(self):
        """Equal for equal runs of all studies, whatever their names."""
        scene = self.identity or {key: value for key, value in self.tree.items() if key != "scene"}
        if mesh_file(scene):
            scene = lay_over(scene, {"geometry": {"mesh": content(mesh_file(scene))}})
        what = [scene, self.steps, self.records, self.calcium and self.calcium.fingerprint]
        if self.start:
            what += [self.start.case.fingerprint, self.start.when]
        what += [{key: value} for key, value in (("until", self.until), ("repetition", self.repetition)) if value]
        return hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()[:16]

    @property
    def step(self):
        return quantity(self.tree["time"]["step"])

    @property
    def needs(self):
        """The cases that must have been computed before."""
        return [case for case in (self.calcium, self.start and self.start.case) if case]

    @property
    def n_steps(self):
        """About, since a phase starts when it starts."""
        if self.steps:
            return self.steps
        if self.until:
            return 400  # at most, from one checkpoint to the next
        begin = self.start.when if self.start and isinstance(self.start.when, float) else 0
        return max(1, round((quantity(self.tree["time"]["end"]) - begin) / self.step))
