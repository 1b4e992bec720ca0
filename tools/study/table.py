"""The table of a study: one row for each run, done or not, and the paper's rows beside."""
import csv

from .measures import USUAL, measures


def rows(study, store):
    """[{"run", "state", axes, numbers, "reason"}] of all runs, with what is known of each."""
    result = []
    for run in study.runs:
        case = study.case(run)
        row = {"run": run.name, "state": store.state(case), **run.parts}
        if row["state"] == "done":
            row.update(measures(store.of(case), *comparison(study, store, run)))
        elif row["state"] == "failed":
            row["reason"] = store.reason(case)
        result.append(row)
    return result


def comparison(study, store, run):
    """(folder of the reference, time at which the run has started from another's state)."""
    reference = study.reference_of(run)
    if reference is None or reference is run or store.state(study.case(reference)) != "done":
        return None, None
    return store.of(study.case(reference)), store.note(study.case(run)).get("start")


def paper_rows(study):
    return [{"run": f"paper: {name}", "state": "published", **numbers} for name, numbers in study.paper.items()]


def columns(study, table):
    known = {key for row in table for key, value in row.items() if isinstance(value, (int, float))}
    first = ["run", "state", *dict.fromkeys(axis for run in study.runs for axis in run.parts)]
    return first, [key for key in (study.measure or USUAL) if key in known], sorted(known)


def write(study, table, folder):
    """table.csv with all numbers, table.md with the study's measures."""
    first, shown, known = columns(study, table)
    every = first + shown + [key for key in known if key not in shown] + ["reason"]
    aside = folder / "table.csv.part"
    with open(aside, "w", newline="") as file:
        writer = csv.DictWriter(file, every, restval="", extrasaction="ignore")
        writer.writeheader()
        writer.writerows(table + paper_rows(study))
    aside.rename(folder / "table.csv")
    (folder / "table.md").write_text(markdown(table + paper_rows(study), ["run", *shown]))


def markdown(table, keys):
    lines = ["| " + " | ".join(keys) + " |", "|" + "---|" * len(keys)]
    for row in table:
        cells = [shown(row.get(key, "")) for key in keys]
        if row["state"] not in ("done", "published"):
            cells[0] += f" ({row['state']})"
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def shown(value):
    return f"{value:.4g}" if isinstance(value, float) else str(value)
