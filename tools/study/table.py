"""The table of a study: one row for each run, done or not, and the paper's rows beside."""
import csv

import numpy as np

from .measures import USUAL, activation, common, cost, measures, start_cost, window
from .scene import quantity


def rows(study, store):
    """[{"run", "state", axes, numbers, "reason"}] of all runs, with what is known of each."""
    result, spans = [], windows(study, store)
    for run in study.runs:
        case = study.case(run)
        row = {"run": run.name, "state": store.state(case), **run.parts}
        if row["state"] == "done":
            reference, start = comparison(study, store, run)
            row.update(measures(store.of(case), reference, start, spans.get(start)))
            row.update(of_electrophysiology(study, store, run, reference))
            row.update(costs(store, study.repetitions(run)))
        elif row["state"] == "failed":
            row["reason"] = store.reason(case)
        result.append(row)
    return result


def windows(study, store):
    """{start: (begin, end)} of the norms: the same instants for all runs from the same state."""
    spans = {}
    for run in study.runs:
        reference, start = comparison(study, store, run)
        if reference and store.state(study.case(run)) == "done":
            spans.setdefault(start, []).append(window(store.of(study.case(run)), reference, start))
    return {start: common(some, quantity(study.window.get("layer", 0))) for start, some in spans.items()}


def comparison(study, store, run):
    """(folder of the reference, time at which the run has started from another's state)."""
    reference = study.reference_of(run)
    if reference is None or reference is run or store.state(study.case(reference)) != "done":
        return None, None
    return store.of(study.case(reference)), store.note(study.case(run)).get("start")


def of_electrophysiology(study, store, run, reference):
    """What a run that replays calcium has from elsewhere."""
    own = activation(store, study.case(run))
    exact = activation(store, study.case(study.reference_of(run))) if reference else None
    return {**({"activation_time_ms": own} if own else {}),
            **({"error_activation": abs(own - exact)} if own and exact else {})}


def costs(store, cases):
    """The median of the repetitions, and between what they lie."""
    done = [case for case in cases if store.state(case) == "done"]
    known, starts = [cost(store, case) for case in done], [start_cost(store, case) for case in done]
    spread = {"cost_min_s": min(known), "cost_max_s": max(known)} if len(known) > 1 else {}
    return {"cost_s": float(np.median(known)), "start_s": float(np.median(starts)), "repetitions": len(known), **spread}


def lacks(study, store):
    """What is missing of the references, said once each."""
    found = {}
    for run in study.runs:
        reference = study.reference_of(run)
        if reference and store.state(study.case(reference)) != "done":
            state, reason = store.state(study.case(reference)), store.reason(study.case(reference))
            found[reference.name] = (f"reference '{reference.name}' is {state}{': ' + reason if reason else ''}; the table has "
                                     f"no errors against it, all that is finished is kept; "
                                     f"tools/study.py run {study.file} --only {reference.name}"
                                     f"{' --retry' if state == 'failed' else ''}")
    return list(found.values())


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
