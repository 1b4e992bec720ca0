#!/usr/bin/python3
"""Runs studies: many variations of a scene, their table and figures.

    tools/study.py run configs/studies/b3_schemes.yaml         # what is done already is not computed again
    tools/study.py plot configs/studies/b3_schemes.yaml        # table and figures of what is there
    tools/study.py pareto configs/studies/pareto.yaml          # cost against error
    tools/study.py advise configs/studies/pareto.yaml --tolerance EF=2% p_max=3%
    tools/study.py stability configs/studies/stability_piston.yaml
    tools/study.py budget configs/ideal_lv/efs1.yaml --of EF p_max           # what contributes what to the error of a scene

Results: results/studies/<study>/ of this folder with table.csv, table.md, figures, and runs/<name>, links to results/studies/runs/, which
all studies share. Exit code: 0, 1 when something is missing (it is said what), 2 when the study is wrong.
"""
import argparse
import fnmatch
import os
import sys
from pathlib import Path

from study import border, budget, figures, pareto, table
from study.launch import defaults
from study.plan import Study
from study.schedule import Schedule
from study.scene import StudyError
from study.store import Store


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", choices=["run", "plot", "pareto", "advise", "stability", "budget"])
    parser.add_argument("study", type=Path, help="study file (tools/study/plan.py says what is in it); of budget: a scene")
    parser.add_argument("--jobs", type=int, help="runs side by side; default: cores / ranks")
    parser.add_argument("--ranks", type=int, help="MPI processes of each participant")
    parser.add_argument("--base", type=Path, help="another scene than the study's")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="settings",
                        help="laid over the base of all runs")
    parser.add_argument("--only", nargs="+", default=["*"], metavar="NAME", help="these runs only; * and ? as in a shell")
    parser.add_argument("--retry", action="store_true", help="repeats runs that have failed")
    parser.add_argument("--tolerance", nargs="+", default=[], metavar="EF=2%", help="of advise: errors that may be")
    parser.add_argument("--of", nargs="+", default=[], metavar="NAME", help="of budget: EF p_max V p activation")
    parser.add_argument("--name", help="of the folder of table and figures; default: the study file's")
    parser.add_argument("--out", type=Path, default=Path("results/studies"), help="folder of all studies")
    return parser.parse_args()


def run(study, store, schedule, options):
    """Computes what is missing."""
    chosen = [run for run in study.runs if any(fnmatch.fnmatch(run.name, name) for name in options.only)]
    if not chosen:
        raise StudyError(f"--only {' '.join(options.only)}: no such run in {study.file}")
    if options.retry:
        for case in [case for run in chosen for case in study.repetitions(run)]:
            for each in (case, *case.needs):
                store.retry(each)
    for each in chosen:
        for k, case in enumerate(study.repetitions(each)):
            schedule.add(case, each.name + (f", repetition {k}" if k else ""))
    print(f"{study.name}: {len(chosen)} runs, {len(schedule.waiting)} to be computed, {schedule.jobs} side by side")
    schedule.work()
    return chosen


def tell(study, store, schedule, chosen, folder):
    """Table and figures of what is there; what is missing. The exit code."""
    for each in study.runs:
        store.link(study.case(each), each.name, folder / "runs")
    rows = table.rows(study, store)
    table.write(study, rows, folder)
    figures.draw_all(study, store, rows, folder)
    print((folder / "table.md").read_text(), end="")
    print(f"{folder}/table.csv")
    names = {run.name for run in chosen}
    missing = [row for row in rows if row["run"] in names and row["state"] != "done"]
    for row in missing:
        print(f"{row['state']}: {row['run']} {row.get('reason', '')}", file=sys.stderr)
    for lack in table.lacks(study, store):
        print(lack, file=sys.stderr)
    if schedule.obstacle:
        print(f"stopped: {schedule.obstacle}; the same command goes on", file=sys.stderr)
    return 1 if missing else 0


def workplace(study, options, known):
    """(store, schedule, folder of the results)."""
    study.name = options.name or study.name
    folder = options.out.resolve() / study.name
    folder.mkdir(parents=True, exist_ok=True)
    store = Store(options.out / "runs", known)
    return store, Schedule(store, options.jobs or max(1, len(os.sched_getaffinity(0)) // study.ranks)), folder


def perform(options):
    known = defaults()
    if options.command == "budget":
        return budget.explore(options, known, lambda study: workplace(study, options, known), run)
    study = Study(options.study, known, options.base, options.settings, options.ranks)
    store, schedule, folder = workplace(study, options, known)
    if options.command == "pareto":
        return pareto.draw(study, store, table.rows(study, store), folder)
    if options.command == "advise":
        return pareto.advise(study, store, table.rows(study, store), options.tolerance, folder)
    if study.border and options.command != "plot":
        return border.explore(study, store, schedule, options, folder)
    if study.border:
        return border.show(study, store, folder)
    chosen = run(study, store, schedule, options) if options.command == "run" else study.runs
    return tell(study, store, schedule, chosen, folder)


def main():
    sys.stdout.reconfigure(line_buffering=True)
    try:
        return perform(arguments())
    except StudyError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"error: {error}; all that is finished is kept, the same command goes on", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
