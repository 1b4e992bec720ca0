"""Numbers of a finished run: its indicators, and how far it is from its reference.

| column | what |
|---|---|
| error_EF, error_p_max | relative difference [%] |
| error_ILI_C, error_ILI_R | difference [percentage points] |
| error_activation | difference of the time at which the last point of the wall is activated [ms] |
| error_V, error_p | of V(t) and p(t): L2 norm in time of the difference over that of the reference [%] |
| max_V, max_p | largest difference in time [mL, mmHg] |
| cost_s | CPU time as a user has it: what replays calcium at the price of the electrophysiology that has made it [s] |
| start_s | of that, what passes before the first step [s] |
| h_mm | mean diameter of the wall's cells |
| step_ms, assembly_ms, solve_ms | wall time of a mean step, and of assembly and solution for blood and wall in it |
| contraction_*, ejection_* | maximum in time of the difference over a part of the heartbeat, see `norms` |

The volume of a step's end t^{n+1} in history.csv is that of the wall at t^n, whose motion the fluid's mesh follows one step
later: V(t) is compared at the time it belongs to, or else runs with different steps would differ by dV/dt of a step.
"""
from functools import lru_cache
from pathlib import Path

import h5py
import numpy as np

from results import ML, MMHG, History, indicators

UNITS = {"EF_percent": "%", "p_max_mmHg": "mmHg", "ILI_C_percent": "%", "ILI_R_percent": "%", "EDV_mL": "mL",
         "ESV_mL": "mL", "cpu_s": "s", "wall_s": "s", "error_EF": "%", "error_p_max": "%", "error_ILI_C": "points",
         "error_activation": "ms", "activation_time_ms": "ms", "cost_s": "s",
         "error_ILI_R": "points", "step_ms": "ms", "assembly_ms": "ms", "solve_ms": "ms", "h_mm": "mm", "error_V": "%", "error_p": "%", "max_V": "mL", "max_p": "mmHg"}
NORM_UNITS = {"d": "m m^(3/2)", "u": "m/s m^(3/2)", "pressure": "Pa m^(3/2)", "V": "mL", "p": "mmHg"}
FIELDS = {"d": ("mech", "displacement"), "u": ("fluid", "velocity"), "pressure": ("fluid", "pressure")}
USUAL = ["EF_percent", "p_max_mmHg", "ILI_C_percent", "ILI_R_percent", "mean_coupling_iterations", "cpu_s", "wall_s",
         "error_EF", "error_p_max", "error_V", "error_p", "max_V", "max_p"]
ASSEMBLY, SOLVE = ("assembly", "residual", "tangent"), ("preconditioner", "linear solve")  # works of a participant


@lru_cache(maxsize=6)
def loaded(folder, _):
    return History(folder)


def history(folder):
    """history.csv, read again only if it has changed."""
    return loaded(folder, (Path(folder) / "history.csv").stat().st_mtime_ns)


def measures(folder, reference=None, start=None, span=None):
    """All numbers of the run in a folder, which started from another's state at the time `start` if that is given; `span`:
    (begin, end) of what the norms are about."""
    found = {key: value for key, value in indicators(folder).items() if isinstance(value, (int, float))}
    found.update({f"wall_s_{who}_{work.replace(' ', '_')}": seconds
                  for who, all_work in indicators(folder).get("wall_s_by_work", {}).items()
                  for work, seconds in all_work.items()})
    found.update(times_of_a_step(indicators(folder)))
    if (Path(folder) / "fields/mech.h5").exists():
        found["h_mm"] = cell_diameter(Path(folder) / "fields/mech.h5")
    if reference is not None:
        found.update(errors(folder, reference))
        found.update(norms(folder, reference, start, span or window(folder, reference, start)))
    return found


def cost(store, case):
    """CPU seconds of the run with its start, as if it had computed the calcium that it replays: without the replay's share,
    with that of electrophysiology in the recording, for as many seconds of the heartbeat."""
    own = indicators(store.of(case))
    seconds = own["cpu_s"]
    if case.calcium and "cpu_s_by_part" in own:
        recording = indicators(store.of(case.calcium))
        share = own["steps_timed"] * case.step / (recording["steps_timed"] * case.calcium.step)
        seconds += share * price(recording, "cpu_s_by_part") + price(recording, "start_cpu_s_by_part")
        seconds -= price(own, "cpu_s_by_part") + price(own, "start_cpu_s_by_part")
    return seconds


