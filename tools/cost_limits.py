"""The least time that each part of a step can take on this machine; see tools/cost --limits.

A part must move its data between memory and core, and do its arithmetic: its limit is the longer of the two times, at the
bandwidth and the peak rate that as many copies of a triad and of a loop of multiply-adds reach together as there are ranks
(`benchmark_kernels --limits`, run when asked for). What must be moved is counted for a mesh of linear hexahedra: 24 neighbours
a node (27 inside), 0.83 cells a node, everything read once a pass. Floating-point operations of the kernels are
those that tests/benchmarks count.
"""
import subprocess

BLOCKS = 24            # of a node's row
CELLS = 0.83           # a node
GEOMETRY = 8 * 8 * 25  # bytes a cell: gradients of 8 shape functions and weights at 8 quadrature points
FRAMES = 8 * 8 * 9     # fibre frames
FLOPS = {"wall, residual": 6.3e3, "wall, tangent": 40e3, "blood": 45e3, "ionic model": 2.9e3, "force model": 440}
REFRESH = 20           # steps between refreshes of what is kept


def machine(programs, ranks):
    """Bandwidth [B/s] and peak rate [1/s] of so many cores together."""
    copies = [subprocess.Popen([f"{programs}/benchmark_kernels", "--limits"], stdout=subprocess.PIPE, text=True)
              for _ in range(ranks)]
    rates = [[float(word) for word in copy.communicate()[0].split()] for copy in copies]
    return sum(rate[0] for rate in rates), sum(rate[1] for rate in rates)


def matrix(components, number):
    """Bytes of a node's row of blocks, with the columns."""
    return BLOCKS * (components ** 2 * number + 4)


def work(cost):
    """(participant, part) -> bytes to move, floating-point operations to do in a step."""
    points, its = cost["points"], {name.removesuffix("_iterations"): n for name, n in cost["iterations"].items()}
    repeats = its.get("coupling", 1)  # the iterations reported are those of the last repeat
    works = {}
    for name, sets in points.items():
        if name == "ep":
            n = sets["tissue"]
            works[name, "ionic model"] = (n * 8 * 2 * 19, n * FLOPS["ionic model"])
            works[name, "assembly"] = (n * 2 * matrix(1, 8), 0)
            works[name, "linear solve"] = (n * its["ep"] * (2 * matrix(1, 4) + 12 * 8), 0)
        if name == "ale":
            n = sets["cavity"]
            works[name, "assembly"] = (n * 2 * matrix(1, 8), 0)
            works[name, "linear solve"] = (n * its["lifting"] * (matrix(1, 8) + matrix(1, 4) + 12 * 24), 0)
            works[name, "check of the mesh"] = (n * CELLS * GEOMETRY, 0)
        if name in ("fluid", "fsi"):
            n = sets["cavity"]
            works[name, "assembly"] = (n * (CELLS * GEOMETRY + 2 * matrix(4, 4)), n * CELLS * FLOPS["blood"])
            works[name, "averages"] = (n * CELLS * GEOMETRY, 0)
            works[name, "preconditioner"] = (n * 2 * matrix(4, 4) / REFRESH, 0)
            fluid_pass = n * 2 * matrix(4, 4)
            if name == "fluid":
                works[name, "linear solve"] = (repeats * its["fluid"] * (fluid_pass + n * 32 * (its["fluid"] + 4)), 0)
        if name in ("mech", "fsi"):
            n = sets["tissue"]
            cells = n * CELLS
            passes = repeats * (its["newton"] + 1)
            works[name, "residual"] = (passes * cells * (GEOMETRY + FRAMES), passes * cells * FLOPS["wall, residual"])
            works[name, "stretch"] = works[name, "datum"] = (cells * (GEOMETRY + FRAMES), 0)
            works[name, "force model"] = (n * 8 * 8, n * FLOPS["force model"])
            works[name, "tangent"] = (n * matrix(3, 8) / REFRESH, cells * FLOPS["wall, tangent"] / REFRESH)
            wall_pass = n * 2 * matrix(3, 4)
            if name == "mech":
                works[name, "linear solve"] = (repeats * its["solid"] * (wall_pass + n * 24 * 10), 0)
                works[name, "preconditioner"] = (n * 2 * matrix(3, 4) / REFRESH, 0)
            else: # both at once, and a basis of both
                works[name, "linear solve"] = (its["fsi"] * (wall_pass + fluid_pass + 28 * n * (its["fsi"] + 4)), 0)
    return works


def limits(cost, rates):
    """{participant: {part: ms}}"""
    result = {}
    for (name, part), (moved, flops) in work(cost).items():
        result.setdefault(name, {})[part] = 1e3 * max(moved / rates[0], flops / rates[1])
    return result
