"""A study file: which runs with which settings, what is measured and drawn.

    base: ../ideal_lv/efs1.yaml        # scene that all runs start from
    settings: {time.end: 0.8 s}        # of all runs; keys may be shortened as for --set
    calcium: replay                    # electrophysiology once for each mesh and step, replayed after; or settings of
                                       # what is recorded, {time.step: 0.2 ms, substeps: 8}: one for all steps, which is
                                       # linear in time between what was recorded
    ranks: 1                           # of each participant
    vary:                              # every combination is a run, named after its parts; or a list of such tables
      scheme: {EFS1: {scheme: EFS1}, E1FS2: {scheme: E1FS, iterations: 2}}
      alpha: {a2500: {alpha: 2500 kg/(m^2 s)}, a5000: {alpha: 5000 kg/(m^2 s)}}
    also: {E1FSinf: {...}}             # single runs besides
    reference: E1FSinf                 # what errors are against; "E1FSinf_{step}": the one with the same step
    paper: {EFS1: {EF_percent: 53.4}}  # numbers drawn and tabled beside those of the run of that name
    measure: [EF_percent, error_V]     # columns of the table; the usual ones, when left out
    figures: {losses: {kind: against, x: alpha, y: [ILI_C_percent]}}
    window: {layer: 10 ms}             # of norms: time after a start in ejection that does not count
    pareto: {errors: [error_EF, error_p_max]}     # and `floor`, see pareto.py
    border: {key: alpha, ...}          # of stability, see border.py

Some settings are no keys of the scene. `from: {run: NAME, time: 90 ms}` starts from the nearest checkpoint of another run,
`from: {run: NAME, phase: ejection, after: 8 ms}` from its state so long after the phase has begun, to which that run is
taken from its last checkpoint before, by steps 20 times shorter (a few ms: runs can be left at each 20th step only); `grid: 0.8 ms` rounds that up to a multiple of all steps. `steps: 200` ends after
so many steps. `repeat: 3` computes a run three times: its costs are medians. `calcium` as above, for a run; the name of a
run is that run's calcium.
"""
import itertools
import re
from dataclasses import dataclass, field, replace
from pathlib import Path

from .case import Case, Start
from .scene import Keys, StudyError, anchored, check_keys, join, lay_over, load, number, quantity, with_bases, with_end

STUDY_KEYS = ["about", "base", "settings", "calcium", "ranks", "vary", "also", "reference", "paper", "measure", "figures",
              "window", "pareto", "border"]
FIGURE_KEYS = {"against": ["kind", "title", "x", "x_label", "y", "by", "log", "fit", "runs"],
               "curves": ["kind", "title", "columns", "from_ms", "until_ms", "runs"],
               "bars": ["kind", "title", "y", "runs"],
               "flow": ["kind", "title", "runs"],
               "potential": ["kind", "title", "runs", "times_ms"]}
WINDOW_KEYS = ["layer"]
PARETO_KEYS = ["errors", "runs", "floor"]
FLOOR_KEYS = ["run", "against", "order", "ratio"]
BORDER_KEYS = ["key", "unit", "values", "precision", "column", "closed_form", "x", "x_label", "log_x"]
OWN_SETTINGS = ["from", "steps", "repeat", "calcium"]
RECORDED = ["geometry", "fibres", "electrophysiology", "time"]  # what calcium depends on


@dataclass
class Run:
    """One run as a study names it; `values` has the first number of each axis, in the unit of the study."""
    name: str
    overlay: dict
    parts: dict = field(default_factory=dict)  # axis -> name of the choice
    values: dict = field(default_factory=dict)
    own: dict = field(default_factory=dict)  # OWN_SETTINGS


