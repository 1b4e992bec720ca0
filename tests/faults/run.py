"""Tries all faults on all participants; writes the table of docs/reliability.md.

What came of each is kept in build/faults.json: cells that are tried again, with --only, replace theirs in the table."""
import argparse
import json
import re
import sys
import textwrap
import time
from dataclasses import asdict

from casts import SOURCE, Casts
from faults import FAULTS, PARTICIPANTS
from trial import Outcome, Trial

DOCUMENT, STORE = SOURCE / "docs/reliability.md", SOURCE / "build/faults.json"
BEGIN, END = "<!-- faults: begin, written by tests/faults/run --write -->", "<!-- faults: end -->"


def cell(outcome):
    text = f"{outcome.code}, {outcome.seconds:.1f}"
    return f"**{text}: {', '.join(outcome.complaints())}**" if outcome.complaints() else text


def kept():
    return {key: Outcome(**entry) for key, entry in json.loads(STORE.read_text()).items()} if STORE.exists() else {}


def keep(outcome):
    known = {**kept(), f"{outcome.fault}, {outcome.participant}": outcome}
    STORE.parent.mkdir(exist_ok=True)
    STORE.write_text(json.dumps({key: asdict(entry) for key, entry in known.items()}, indent=1))


def table(outcomes):
    """`outcomes`: by "fault, participant"."""
    notes, rows, made = [], [], []
    for fault in FAULTS:
        row = []
        for participant in PARTICIPANTS:
            outcome, note = outcomes.get(f"{fault.name}, {participant}"), fault.absent.get(participant)
            if note and note not in notes:
                notes.append(note)
            if outcome and not note:
                made.append(outcome)
            row.append(f"n/a ({notes.index(note) + 1})" if note else cell(outcome) if outcome else "not tried")
        rows.append(f"| {fault.name} | " + " | ".join(row) + " |")
    head = ["| | " + " | ".join(PARTICIPANTS) + " |", "|---" * (len(PARTICIPANTS) + 1) + "|"]
    summary = (f"{len(made)} runs; the exit code is one of those expected in {sum(o.expected for o in made)}, the culprit is named in "
               f"{sum(o.named for o in made)}, processes are left by {sum(o.orphans > 0 for o in made)}, the last checkpoint restarts "
               f"in {sum(o.restarts for o in made)}. {time.strftime('%Y-%m-%d')}.")
    return "\n".join([*head, *rows, "", textwrap.fill(summary, 108), "", "| n/a | because |", "|---|---|",
                      *(f"| ({k}) | {note} |" for k, note in enumerate(notes, 1))])


def write(text):
    document = DOCUMENT.read_text()
    before, rest = document.split(BEGIN)
    DOCUMENT.write_text(before + BEGIN + "\n" + text + "\n" + END + rest.split(END)[1])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="puts the table into docs/reliability.md")
    parser.add_argument("--only", default="", help="cells whose 'fault, participant' match this expression")
    options = parser.parse_args()
    casts, faults = Casts(), 0
    for fault in FAULTS:
        for participant in PARTICIPANTS:
            key = f"{fault.name}, {participant}"
            if participant in fault.absent or not re.search(options.only, key):
                continue
            outcome = fault.run(Trial(casts, participant))
            keep(outcome)
            print(f"{key}: {cell(outcome)}", *outcome.causes[:2], sep="\n    ", flush=True)
            if outcome.complaints():
                faults += 1
                print("\n".join("    | " + line for line in outcome.output.splitlines()[-8:]), flush=True)
    if options.write:
        write(table(kept()))
    print(f"{faults} cells are not as they must be")
    return faults > 0


if __name__ == "__main__":
    sys.exit(main())
