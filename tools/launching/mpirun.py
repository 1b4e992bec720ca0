"""The command line and the variables of mpirun."""
import os

from .terminal import TERMINAL

# Ranks wait asleep most of the time and may share cores. The eager limit is for programs of others: ours set it themselves
# (common/bus/process.cpp).
VARIABLES = {"OMPI_MCA_mpi_yield_when_idle": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1",
             "OMPI_MCA_btl_vader_eager_limit": "65536", "OMPI_MCA_btl_vader_max_send_size": "65536",
             "OMPI_MCA_hwloc_base_binding_policy": "none", "OMP_NUM_THREADS": "1"}
if os.geteuid() == 0:
    VARIABLES.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")


def arguments(plan, nodes, placed):
    words = []
    names = ["OMP_NUM_THREADS", "HEARTBUS_PULSE", *(["HEARTBUS_LIVE"] if TERMINAL.is_live else []),
             *(name for name in ("PYTHONPATH",) if name in os.environ)]
    passed_on = [word for name in names for word in ("-x", name)] if nodes else []
    for k, program in enumerate(plan.programs):
        words += [":"] if words else []
        if nodes:
            hosts = [f"{node.name}:{n}" for node, n in zip(nodes, placed[k]) if n]
            words += ["--host", ",".join(hosts)]
        words += ["-n", str(program.ranks), *program.words]
    return passed_on + words


def variables(plan, nodes):
    """Of several nodes: ranks get the variables, too, and a node that is silent is missed before the deadline."""
    result = dict(VARIABLES)
    if nodes:
        silence = max(2, int(plan.deadline / 6))
        result.update(OMPI_MCA_oob_tcp_keepalive_time=str(silence), OMPI_MCA_oob_tcp_keepalive_intvl="1",
                      OMPI_MCA_oob_tcp_keepalive_probes=str(min(9, silence)))
    return result
