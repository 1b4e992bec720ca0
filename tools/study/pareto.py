"""Cost against error of the runs of a study: which choices no other beats in both, and the cheapest that is good enough.

    pareto:
      errors: [error_EF, error_V]
      runs: ["M*"]                     # the choices; all runs, when left out
      floor:                           # how far the reference itself may be off, from neighbours of it
        step: {run: reference_dt0.4, order: 1, ratio: 2}
        mesh: {run: reference_M1, against: reference, order: 2, ratio: 1.5}

A neighbour that is coarser by the ratio r differs from the reference by r^p - 1 times the reference's own error; what all
neighbours say together is the floor, below which differences of two errors mean nothing.
"""
import csv
import re
from fnmatch import fnmatch

import numpy as np
import yaml
from matplotlib import patheffects

from reporting import style

from . import measures
from .figures import label, log_ordinate, plt, save
from .scene import StudyError

COST = "cost_s"  # of the whole run, as a user has it: a heartbeat with electrophysiology and start
NOISE = 0.05  # share by which one run's cost differs from the next one's, other work on the machine apart
SHORT = {name: f"error_{name}" for name in ("EF", "p_max", "ILI_C", "ILI_R", "V", "p", "activation")}
SHAPES = {"M0": "s", "M1": "D", "MXS": "o", "M2": "^", "M3": "v"}  # of the meshes, the same in every figure
MORE_SHAPES = "P*Xph"


def candidates(study, table):
    """Rows that have a cost and an error: finished runs with a reference that is not themselves."""
    wanted = study.pareto.get("runs", ["*"])
    return [row for row in table if row["state"] == "done" and "error_V" in row and row.get(COST, 0) > 0
            and any(fnmatch(row["run"], each) for each in wanted)]


def need_reference(study, store):
    """Without the reference there are no errors: said once, with what to do."""
    if not study.reference or "{" in study.reference:
        return
    case = study.case(study.by_name[study.reference])
    if store.state(case) != "done":
        raise StudyError(f"{study.name}: the reference '{study.reference}' is {store.state(case)}"
                         f"{': ' + store.reason(case) if store.reason(case) else ''}, so there are no errors: "
                         f"tools/study.py run {study.file} --only {study.reference}")


def floors(study, store, errors):
    """({error: own error of the reference}, [runs that are missing]); empty when the study does not ask for it."""
    total, missing = {}, []
    for entry in study.pareto.get("floor", {}).values():
        cases = [study.case(study.by_name[name]) for name in (entry["run"], entry.get("against", study.reference))]
        if any(store.state(case) != "done" for case in cases):
            missing.append(entry["run"])
            continue
        found = measures.errors(*map(store.of, cases))
        activated = [measures.activation(store, case) for case in cases]
        if all(activated):
            found["error_activation"] = abs(activated[0] - activated[1])
        for error in errors:
            if error in found:
                total[error] = total.get(error, 0.) + found[error] / (entry.get("ratio", 2)**entry.get("order", 1) - 1)
    return total, missing


def front(points):
    """Whether each (cost, error) is beaten by no other point in both."""
    return [not any(c <= cost and e <= error and (c, e) != (cost, error) for c, e in points) for cost, error in points]