def start_cost(store, case):
    """CPU seconds until the first step, which are part of the cost and do not grow with the length of the run."""
    return sum(indicators(store.of(case)).get("start_cpu_s_by_part", {}).values())


def price(known, when):
    """CPU seconds of electrophysiology, or of what is played in its place."""
    return known.get(when, {}).get("ep", 0)


def activation(store, case):
    """When the last point of the wall is activated [ms], or None; by the run that has computed the calcium."""
    return indicators(store.of(case.calcium or case)).get("activation_time_ms")


def times_of_a_step(known):
    """Of a mean step [ms]: all of it, and what blood and wall take to assemble and to solve their systems."""
    steps = known.get("steps_timed", 0)
    if not steps:
        return {}
    own = [work for who, work in known["wall_s_by_work"].items() if who in ("fluid", "mech", "fsi")]
    seconds = {"step_ms": known["wall_s"]}
    for name, works in (("assembly_ms", ASSEMBLY), ("solve_ms", SOLVE)):
        seconds[name] = sum(times.get(work, 0) for times in own for work in works)
    return {key: 1e3 * value / steps for key, value in seconds.items()}


def cell_diameter(path):
    """The mean of the cells' largest distance of two corners, at rest [mm]."""
    with h5py.File(path) as file:
        corners = file["mesh/points"][:][file["mesh/cells"][:].astype(int)]
    n = corners.shape[1]
    distances = [np.linalg.norm(corners[:, i] - corners[:, j], axis=1) for i in range(n) for j in range(i)]
    return 1e3 * float(np.max(distances, axis=0).mean())


def errors(folder, reference):
    own, exact, result = indicators(folder), indicators(reference), {}
    for name, key in (("EF", "EF_percent"), ("p_max", "p_max_mmHg")):
        if key in own and exact.get(key, 0) > 1e-3:
            result[f"error_{name}"] = 100 * abs(own[key] / exact[key] - 1)
    for name in "ILI_C", "ILI_R":
        if f"{name}_percent" in own and f"{name}_percent" in exact:
            result[f"error_{name}"] = abs(own[f"{name}_percent"] - exact[f"{name}_percent"])
    for name, column, scale in (("V", "volume", ML), ("p", "mean_pressure", MMHG)):
        curves = common_curve(folder, reference, column)
        if curves:
            _, values, exact_values = curves
            difference = values - exact_values
            result[f"error_{name}"] = 100 * np.sqrt(np.mean(difference**2) / max(np.mean(exact_values**2), 1e-300))
            result[f"max_{name}"] = abs(difference).max() / scale
    return result


def curve(folder, column):
    """(times, values) of a column of history.csv, at the times that the values belong to; None without it."""
    own = history(folder)
    if column not in own:
        return None
    return (own.time[:-1], own[column][1:]) if column == "volume" else (own.time, own[column])


def common_curve(folder, reference, column):
    """(times, values, the reference's values) at the run's times that both have; the reference is linear in between."""
    own, exact = curve(folder, column), curve(reference, column)
    if not (own and exact):
        return None
    (times, values), (exact_times, exact_values) = own, exact
    within = (times >= exact_times[0] - 1e-9) & (times <= exact_times[-1] + 1e-9)
    return times[within], values[within], np.interp(times[within], exact_times, exact_values)


def window(folder, reference, start=None):
    """(begin, end) of [0, first opening of the aortic valve in either), or, after a start in ejection or just before it, of what follows
    until its end. Runs that are to be compared by norms take the smallest of their windows: then an opening that moves with the step
    moves no end of a window."""
    ends = []
    for phases in history(folder).phases(), history(reference).phases():
        ejection = [(begin, end) for name, begin, end in phases
                    if name == "ejection" and (start is None or end > start)]
        if not phases or (start is not None and not ejection):
            return None
        ends.append(ejection[0][0] if ejection and start is None else ejection[0][1] if ejection else phases[-1][2])
    return start or 0, min(ends)