class Study:
    """A study file, checked; or the tree of one that some file has led to."""

    def __init__(self, file, defaults, base=None, settings=(), ranks=None, tree=None):
        self.file, self.name = Path(file), Path(file).stem
        tree = tree or load(self.file)
        check_keys(tree, STUDY_KEYS, self.file)
        if not (base or "base" in tree):
            raise StudyError(f"{self.file}: key 'base' is missing: which scene do the runs start from?")
        self.about, self.calcium = tree.get("about", self.name), tree.get("calcium")
        if not (self.calcium in (None, "replay") or isinstance(self.calcium, dict)):
            raise StudyError(f"{self.file}: key 'calcium': write 'replay' or settings of what is recorded, or leave it out")
        self.ranks = ranks or tree.get("ranks", 1)
        self.reference, self.measure, self.paper = tree.get("reference"), tree.get("measure"), tree.get("paper") or {}
        base_tree = with_bases(Path(base).resolve() if base else (self.file.parent / tree["base"]).resolve())
        self.keys = Keys(defaults, base_tree)
        own, common = self.split(tree.get("settings"), "settings")
        self.common = own, {}
        self.base_tree = with_end(lay_over(lay_over(base_tree, common), self.command_line(settings)))
        self.figures = {name: self.checked(figure, f"figures.{name}", FIGURE_KEYS.get(figure.get("kind")))
                        for name, figure in (tree.get("figures") or {}).items()}
        self.pareto = self.checked(tree.get("pareto") or {}, "pareto", PARETO_KEYS)
        self.window = self.checked(tree.get("window") or {}, "window", WINDOW_KEYS)
        self.border = self.checked(tree.get("border") or {}, "border", BORDER_KEYS)
        self.runs = self.all_runs(tree)
        self.by_name = {run.name: run for run in self.runs}
        self.check_names()
        self.cases = {}

    def checked(self, table, where, allowed):
        if allowed is None:
            raise StudyError(f"{self.file}: {where}: key 'kind' is one of {', '.join(FIGURE_KEYS)}")
        check_keys(table, allowed, f"{self.file}: {where}")
        return table

    def check_names(self):
        names = [run.name for run in self.runs]
        for name in names:
            if names.count(name) > 1 or not re.fullmatch(r"[\w.+-]+", name):
                raise StudyError(f"{self.file}: run '{name}': names must differ and be of letters, digits and _ . + -")
        if not names:
            raise StudyError(f"{self.file}: no runs: 'vary' and 'also' are missing")
        if self.reference and "{" not in self.reference and self.reference not in names:
            raise StudyError(f"{self.file}: key 'reference': there is no run '{self.reference}' among {', '.join(names)}")
        for name, entry in self.pareto.get("floor", {}).items():
            self.checked(entry, f"pareto.floor.{name}", FLOOR_KEYS)
            for key in "run", "against":
                if entry.get(key, names[0]) not in names or "run" not in entry:
                    raise StudyError(f"{self.file}: pareto.floor.{name}: there is no run '{entry.get(key)}'")

    def split(self, settings, where):
        """What is for the study itself, and the overlay of the scene."""
        settings = settings or {}
        own = {key: settings[key] for key in OWN_SETTINGS if key in settings}
        rest = {key: value for key, value in settings.items() if key not in own}
        return own, anchored(self.keys.overlay(rest, f"{self.file}: {where}", OWN_SETTINGS), self.file.parent)

    def command_line(self, settings):
        tree = {}
        for setting in settings:
            key, sign, value = setting.partition("=")
            if not sign:
                raise StudyError(f"--set {setting}: write key=value")
            tree = join(tree, anchored(self.keys.overlay({key: value}, f"--set {setting}"), Path.cwd()))
        return tree

    def all_runs(self, tree):
        vary = tree.get("vary") or []
        runs = []
        for table in vary if isinstance(vary, list) else [vary]:
            axes = [[(axis, str(name), own) for name, own in choices.items()] for axis, choices in table.items()]
            runs += [self.run(row) for row in itertools.product(*axes)]
        return runs + [self.run([(None, str(name), own)]) for name, own in (tree.get("also") or {}).items()]

    def run(self, choices):
        """The run of some [(axis, name, settings)]."""
        own, overlay = self.common
        parts, values = {}, {}
        for axis, name, settings in choices:
            its_own, its_overlay = self.split(settings, name)
            own, overlay = {**own, **its_own}, join(overlay, its_overlay)
            for key, value in (settings or {}).items():
                at = value.get("time") if key == "from" else value
                if number(at) is not None:
                    values.setdefault(key, number(at))
                    values.setdefault(axis, number(at))
            parts[axis] = name
        parts.pop(None, None)
        return Run("_".join(name for _, name, _ in choices), overlay, parts, values, own)

    def varied(self, run, key, value, name):
        """The run with one more setting."""
        overlay = join(run.overlay, self.keys.overlay({key: value}, f"{self.file}: border"))
        return Run(f"{run.name}_{name}", overlay, run.parts, run.values, run.own)

    def reference_of(self, run):
        """The run that this one is compared with, if there is one."""
        try:
            return self.by_name.get(self.reference.format(**run.parts)) if self.reference else None
        except KeyError:
            return None

    def case(self, run):
        """What is to be computed for a run."""
        if run.name not in self.cases:
            self.cases[run.name] = None  # until it is known: who needs itself is noticed
            self.cases[run.name] = self.make_case(run)
        if self.cases[run.name] is None:
            raise StudyError(f"{self.file}: run '{run.name}': key 'from': it would start from itself")
        return self.cases[run.name]

    def make_case(self, run):
        tree = with_end(self.base_tree, run.overlay)
        for participant in tree.get("participants", {}).values():
            participant["ranks"] = self.ranks
        return Case(tree, self.calcium_of(run, tree), self.start(run), run.own.get("steps"))

    def repetitions(self, run):
        """The case, and those that repeat it."""
        case = self.case(run)
        return [case] + [replace(case, repetition=k) for k in range(1, int(run.own.get("repeat", 1)))]

    def calcium_of(self, run, tree):
        """What is played in place of electrophysiology, if anything."""
        what = run.own.get("calcium", self.calcium)
        if what is None or "ep" not in tree.get("participants", {}):
            return None
        if isinstance(what, dict):
            where = f"{self.file}: run '{run.name}': calcium"
            return self.recording(lay_over(tree, self.keys.overlay(what, where)))
        if what == "replay":
            return self.recording(tree)
        if what not in self.by_name:
            raise StudyError(f"{self.file}: run '{run.name}': key 'calcium': there is no run '{what}'")
        return self.case(self.by_name[what]).calcium

    def start(self, run):
        where = run.own.get("from")
        if not where:
            return None
        check_keys(where, ["run", "time", "phase", "after", "grid"], f"{self.file}: run '{run.name}': from")
        try:
            source = self.by_name[str(where.get("run")).format(**run.parts)]
        except KeyError as error:
            raise StudyError(f"{self.file}: run '{run.name}': key 'from': there is no run '{where.get('run')}'") from error
        if ("time" in where) == ("phase" in where):
            raise StudyError(f"{self.file}: run '{run.name}': key 'from': write either 'time' or 'phase'")
        if "time" in where:
            return Start(self.case(source), quantity(where["time"]))
        begun = [where["phase"], quantity(where.get("after", 0)), quantity(where.get("grid", 0))]
        case = self.case(source)
        # A run can be left at every 20th step only: 20 times shorter ones end wherever one of its own does.
        silent = lay_over(case.tree, {"time": {"step": f"{case.step / 20:.10g} s"},
                                      "output": {"every": "0 ms", "checkpoint": {"every": "0 ms"}}})
        return Start(Case(silent, case.calcium, Start(case, ["before", *begun]), until=begun), "last")

    def recording(self, tree):
        """Electrophysiology of this scene on a wall that does not contract, since nothing of its motion enters; as long
        as the base, so that runs of several lengths share it."""
        own = {"scene": "calcium", "coupling": None, "output": {"checkpoint": None}, "participants": None,
               "mechanics": {"active": {"model": "none"}}}
        scene = lay_over(tree, own)
        scene["coupling"] = {"scheme": "one_way"}
        scene["participants"] = {"ep": {"program": "ep_solver", "ranks": self.ranks},
                                 "mech": {"program": "mech_solver", "ranks": self.ranks}}
        ends = [tree["time"]["end"], self.base_tree["time"]["end"]]
        scene["time"] = {**tree["time"], "end": max(ends, key=quantity)}
        if round(10e-3 / quantity(tree["time"]["step"]), 6).is_integer():
            scene["output"]["every"] = "10 ms"  # the paper's instants
        return Case(scene, records="calcium", identity={key: scene.get(key) for key in RECORDED})
