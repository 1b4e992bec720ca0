"""Where a scheme becomes unstable: for each combination of a study, the value of one key beyond which blood and wall
disagree by more and more from step to step.

    border:
      key: alpha                       # what is varied
      unit: kg/(m^2 s)
      values: [4000, 16000, 64000]     # looked at in any case; refined between the last stable and the first unstable one
      precision: 0.02                  # the border is bracketed by values closer than this share
      column: volume_defect            # of history.csv, whose growth is fitted as growth.py says; 'disagreement' when left
                                       # out, which sees local motions as well
      closed_form: [impedance]         # curves drawn beside: see closed_forms.py
      x: step                          # axis of the study that is the map's abscissa, logarithmic with log_x: true

Each value is a run of its own, in the store as all runs are. It is *stable* when the disagreement decays, *growing* when
it grows, *failed* when the program has stopped it, which it does when the disagreement gets large, *undecided* when the fit
cannot tell. The border lies between the largest stable value below all others and the smallest growing or failed one: that
is its bracket. Where both ends have a rate, the border is where the rate between them is zero, else their geometric mean,
and its uncertainty reaches to the farther end of the bracket; more digits than that leaves are not printed.
"""
import csv
import sys

import numpy as np

from reporting import style
from results import History

from . import closed_forms
from .figures import log_axis, log_ordinate, plt, save
from .growth import digits, growth
from .launch import CONVERGENCE, NOT_FINITE
from .scene import StudyError

COLUMNS = ["disagreement", "volume_defect"]  # what tells an instability, the better first
DIRICHLET = 1e8  # kg/(m^2 s): from here on a Robin condition is a Dirichlet condition
COLOURS = {"stable": style.PALETTE[2], "growing": style.PALETTE[4], "failed": style.PALETTE[1], "undecided": style.PALETTE[7]}