def common(spans, layer=0.):
    """The part of the time that all windows (begin, end) have; `layer` after their begin does not count."""
    spans = [span for span in spans if span]
    if not spans:
        return None
    begin = max(begin for begin, _ in spans)
    return begin + layer if begin else 0., min(end for _, end in spans)


def norms(folder, reference, start, span):
    """`PART_d`, `_u`, `_pressure`: L2 norm in space (nodal values, volumes of the reference mesh), maximum over the
    instants within `span` at which both runs have written fields; `_V` [mL], `_p` [mmHg]: maximum over the steps. PART is
    "contraction", or "ejection" for a run that started in it."""
    part = "contraction" if start is None else "ejection"
    if not span:
        return {}
    result = {}
    for name, (body, field) in FIELDS.items():
        value = field_difference(folder, reference, body, field, span)
        if value is not None:
            result[f"{part}_{name}"] = value
    for name, column, scale in (("V", "volume", ML), ("p", "mean_pressure", MMHG)):
        curves = common_curve(folder, reference, column)
        if curves:
            times, values, exact = curves
            within = (times >= span[0]) & (times < span[1])
            result[f"{part}_{name}"] = abs(values - exact)[within].max(initial=0) / scale
    return result


def field_difference(folder, reference, body, field, span):
    paths = [Path(where) / f"fields/{body}.h5" for where in (folder, reference)]
    if not all(path.exists() for path in paths):
        return None
    with h5py.File(paths[0]) as own, h5py.File(paths[1]) as exact:
        points = own["mesh/points"][:]
        order, exact_order = canonical(points), canonical(exact["mesh/points"][:])
        if len(order) != len(exact_order):
            return None
        weights = nodal_volumes(points, own["mesh/cells"][:].astype(int))[order]
        at = {round(1e6 * exact[group].attrs["time"]): group for group in exact if group != "mesh"}
        largest = None
        for group in own:
            microseconds = group != "mesh" and round(1e6 * own[group].attrs["time"])
            if group == "mesh" or microseconds not in at or not span[0] <= 1e-6 * microseconds < span[1]:
                continue
            difference = own[group][field][:][order] - exact[at[microseconds]][field][:][exact_order]
            largest = max(largest or 0, float(np.sqrt(weights @ np.sum(difference**2, axis=1))))
        return largest


def canonical(points):
    """An order of the points that does not depend on who wrote them."""
    return np.lexsort(np.round(points, 9).T)


def nodal_volumes(points, cells):
    """The share of each node in the volume of its cells [m^3]: a lumped mass matrix."""
    corners = points[cells[:, :8] if cells.shape[1] == 8 else cells[:, :4]]
    if corners.shape[1] == 8:  # by the edges at the centre
        low, high = corners[:, [0, 1, 2, 3]].mean(axis=1), corners[:, [4, 5, 6, 7]].mean(axis=1)
        left, right = corners[:, [0, 3, 4, 7]].mean(axis=1), corners[:, [1, 2, 5, 6]].mean(axis=1)
        front, back = corners[:, [0, 1, 4, 5]].mean(axis=1), corners[:, [2, 3, 6, 7]].mean(axis=1)
        volume = np.abs(np.linalg.det(np.stack([high - low, right - left, back - front], axis=1)))
    else:
        volume = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
    weights = np.zeros(len(points))
    np.add.at(weights, cells, (volume / cells.shape[1])[:, None])
    return weights


def order(steps, values):
    """(order, standard deviation) of a power law through the points."""
    steps, values = np.log(np.asarray(steps, float)), np.log(np.asarray(values, float))
    if len(steps) < 2:
        return np.nan, np.nan
    if len(steps) == 2:
        return float(np.diff(values)[0] / np.diff(steps)[0]), np.nan
    coefficients, covariance = np.polyfit(steps, values, 1, cov=True)
    return float(coefficients[0]), float(np.sqrt(covariance[0, 0]))
