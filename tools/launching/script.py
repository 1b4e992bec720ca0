"""Launches for other hands: a line to type, a job script for SLURM."""
import os
import shlex

from . import mpirun
from .nodes import Node, place
from .plan import quoted

JOB = """#!/bin/bash
# {about}
#SBATCH --job-name={name}
#SBATCH --nodes={n_nodes}
#SBATCH --ntasks={n_tasks}
#SBATCH --exclusive
#SBATCH --overcommit
#SBATCH --mem={memory}M
#SBATCH --signal=USR1@300
# Five minutes before its end the job saves its state and stops: sbatch it again with --restart latest.
cd {here}
export {variables}
file=$(mktemp -p . .job.XXXXXX)
cat > "$file" << 'END'
{programs}
END
# Task by task, the node that it runs on.
nodes=($(scontrol show hostnames "$SLURM_JOB_NODELIST"))
for k in {places}; do echo "${{nodes[k]}}"; done > "$file.hosts"
SLURM_HOSTFILE="$file.hosts" srun --mpi=pmix --distribution=arbitrary --cpu-bind=none --overcommit --kill-on-bad-exit \\
  --multi-prog "$file"
code=$?
rm -f "$file" "$file.hosts"
exit $code
"""


def line(plan, nodes, placed):
    variables = mpirun.variables(plan, nodes)
    return " ".join([*(f"{name}={value}" for name, value in variables.items()), "mpirun",
                     quoted(mpirun.arguments(plan, nodes, placed))])


def needed_nodes(plan, placement, cores):
    """The fewest on which no participant has more ranks than cores."""
    needed = [-(-program.ranks // cores) for program in plan.programs if program.name != "coupler"]
    return max(needed) if placement == "shared" else sum(needed)


def slurm(plan, placement, n_nodes, cores):
    n_nodes = n_nodes or needed_nodes(plan, placement, cores)
    placed = place(plan, [Node(str(k), cores) for k in range(n_nodes)], placement)
    programs, places, first = [], [], 0
    for program, counts in zip(plan.programs, placed):
        last = first + program.ranks - 1
        ranks = str(first) if first == last else f"{first}-{last}"
        programs.append(f"{ranks} {shlex.join(program.words)}")
        places += [str(k) for k, count in enumerate(counts) for _ in range(count)]
        first = last + 1
    most = max(places.count(k) for k in set(places))
    variables = {name: value for name, value in mpirun.VARIABLES.items() if "ROOT" not in name}
    about = (f"{plan.folder}: {plan.n_ranks} tasks on {n_nodes} nodes of {cores} cores, {most} on the fullest, "
             f"placement {placement}; all need about {plan.memory / 2**30:.1f} GiB")
    return JOB.format(about=about, name="heartbus", n_nodes=n_nodes, n_tasks=plan.n_ranks,
                      memory=round(plan.memory / plan.n_ranks * most * 1.2 / 2**20), here=shlex.quote(os.getcwd()),
                      variables=" ".join(f"{name}={value}" for name, value in variables.items()),
                      programs="\n".join(programs), places=" ".join(places))
