"""The ranks of a launch that run on this machine, as /proc shows them."""
import os
import time
from dataclasses import dataclass, field
from pathlib import Path

PAGE = os.sysconf("SC_PAGE_SIZE")
GIB = 1024**3


def stat_of(pid):
    """(state, parent, resident memory [byte]) or None: it has ended."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return None
    fields = text[text.rindex(")") + 2:].split()  # the name before may hold anything
    return fields[0], int(fields[1]), int(fields[21]) * PAGE


def rank_of(pid):
    """Rank of the whole that mpirun has given to a process; None before it is a program."""
    try:
        words = Path(f"/proc/{pid}/environ").read_bytes().split(b"\0")
    except OSError:
        return None
    for word in words:
        if word.startswith(b"PMIX_RANK="):
            return int(word.split(b"=")[1])
    return None


def oom_kills():
    """How many processes the kernel has killed since the machine started for want of memory."""
    for line in Path("/proc/vmstat").read_text().splitlines():
        if line.startswith("oom_kill "):
            return int(line.split()[1])
    return 0


def memory_of_machine():
    for line in Path("/proc/meminfo").read_text().splitlines():
        if line.startswith("MemTotal:"):
            return int(line.split()[1]) * 1024
    return 0


@dataclass
class Ranks:
    """What has been seen of them; `look` looks again."""
    parent: int
    pids: dict = field(default_factory=dict)     # by rank, also of those that have ended
    states: dict = field(default_factory=dict)   # by rank: state and since when; of those that are there
    memory: int = 0                              # most of all together [byte]
    oom_before: int = field(default_factory=oom_kills)

    def look(self):
        states, memory = {}, 0
        by_pid = {pid: rank for rank, pid in self.pids.items()}
        for pid in (int(entry) for entry in os.listdir("/proc") if entry.isdigit()):
            stat = stat_of(pid)
            if not stat or stat[1] != self.parent or stat[0] in "ZX":
                continue
            rank = by_pid.get(pid)
            if rank is None:
                rank = rank_of(pid)
            if rank is None:
                continue
            self.pids[rank] = pid
            before = self.states.get(rank)
            states[rank] = before if before and before[0] == stat[0] else (stat[0], time.time())
            memory += stat[2]
        self.states = states
        self.memory = max(self.memory, memory)

    def missing(self, n_ranks):
        """Ranks that are not there, if any is at all: on other nodes they cannot be seen."""
        return [rank for rank in range(n_ranks) if rank not in self.states] if self.states else []

    def stopped(self):
        """(rank, pid, since) of those that a signal or a debugger holds."""
        return [(rank, self.pids[rank], since) for rank, (state, since) in sorted(self.states.items()) if state in "Tt"]

    def use_of_memory(self):
        used = f"all processes of the run on this machine had {self.memory / GIB:.1f} of {memory_of_machine() / GIB:.1f} GiB"
        if oom_kills() > self.oom_before:
            return f"the kernel ended a process for want of memory; {used}: fewer ranks or a coarser mesh need less"
        return f"the kernel has not done it for want of memory ({used}), so somebody has"
