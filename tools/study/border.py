"""Where a scheme becomes unstable: for each combination of a study, the value of one key beyond which blood and wall
disagree by more and more from step to step.

    border:
      key: alpha                       # what is varied
      unit: kg/(m^2 s)
      values: [4000, 16000, 64000]     # looked at in any case; refined between the last stable and the first unstable one
      precision: 0.02                  # the border is bracketed by values closer than this share, then interpolated
      column: volume_defect            # of history.csv, whose growth is fitted over the last three quarters of the run;
                                       # 'disagreement' when left out, which sees local motions as well
      closed_form: [impedance]         # curves drawn beside: see closed_forms.py
      x: step                          # axis of the study that is the map's abscissa, logarithmic with log_x: true

Each value is a run of its own, in the store as all runs are. It is *stable* when the disagreement decays, *growing* when
it does not, *failed* when the program has stopped it, which it does when the disagreement gets large.
"""
import csv
import sys

import numpy as np

from results import History

from . import closed_forms
from .figures import log_axis, plt
from .launch import CONVERGENCE, NOT_FINITE
from .scene import StudyError

COLUMNS = ["disagreement", "volume_defect"]  # what tells an instability, the better first
DIRICHLET = 1e8  # kg/(m^2 s): from here on a Robin condition is a Dirichlet condition
COLOURS = {"stable": "#2a9d4e", "growing": "#f0a020", "failed": "#d03030"}


def growth(history, column, n_steps):
    """Logarithmic growth per step, fitted over the last three quarters of the last `n_steps` steps.

    A signed column is split into the part that alternates from step to step and the rest, and the faster one counts. What
XX
    """
    signal = history[column][-n_steps:]
    signal = signal[np.isfinite(signal)]
    if len(signal) < 40:
        return np.nan
    alternating = np.abs(np.diff(signal, 8)) / 256  # each difference doubles what alternates, and shrinks what is smooth
    smooth = np.abs(signal[1:] + signal[:-1]) / 2
    parts = [(signal, 1e-2)] if (signal >= 0).all() else [(alternating, 1e-4), (smooth, 1e-2)]
    first = np.abs(signal[:len(signal) // 4]).max()
    rates = [rate(part) for part, share in parts if part[-20:].max() > share * first]
    return max(rates, default=-1.0)


def rate(part):
    """Slope of the logarithm of the largest of every ten."""
    used = 3 * len(part) // 4
    largest = np.array([some.max() for some in np.array_split(part[-used:], used // 10)])
    return float(np.polyfit(np.arange(largest.size), np.log(np.maximum(largest, 1e-300)), 1)[0]) / 10


class Search:
    """The border of one combination: probes queued, their outcomes collected, more of them where it is in between."""

    def __init__(self, study, store, schedule, run, retry=False):
        self.study, self.store, self.schedule, self.run, self.retry = study, store, schedule, run, retry
        self.points = {}  # value -> (state, growth)
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
            self.points[value] = ("failed", np.nan)
        elif state == "failed":
            print(f"{probed.name}: {self.store.reason(case)}", file=sys.stderr)
        elif state == "done":
            history = History(self.store.of(case))
            column = self.study.border.get("column") or next(name for name in COLUMNS if name in history)
            if column not in history:
                raise StudyError(f"{self.study.file}: border.column: history.csv of {probed.name} has no '{column}'")
            rate = growth(history, column, case.n_steps)
            self.points[value] = ("growing" if rate > 0 else "stable", rate)
        if not self.pending and state != "missing":
            self.refine()

    def bracket(self):
        """(last stable value below all others, first other), either may be None."""
        stable, other = None, None
        for value in sorted(self.points):
            if self.points[value][0] != "stable":
                other = value
                break
            stable = value
        return stable, other

    def refine(self):
        low, high = self.bracket()
        if low and high and high / low > 1 + self.study.border.get("precision", 0.02):
            self.probe(float(f"{np.sqrt(low * high):.4g}"))

    def border(self):
        """The value at which growth is zero, between the bracket's ends; None when there is no border among the values."""
        low, high = self.bracket()
        if not (low and high):
            return None
        rates = self.points[low][1], self.points[high][1]
        share = rates[0] / (rates[0] - rates[1]) if np.isfinite(rates[1]) and rates[1] > rates[0] else 0.5
        return low * (high / low) ** share

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
                     "stable": low or "", "unstable": high or "", "border": search.border() or "",
                     **search.closed_forms()})
        if search.pending or not search.points:
            missing.append(search.run.name)
    put(folder / "table.csv", rows)
    put(folder / "points.csv", [{"run": search.run.name, **search.run.parts, "value": value, "state": state, "growth": rate}
                                for search in searches for value, (state, rate) in sorted(search.points.items())])
    for row in rows:
        print("  ".join(f"{key} {value:.5g}" if isinstance(value, float) else f"{key} {value}"
                        for key, value in row.items() if value != ""))
    if any(search.points for search in searches):
        draw(study, searches, folder / f"{study.name}.png")
    for search in searches:
        if not search.pending and search.points and not search.border():
            print(f"{search.run.name}: no border among the values; is there a disturbance that could grow?", file=sys.stderr)
    if missing:
        print("missing: " + ", ".join(missing), file=sys.stderr)
    return 1 if missing else 0


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
        axis.set_yscale("log")
        axis.set_ylim(min(values) / 1.5, 1.6 * top)
    for axis in axes[-1]:
        axis.set_xlabel(study.border.get("x_label", study.border.get("x", "")))
    for axis in axes[:, 0]:
        axis.set_ylabel(f"{study.border['key']} [{study.border.get('unit', '')}]")
    for unused in axes.ravel()[len(groups):]:
        unused.set_visible(False)
    handles = dict(zip(*reversed([sum(entries, []) for entries in zip(*(a.get_legend_handles_labels()
                                                                        for a in axes.ravel()))])))
    drawing.legend(handles.values(), handles.keys(), fontsize=8, loc="lower center", ncols=len(handles))
    drawing.suptitle(study.about, fontsize=12)
    drawing.tight_layout(rect=(0, 0.06, 1, 1))
    drawing.savefig(path)
    plt.close(drawing)
    print(path)


def draw_map(axis, study, searches, top):
    def x(search):
        return search.run.values.get(study.border.get("x"), 0)

    searches = sorted(searches, key=x)
    if study.border.get("log_x"):
        log_axis(axis, [x(search) for search in searches])
    for state, colour in COLOURS.items():
        points = [(x(search), min(value, top)) for search in searches for value, (found, _) in search.points.items()
                  if found == state]
        if points:
            axis.plot(*zip(*points), "x" if state == "failed" else "o", color=colour, ms=4, alpha=0.8, label=state)
    if any(value > DIRICHLET for search in searches for value in search.points):
        axis.axhline(top, color="0.8", lw=0.8, zorder=0)
        axis.annotate("Dirichlet-Neumann", (0.02, top), xycoords=("axes fraction", "data"), fontsize=7, color="0.4",
                      xytext=(0, 4), textcoords="offset points")
    borders = [(x(search), search.border()) for search in searches if search.border()]
    if borders:
        axis.plot(*zip(*borders), "k-", lw=1.4, label="border measured")
    for i, form in enumerate(dict.fromkeys(form for search in searches for form in search.closed_forms())):
        curve = [(x(search), search.predicted[form]) for search in searches if form in search.predicted]
        axis.plot(*zip(*curve), ("--", ":")[i % 2], color=("C0", "C4")[i % 2], label=closed_forms.NAMES[form])