class Search:
    """The border of one combination: probes queued, their outcomes collected, more of them where it is in between."""

    def __init__(self, study, store, schedule, run, retry=False):
        self.study, self.store, self.schedule, self.run, self.retry = study, store, schedule, run, retry
        self.points = {}  # value -> (state, growth's rate per step, its standard deviation)
        self.pending = set()
        self.predicted = {}
        for value in study.border["values"]:
            self.probe(float(value))
        if "impedance" in self.forms:
            self.auto = study.varied(run, "coupling.alpha", "auto", "auto")
            self.auto.own = {**run.own, "steps": 1}
            self.queue(self.auto, lambda state: self.note_limit(state))

    @property
    def forms(self):
        forms = self.study.border.get("closed_form", [])
        return [forms] if isinstance(forms, str) else forms

    def queue(self, run, then):
        """To be computed, or looked up only when there is no schedule."""
        case = self.study.case(run)
        for each in (case, *case.needs) if self.retry else ():
            if not self.is_unstable(each):
                self.store.retry(each)
        if self.schedule:
            self.schedule.add(case, run.name, then)
        else:
            then(self.store.state(case))

    def probe(self, value):
        border = self.study.border
        probed = self.study.varied(self.run, border["key"], f"{value:g} {border.get('unit', '')}".strip(), f"{value:g}")
        self.pending.add(value)
        self.queue(probed, lambda state: self.note(value, probed, state))

    def is_unstable(self, case):
        """Whether it has failed as an unstable coupling does: recognised, without convergence, with inverted cells."""
        return any(self.store.reason(case).startswith(f"exit code {code}:") for code in (CONVERGENCE, NOT_FINITE))

    def note(self, value, probed, state):
        self.pending.discard(value)
        case = self.study.case(probed)
        if state == "failed" and self.is_unstable(case):
            self.points[value] = ("failed", np.nan, np.nan)
        elif state == "failed":
            print(f"{probed.name}: {self.store.reason(case)}", file=sys.stderr)
            return  # it says nothing about stability: no more of it
        elif state == "done":
            history = History(self.store.of(case))
            column = self.study.border.get("column") or next(name for name in COLUMNS if name in history)
            if column not in history:
                raise StudyError(f"{self.study.file}: border.column: history.csv of {probed.name} has no '{column}'")
            found = growth(history[column][-case.n_steps:])
            self.points[value] = (found.state, found.rate, found.deviation)
        if not self.pending and state != "missing":
            self.refine()

    def bracket(self):
        """(largest stable value below all unstable ones, smallest unstable one), either may be None."""
        unstable = [value for value, point in self.points.items() if point[0] in ("growing", "failed")]
        high = min(unstable, default=None)
        stable = [value for value, point in self.points.items() if point[0] == "stable" and (high is None or value < high)]
        return max(stable, default=None), high

    def refine(self):
        """Halves the bracket, in its wider part when it has undecided values in it."""
        low, high = self.bracket()
        if not (low and high):
            return
        known = sorted({low, high, *(value for value in self.points if low < value < high)})
        below, above = max(zip(known, known[1:]), key=lambda pair: pair[1] / pair[0])
        if len(known) > 2:  # what is undecided in the middle does not get decided by more of it: only the ends move
            below, above = max((known[:2], known[-2:]), key=lambda pair: pair[1] / pair[0])
        if above / below > 1 + self.study.border.get("precision", 0.02):
            self.probe(float(f"{np.sqrt(below * above):.4g}"))

    def border(self):
        """(value, uncertainty) of the border, None when there is none among the values."""
        low, high = self.bracket()
        if not (low and high):
            return None
        below, above = self.points[low][1], self.points[high][1]
        fitted = np.isfinite([below, above]).all() and above > below
        value = low * (high / low)**(-below / (above - below) if fitted else 0.5)
        return value, max(value - low, high - value)

    def note_limit(self, state):
        if state == "done":
            self.predicted["impedance"] = History(self.store.of(self.study.case(self.auto)))["alpha"][-1] / 0.8

    def closed_forms(self):
        tree = self.study.case(self.run).tree
        for name in self.forms:
            if name != "impedance":
                value = closed_forms.FORMS[name](tree, self.study.keys.defaults)
                if value is not None:
                    self.predicted[name] = value
        return self.predicted


def explore(study, store, schedule, options, folder):
    """Computes what the map needs, draws it. The exit code."""
    searches = [Search(study, store, schedule, run, options.retry) for run in probed_runs(study)]
    print(f"{study.name}: {len(searches)} borders, {schedule.jobs} runs side by side")
    schedule.work()
    if schedule.obstacle:
        print(f"stopped: {schedule.obstacle}; the same command goes on", file=sys.stderr)
    return write(study, searches, folder)


def show(study, store, folder):
    """Map and table of what is there."""
    return write(study, [Search(study, store, None, run) for run in probed_runs(study)], folder)


def probed_runs(study):
    """The combinations; runs of `also` are what they start from."""
    return [run for run in study.runs if run.parts]


def write(study, searches, folder):
    rows, missing = [], []
    for search in searches:
        low, high = search.bracket()
        rows.append({"run": search.run.name, **search.run.parts, "x": search.run.values.get(study.border.get("x"), ""),
                     "stable": low or "", "unstable": high or "", **told(search), **search.closed_forms()})
        if search.pending or not search.points:
            missing.append(search.run.name)
    put(folder / "table.csv", rows)
    put(folder / "points.csv", [{"run": search.run.name, **search.run.parts, "value": value, "state": state, "growth": rate,
                                 "deviation": deviation}
                                for search in searches for value, (state, rate, deviation) in sorted(search.points.items())])
    for row in rows:
        print("  ".join(f"{key} {value:.4g}" if isinstance(value, float) else f"{key} {value}"
                        for key, value in row.items() if value != "" and key not in ("border", "uncertainty")))
    if any(search.points for search in searches):
        draw(study, searches, folder / f"{study.name}.png")
    for search in searches:
        if not search.pending and search.points and not search.border():
            print(f"{search.run.name}: no border among the values; is there a disturbance that could grow?", file=sys.stderr)
    if missing:
        print("missing: " + ", ".join(missing), file=sys.stderr)
    return 1 if missing else 0