def draw(study, store, table, folder):
    """pareto_<error>.png for each error, pareto.csv. The exit code."""
    need_reference(study, store)
    rows = candidates(study, table)
    if not rows:
        raise StudyError(f"{study.name}: no finished run with a reference yet: run the study first")
    errors = study.pareto.get("errors", ["error_EF", "error_p_max", "error_V", "error_p"])
    shapes = shapes_of([row.get("mesh", "") for row in rows])
    floor, unknown = floors(study, store, errors)
    for error in errors:
        known = [row for row in rows if error in row]
        for row, best in zip(known, front([(row[COST], row[error]) for row in known])):
            row[f"front_{error}"] = int(best)
        if known:
            chart(study, known, shapes, error, floor.get(error), folder / f"pareto_{error.removeprefix('error_')}.png")
    keys = ["run", COST, "start_s", "cost_min_s", "cost_max_s", "repetitions",
            *[key for error in errors for key in (error, f"front_{error}")]]
    with open(folder / "pareto.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, keys, restval="", extrasaction="ignore")
        writer.writeheader()
        writer.writerows(sorted(rows, key=lambda row: row[COST]))
        writer.writerows([{"run": "floor", **floor}] if floor else [])
    missing = [row["run"] for row in table if row["state"] != "done"]
    print(f"{folder}/pareto.csv: {len(rows)} choices" + (f"; missing: {', '.join(missing)}" if missing else ""))
    print("floor: " + (", ".join(f"{error} {value:.2g}" for error, value in floor.items()) or "not known")
          + (f"; too low without {', '.join(unknown)}" if unknown else ""))
    return 1 if missing else 0


def chart(study, rows, shapes, error, floor, path):
    drawing, axis = plt.subplots(figsize=(12, 8))
    axis.set_xscale("log")
    least = min([row[error] for row in rows if row[error] > 0], default=1e-12)
    points = [(row[COST], max(row[error], least), row) for row in rows]
    schemes = list(dict.fromkeys(row.get("scheme", row["run"]) for row in rows))
    looks = dict(zip(schemes, zip(style.colours(schemes), (edge(i) for i in range(len(schemes))))))
    for cost, value, row in points:
        shade, around = looks[row.get("scheme", row["run"])]
        axis.plot(cost, value, shapes[row.get("mesh", "")], color=shade, ms=7, mec=around, mew=0.5)
        if "cost_min_s" in row:
            axis.plot([row["cost_min_s"], row["cost_max_s"]], [value, value], "-", color=shade, lw=1)
    best = sorted(((cost, value, row["run"]) for cost, value, row in points if row[f"front_{error}"]))
    axis.step(*zip(*[point[:2] for point in best]), where="post", color="0.75", lw=1, zorder=1)
    axis.plot(*zip(*[point[:2] for point in best]), "o", mfc="none", color="black", ms=13)
    axis.margins(0.12)
    low, high = axis.get_xlim()
    if high < 2 * low:  # or else noise looks like a difference
        axis.set_xlim(np.sqrt(low * high / 2), np.sqrt(low * high * 2))
    for each in (axis.xaxis.set_major_formatter, axis.xaxis.set_minor_formatter):
        each(lambda x, _: f"{x:.3g}")
    if floor:
        axis.axhspan(axis.get_ylim()[0] / 10, floor, color="0.85", zorder=0)
        axis.set_ylim(bottom=min(floor, least) / 2)
    log_ordinate(axis)
    put_labels(drawing, axis, best, [point[:2] for point in points])
    axis.set_xlabel("cost of the run with electrophysiology and start [CPU s]")
    axis.set_ylabel(label(error) + f" against {study.reference}")
    legends(axis, looks, {mesh: shapes[mesh] for mesh in shapes if any(row.get("mesh") == mesh for row in rows)}, floor)
    save(drawing, path, study.about)


def shapes_of(meshes):
    """Of all the meshes there are: a mesh has one shape in the charts of all errors, whichever of them it has."""
    others = [each for each in dict.fromkeys(meshes) if each not in SHAPES]
    return {**SHAPES, **{mesh: MORE_SHAPES[i % len(MORE_SHAPES)] for i, mesh in enumerate(others)}}


def edge(i):
    """Of a marker: when the colours begin anew, another one."""
    return "0.2" if i < len(style.PALETTE) else "red"


def legends(axis, looks, shapes, floor):
    """Colours of the schemes and shapes of the meshes, apart."""
    first = [plt.Line2D([], [], ls="", marker="o", color=shade, label=name, mec=around) for name, (shade, around) in looks.items()]
    second = [plt.Line2D([], [], ls="", marker=shape, color="0.5", label=name) for name, shape in shapes.items() if name]
    second += [plt.Line2D([], [], ls="", marker="o", mfc="none", ms=11, color="black", label="front")]
    if floor:
        second += [plt.Rectangle((0, 0), 1, 1, facecolor="0.85", edgecolor="0.6",
                                 label="own error of the reference: differences mean nothing")]
    axis.add_artist(axis.legend(handles=first, fontsize=8, loc="upper right"))
    axis.legend(handles=second, fontsize=8, loc="lower left")


def put_labels(drawing, axis, points, all_points):
    """Names beside their points, each in the first of some places within the axes where it covers no other name and no point."""
    drawing.canvas.draw()
    pixels = axis.transData.transform([point[:2] for point in points])
    taken = [(x - 4, y - 4, x + 4, y + 4) for x, y in axis.transData.transform(all_points)]
    unit, frame = drawing.dpi / 72, axis.get_window_extent()
    for (x, y), (*_, name) in sorted(zip(pixels, points), key=lambda entry: -entry[0][1]):
        width, height = 3.9 * len(name) * unit, 8 * unit
        places = [(side, shift) for shift in sorted(range(-120, 121, 8), key=abs) for side in (1, -1)]
        for side, shift in places:
            left = x + 7 * unit if side > 0 else x - 7 * unit - width
            box = (left, y + shift * unit - height / 2, left + width, y + shift * unit + height / 2)
            if frame.x0 <= box[0] and box[2] <= frame.x1 and all(
                    box[2] < t[0] or t[2] < box[0] or box[3] < t[1] or t[3] < box[1] for t in taken):
                break
        taken.append(box)
        axis.annotate(name, axis.transData.inverted().transform((x, y)), xytext=(7 * side, shift),
                      textcoords="offset points", ha="left" if side > 0 else "right", va="center", fontsize=6.5,
                      path_effects=[patheffects.withStroke(linewidth=2.5, foreground="white")],
                      arrowprops={"arrowstyle": "-", "lw": 0.4, "color": "0.6", "shrinkA": 0} if shift else None)


def limits(words):
    """{"error_EF": 2.0} of ["EF=2%"]."""
    result = {}
    for word in words:
        match = re.fullmatch(r"(\w+)=([0-9.eE+-]+)\s*%?", word)
        if not match or match[1] not in SHORT:
            raise StudyError(f"--tolerance {word}: write for instance EF=2%; known: {', '.join(SHORT)}")
        result[SHORT[match[1]]] = float(match[2])
    if not result:
        raise StudyError("--tolerance: which errors may be? For instance --tolerance EF=2% p_max=3%")
    return result


def cheapest(rows, allowed):
    """The cheapest row within all limits, or None. Of those that cost as much, as far as can be told, the most accurate."""
    good = [row for row in rows if all(row.get(error, np.inf) <= limit for error, limit in allowed.items())]
    if not good:
        return None
    least = min(good, key=lambda row: row[COST])
    as_cheap = [row for row in good if row.get("cost_min_s", row[COST]) <= max(least.get("cost_max_s", 0), (1 + NOISE) * least[COST])]
    return min(as_cheap, key=lambda row: sum(row[error] / limit for error, limit in allowed.items()))


def as_a_user(case, name, defaults):
    """The scene of a case with electrophysiology computed in it, where the case replays what another one has recorded."""
    tree = {**case.tree, "scene": name}
    if case.calcium:
        own = dict(case.calcium.tree.get("electrophysiology", {}))
        n = own.get("substeps", defaults["electrophysiology"]["substeps"])
        if isinstance(n, int):  # the same steps of its own within other steps of the coupling
            own["substeps"] = max(1, round(n * case.step / case.calcium.step))
        tree["electrophysiology"] = own
    return tree


def advise(study, store, table, words, folder):
    """Names the cheapest choice and writes its scene. The exit code."""
    allowed = limits(words)
    need_reference(study, store)
    rows = candidates(study, table)
    for error in allowed:
        if not any(error in row for row in rows):
            known = [name for name, key in SHORT.items() if any(key in row for row in rows)]
            raise StudyError(f"--tolerance {error.removeprefix('error_')}: no finished run has {error}; known are {', '.join(known) or 'none'}")
    floor, unknown = floors(study, store, allowed)
    for error, limit in allowed.items():
        if limit < floor.get(error, 0):
            raise StudyError(f"--tolerance {error.removeprefix('error_')}={limit:g}: the reference '{study.reference}' is itself "
                             f"off by about {floor[error]:.2g}; ask for more than that, or give the study a finer reference")
    if unknown:
        print(f"The reference's own error is known in part only: {', '.join(unknown)} not finished.")
    best = cheapest(rows, allowed)
    if best is None:
        print(f"None of {len(rows)} finished runs meets {' '.join(words)}.")
        for error in allowed:
            closest = min((row for row in rows if error in row), key=lambda row: row[error], default=None)
            if closest:
                print(f"Closest in {error}: {closest['run']} with {closest[error]:.3g}")
        return 1
    scene = folder / "advised.yaml"
    tree = as_a_user(study.case(study.by_name[best["run"]]), best["run"], study.keys.defaults)
    scene.write_text(f"# The cheapest of {len(rows)} choices of the study {study.name} with {' '.join(words)}\n"
                     + yaml.safe_dump(tree, sort_keys=False))
    print(f"{best['run']}: {best[COST]:.1f} CPU s, {best.get('start_s', 0):.1f} of them to start{share_of_reference(study, table, best)}, "
          + ", ".join(f"{error} {best[error]:.3g}" + (f" (± {floor[error]:.1g})" if error in floor else "") for error in allowed))
    print(f"./run {scene}")
    return 0


def share_of_reference(study, table, row):
    exact = next((other for other in table if other["run"] == study.reference and other.get(COST)), None)
    return f", {row[COST] / exact[COST]:.2g} times the reference's" if exact else ""
