"""What the coupler hands over: the programs of a launch, how often each is started and with which words."""
import os
import shlex
import subprocess
from dataclasses import dataclass, field


@dataclass
class Program:
    name: str
    ranks: int = 1
    words: list = field(default_factory=list)

    @property
    def shown(self):
        """The program; of a command of the scene all of it, without what `env` is told before (coupler/launch.cpp)."""
        if self.words[0] != "env":
            return self.words[0]
        return " ".join(self.words[3:])


@dataclass
class Plan:
    """One launch. Ranks of the whole are counted through its programs in their order; the coupler is the first."""
    folder: str = ""
    deadline: float = 0  # [s]
    memory: float = 0    # of all ranks, an estimate [byte]
    programs: list = field(default_factory=list)

    @property
    def n_ranks(self):
        return sum(program.ranks for program in self.programs)

    def member(self, rank):
        """(program, rank within it) of a rank of the whole."""
        for program in self.programs:
            if rank < program.ranks:
                return program, rank
            rank -= program.ranks
        raise IndexError(rank)

    def who(self, rank):
        program, own = self.member(rank)
        return program.name if program.ranks == 1 else f"{program.name} (rank {own})"


def ask_coupler(coupler, arguments, default_scene):
    """The plan; or the coupler's exit code, when it has done all that was asked (--validate), or refused."""
    reader, writer = os.pipe()
    command = [coupler, *arguments, "--default-scene", default_scene, "--hand-over", str(writer)]
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, pass_fds=[writer])
    os.close(writer)
    with os.fdopen(reader, "rb") as file:
        text = file.read()
    code = process.wait()
    return parse(text) if code == 0 and text else code


def parse(text):
    """Keys and values, each ended by a zero byte: nothing that a shell would read, whatever is in a name."""
    words = [os.fsdecode(word) for word in text.split(b"\0")[:-1]]
    plan = Plan()
    for key, value in zip(words[::2], words[1::2]):
        if key == "participant":
            plan.programs.append(Program(value))
        elif key == "ranks":
            plan.programs[-1].ranks = int(value)
        elif key == "word":
            plan.programs[-1].words.append(value)
        else:
            setattr(plan, key, value if key == "folder" else float(value))
    return plan


def quoted(words):
    """For people, and for their shells."""
    return shlex.join(words).replace("' : '", " : ")