def told(search):
    """The border's columns of the table: numbers, and as it may be printed."""
    found = search.border()
    if not found:
        return {"border": "", "uncertainty": "", "measured": ""}
    return {"border": found[0], "uncertainty": found[1], "measured": digits(*found)}


def put(path, rows):
    keys = list(dict.fromkeys(key for row in rows for key in row))
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, keys, restval="")
        writer.writeheader()
        writer.writerows(rows)
    print(path)


def draw(study, searches, path):
    """One panel for each combination of the axes that are not the abscissa."""
    groups = {}
    for search in searches:
        name = ", ".join(part for axis, part in search.run.parts.items() if axis != study.border.get("x"))
        groups.setdefault(name or study.name, []).append(search)
    columns = min(3, len(groups))
    drawing, axes = plt.subplots(-(-len(groups) // columns), columns, squeeze=False, sharey=True, sharex=True,
                                 figsize=(max(8, 1 + 3.6 * columns), 0.8 + 3.6 * -(-len(groups) // columns)))
    values = [value for search in searches for value in search.points if value < DIRICHLET]
    dirichlet = any(value >= DIRICHLET for search in searches for value in search.points)
    top = 3 * max(values) if dirichlet else max(values)
    for axis, (name, members) in zip(axes.ravel(), groups.items()):
        draw_map(axis, study, members, top)
        axis.set_title(name, fontsize=10)
        axis.set_ylim(min(values) / 1.5, 1.6 * top)
        log_ordinate(axis)
    for axis in axes[-1]:
        axis.set_xlabel(style.pretty(study.border.get("x_label", study.border.get("x", ""))))
    for axis in axes[:, 0]:
        axis.set_ylabel(f"{study.border['key']} [{style.pretty(study.border.get('unit', ''))}]")
    for unused in axes.ravel()[len(groups):]:
        unused.set_visible(False)
    handles = dict(zip(*reversed([sum(entries, []) for entries in zip(*(a.get_legend_handles_labels()
                                                                        for a in axes.ravel()))])))
    drawing.legend(handles.values(), handles.keys(), fontsize=8, loc="upper center", bbox_to_anchor=(0.5, 0.0),
                   ncols=3)
    save(drawing, path, study.about)


def draw_map(axis, study, searches, top):
    def x(search):
        return search.run.values.get(study.border.get("x"), 0)

    searches = sorted(searches, key=x)
    if study.border.get("log_x"):
        log_axis(axis, [x(search) for search in searches])
    for state, colour in COLOURS.items():
        points = [(x(search), min(value, top)) for search in searches for value, (found, *_) in search.points.items()
                  if found == state]
        if points:
            axis.plot(*zip(*points), "x" if state == "failed" else "o", color=colour, ms=4, alpha=0.8, label=state)
    if any(value > DIRICHLET for search in searches for value in search.points):
        axis.axhline(top, color="0.8", lw=0.8, zorder=0)
        axis.annotate("Dirichlet-Neumann", (0.02, top), xycoords=("axes fraction", "data"), fontsize=7, color="0.4",
                      xytext=(0, 4), textcoords="offset points")
    borders = [(x(search), search.border()) for search in searches if search.border()]
    if borders:
        at, measured, uncertainty = zip(*[(x, *border) for x, border in borders])
        axis.errorbar(at, measured, uncertainty, fmt="k-", lw=1.4, elinewidth=1, capsize=2, label="border measured")
    for i, form in enumerate(dict.fromkeys(form for search in searches for form in search.closed_forms())):
        curve = [(x(search), search.predicted[form]) for search in searches if form in search.predicted]
        axis.plot(*zip(*curve), ("--", ":")[i % 2], color=("C0", "C4")[i % 2], label=closed_forms.NAMES[form])
