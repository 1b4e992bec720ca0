"""Where a launch runs: on this machine, on the nodes of a hosts file, in an allocation of SLURM or PBS."""
import os
import re
import subprocess
from dataclasses import dataclass


class Refusal(Exception):
    """What is asked for cannot be launched here."""


@dataclass
class Node:
    name: str
    slots: int


def own_cores():
    return len(os.sched_getaffinity(0))


def find_nodes(hosts):
    """Of --hosts, else of the allocation that this shell is in; none: this machine alone."""
    if hosts:
        return read_hosts(hosts)
    if os.environ.get("PBS_NODEFILE"):
        return read_hosts(os.environ["PBS_NODEFILE"])
    if os.environ.get("SLURM_JOB_NODELIST"):
        return slurm_nodes(os.environ["SLURM_JOB_NODELIST"], os.environ.get("SLURM_JOB_CPUS_PER_NODE", "1"))
    return []


def read_hosts(file_name):
    """Lines of `name`, `name slots=4` or `name:4`; a name that stands there twice counts twice."""
    nodes = {}
    try:
        with open(file_name, encoding="utf-8") as file:
            lines = [line.split("#")[0].strip() for line in file]
    except OSError as error:
        raise Refusal(f"{file_name}: this hosts file cannot be read: {error.strerror}") from error
    for number, line in enumerate(lines, 1):
        found = re.fullmatch(r"([\w.-]+)(?::(\d+)|\s+slots\s*=\s*(\d+))?(\s+max[-_]slots\s*=\s*\d+)?", line)
        if line and not found:
            raise Refusal(f"{file_name}:{number}: '{line}' is no host; write e.g. 'node7 slots=16'")
        if line:
            nodes.setdefault(found[1], Node(found[1], 0)).slots += int(found[2] or found[3] or 1)
    if not nodes:
        raise Refusal(f"{file_name}: names no host; write e.g. 'node7 slots=16'")
    return list(nodes.values())


def slurm_nodes(names, cores):
    """`cores` as SLURM writes them: 16(x2),8."""
    listed = subprocess.run(["scontrol", "show", "hostnames", names], stdout=subprocess.PIPE, text=True, check=True)
    counts = []
    for part in cores.split(","):
        count, _, times = part.partition("(x")
        counts += [int(count)] * int(times.rstrip(")") or 1)
    return [Node(name, count) for name, count in zip(listed.stdout.split(), counts)]


def check_room(plan, nodes, oversubscribe):
    """The participants take turns: each may fill all cores."""
    room = sum(node.slots for node in nodes) or own_cores()
    where = f"the {len(nodes)} nodes have" if nodes else "this machine has"
    for program in plan.programs:
        if program.ranks > room and not oversubscribe:
            raise Refusal(f"key 'participants.{program.name}.ranks': {program.ranks} ranks, but {where} {room} cores; "
                          "--hosts FILE names more nodes, --oversubscribe lets ranks share cores")


def place(plan, nodes, placement):
    """For each program, how many of its ranks come to each node.

    shared: each participant is spread over all nodes, so that one that works has all cores while the others sleep, and
    fields are exchanged within a node for the most part. spread: each participant has nodes of its own, as far as they
    reach: for participants that work at the same time."""
    slots = [node.slots for node in nodes]
    placed, first = [], 0
    for program in plan.programs:
        if program.name == "coupler":
            placed.append([1] + [0] * (len(nodes) - 1))
            continue
        if placement == "shared":
            first = 0
        counts, left, k = [0] * len(nodes), program.ranks, first
        while left > 0:
            take = min(left, slots[k % len(nodes)])
            if placement == "shared":
                take = min(take, -(-program.ranks * slots[k % len(nodes)] // sum(slots)))
            counts[k % len(nodes)] += take
            left -= take
            k += 1
        first = k % len(nodes)
        placed.append(counts)
    return placed
