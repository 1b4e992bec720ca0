"""Cost against error of the runs of a study: which choices no other beats in both, and the cheapest that is good enough."""
import csv
import re

import numpy as np
import yaml

from .figures import label, plt, save
from .scene import StudyError

COST = "cpu_s"  # of the whole run: a heartbeat
SHORT = {name: f"error_{name}" for name in ("EF", "p_max", "ILI_C", "ILI_R", "V", "p")}


def candidates(study, table):
    """Rows that have a cost and an error: finished runs with a reference that is not themselves."""
    return [row for row in table if row["state"] == "done" and "error_V" in row and row.get(COST, 0) > 0]


def front(points):
    """Whether each (cost, error) is beaten by no other point in both."""
    return [not any(c <= cost and e <= error and (c, e) != (cost, error) for c, e in points) for cost, error in points]


def draw(study, table, folder):
    """pareto_<error>.png for each error, pareto.csv. The exit code."""
    rows = candidates(study, table)
    if not rows:
        raise StudyError(f"{study.name}: no finished run with a reference yet: run the study first")
    errors = study.pareto.get("errors", ["error_EF", "error_p_max", "error_V", "error_p"])
    for error in errors:
        known = [row for row in rows if error in row]
        for row, best in zip(known, front([(row[COST], row[error]) for row in known])):
            row[f"front_{error}"] = int(best)
        chart(study, known, error, folder / f"pareto_{error.removeprefix('error_')}.png")
    keys = ["run", COST, *[key for error in errors for key in (error, f"front_{error}")]]
    with open(folder / "pareto.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, keys, restval="", extrasaction="ignore")
        writer.writeheader()
        writer.writerows(sorted(rows, key=lambda row: row[COST]))
    missing = [row["run"] for row in table if row["state"] != "done"]
    print(f"{folder}/pareto.csv: {len(rows)} choices" + (f"; missing: {', '.join(missing)}" if missing else ""))
    return 1 if missing else 0


def chart(study, rows, error, path):
    drawing, axis = plt.subplots(figsize=(12, 8))
    axis.set_xscale("log")
    axis.set_yscale("log")
    floor = min([row[error] for row in rows if row[error] > 0], default=1e-12)
    schemes = list(dict.fromkeys(row.get("scheme", row["run"]) for row in rows))
    for i, scheme in enumerate(schemes):
        own = [row for row in rows if row.get("scheme", row["run"]) == scheme]
        axis.plot([row[COST] for row in own], [max(row[error], floor) for row in own], "o", color=f"C{i % 10}", ms=6,
                  label=scheme)
    best = sorted((row[COST], max(row[error], floor)) for row in rows if row[f"front_{error}"])
    axis.step(*zip(*best), where="post", color="0.4", lw=1, label="front")
    axis.plot(*zip(*best), "o", mfc="none", color="black", ms=11)
    axis.margins(0.12)
    put_labels(drawing, axis, [(row[COST], max(row[error], floor), row["run"]) for row in rows])
    axis.set_xlabel("cost of the run [CPU s]")
    axis.set_ylabel(label(error) + f" against {study.reference}")
    axis.legend(fontsize=8, loc="best")
    save(drawing, path, study.about)


def put_labels(drawing, axis, points):
    """Names beside their points, each in the first of some places where it covers no other name and no point."""
    drawing.canvas.draw()
    pixels = axis.transData.transform([point[:2] for point in points])
    taken = [(x - 4, y - 4, x + 4, y + 4) for x, y in pixels]
    unit = drawing.dpi / 72
    for (x, y), (*_, name) in sorted(zip(pixels, points), key=lambda entry: -entry[0][1]):
        width, height = 3.9 * len(name) * unit, 8 * unit
        places = [(side, shift) for shift in sorted(range(-120, 121, 8), key=abs) for side in (1, -1)]
        for side, shift in places:
            left = x + 7 * unit if side > 0 else x - 7 * unit - width
            box = (left, y + shift * unit - height / 2, left + width, y + shift * unit + height / 2)
            if all(box[2] < t[0] or t[2] < box[0] or box[3] < t[1] or t[3] < box[1] for t in taken):
                break
        taken.append(box)
        axis.annotate(name, axis.transData.inverted().transform((x, y)), xytext=(7 * side, shift),
                      textcoords="offset points", ha="left" if side > 0 else "right", va="center", fontsize=6.5,
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
    """The cheapest row within all limits, or None."""
    good = [row for row in rows if all(row.get(error, np.inf) <= limit for error, limit in allowed.items())]
    return min(good, key=lambda row: row[COST], default=None)


def advise(study, table, words, folder):
    """Names the cheapest choice and writes its scene. The exit code."""
    allowed, rows = limits(words), candidates(study, table)
    best = cheapest(rows, allowed)
    if best is None:
        print(f"None of {len(rows)} finished runs meets {' '.join(words)}.")
        for error in allowed:
            closest = min((row for row in rows if error in row), key=lambda row: row[error], default=None)
            if closest:
                print(f"Closest in {error}: {closest['run']} with {closest[error]:.3g}")
        return 1
    scene = folder / "advised.yaml"
    tree = {**study.case(study.by_name[best["run"]]).tree, "scene": best["run"]}
    scene.write_text(f"# The cheapest of {len(rows)} choices of the study {study.name} with {' '.join(words)}\n"
                     + yaml.safe_dump(tree, sort_keys=False))
    print(f"{best['run']}: {best[COST]:.1f} CPU s, " + ", ".join(f"{error} {best[error]:.3g}" for error in allowed))
    print(f"./run {scene}")
    return 0
