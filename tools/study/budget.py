"""The error budget of a scene: what each of its discretisations contributes to the error, and what it costs.

The scene is run once, and once for each discretisation with that one made finer. With the expected order p and the ratio r
of the two resolutions (2, where a step is halved), their difference is an estimate of the whole error of the scene:

    error = (scene - exact) = (scene - finer) / (1 - r^-p)                   (Richardson 1911, doi:10.1098/rsta.1911.0009)

Coarser neighbours show what is finer than needed: r^p - 1 times the same error. The wall's calcium does not depend on blood,
scheme, coupling step or tolerances: it is computed once and replayed, linear in time between its instants, so that the
coupling step varies alone. Costs are CPU seconds of a run that computes its electrophysiology itself.
"""
import csv
from dataclasses import dataclass

import numpy as np

from results import indicators

from . import measures
from .figures import plt, save
from .plan import Study
from .scene import StudyError, lay_over, number, quantity
from .table import costs, markdown

# Next finer mesh and the change of electrophysiology's refinements that keeps its edges about as long.
FINER = {"MXS": ("M0", -1), "M0": ("M1", -1), "M1": ("M2", 0), "M2": ("M3", 0)}
COARSER = {fine: (coarse, -change) for coarse, (fine, change) in FINER.items()}
DIAMETER = {"MXS": 31, "M0": 15.87, "M1": 6.265, "M2": 4.204, "M3": 3.135}  # mean of the wall's cells [mm]
AUTO = {"MXS": 3, "M0": 2, "M1": 1, "M2": 0, "M3": 0}  # what `electrophysiology.refinements: auto` comes to
STEP_S = {"MXS": 0.0015, "M0": 0.0075, "M1": 0.07, "M2": 0.22, "M3": 0.55}  # about, CPU time of a step [s]
LIMIT_S = 500  # CPU seconds: a finer mesh that costs more is compared at a larger step
OF = {"EF": "points", "p_max": "mmHg", "V": "%", "p": "%", "activation": "ms"}
MONOLITHIC = {"coupling.scheme": "E1FSinf", "participants": {"mech": None, "fluid": None, "fsi": {"program": "fsi_solver"}}}
TOLERANCES = ["electrophysiology.tolerance", "mechanics.residual_tolerance", "mechanics.update_tolerance",
              "mechanics.linear_tolerance", "lifting.tolerance", "fluid.tolerance"]
TIGHTER, TIGHTEST, LOOSEST = 1e-2, 1e-13, 1e-2
COLOURS = {"finer": "#0072b2", "coarser": "#e69f00"}


@dataclass
class Neighbour:
    """One discretisation changed: `run` against `base`, by the ratio of resolutions, with an expected order."""
    part: str
    direction: str  # "finer", "coarser"
    what: str
    run: str
    base: str = "scene"
    other_base: str = ""  # taken instead when it activates the wall more like `run`: electrophysiology's edges differ, too
    ratio: float = 2
    order: float = 1

    @property
    def factor(self):
        """(scene - exact) over the difference of the two."""
        gain = self.ratio**-self.order
        return 1 / (1 - gain) if self.direction == "finer" else 1 / (1 / gain - 1)


def scaled(text, factor):
    """A number with its unit, times a factor."""
    value, _, unit = str(text).partition(" ")
    return f"{float(value) * factor:.10g} {unit}".strip()


class Plan:
    """Runs and neighbours of a scene."""

    def __init__(self, scene, defaults):
        self.runs, self.neighbours, self.notes = {"scene": {}}, [], []
        self.scene = {**lay_over(defaults, scene), "participants": scene["participants"]}
        who = self.scene["participants"]
        self.replays, self.has_blood = "ep" in who and ("mech" in who or "fsi" in who), "fluid" in who or "fsi" in who
        self.step()
        if "ep" in who:
            self.own_step()
            self.own_mesh()
        self.mesh()
        self.scheme()
        self.tolerances()

    def at(self, key):
        tree = self.scene
        for part in key.split("."):
            tree = tree.get(part, {}) if isinstance(tree, dict) else {}
        return tree

    def fits(self, factor):
        """Whether the run is a whole number of steps so much larger."""
        steps = quantity(self.at("time.end")) / quantity(self.at("time.step")) / factor
        return abs(steps - round(steps)) < 1e-6 and steps >= 2

    def add(self, part, direction, what, run, settings, **more):
        self.runs[run] = settings
        self.neighbours.append(Neighbour(part, direction, what, run, **more))

    def same_calcium(self):
        return {"calcium": "scene"} if self.replays else {}

    def step(self):
        step = self.at("time.step")
        for direction, factor in (("finer", 0.5), ("coarser", 2)):
            if self.fits(factor):
                self.add("coupling step", direction, f"{step} -> {scaled(step, factor)}", f"step_{direction}",
                         {"time.step": scaled(step, factor), **self.same_calcium()})

    def own_step(self):
        """Electrophysiology's, at the same coupling step."""
        n, step = self.at("electrophysiology.substeps"), self.at("time.step")
        order = 1 if self.at("electrophysiology.integrator") in ({}, "imex_euler") else 2
        part, tolerance = "electrophysiology's step", number(self.at("electrophysiology.substep_tolerance"))
        if isinstance(n, int):
            self.add(part, "finer", f"{scaled(step, 1 / n)} -> {scaled(step, 0.5 / n)}", "ep_step_finer",
                     {"electrophysiology.substeps": 2 * n}, order=order)
        if isinstance(n, int) and n % 2 == 0:
            self.add(part, "coarser", f"{scaled(step, 1 / n)} -> {scaled(step, 2 / n)}", "ep_step_coarser",
                     {"electrophysiology.substeps": n // 2}, order=order)
        for direction, factor in (("finer", 0.5), ("coarser", 2)):
            if f"ep_step_{direction}" in self.runs or not (self.replays and self.fits(factor)):
                continue  # else by a recording with another step, which is linear in time between its instants
            settings, what = {"time.step": scaled(step, factor)}, f"within {step} -> {scaled(step, factor)}"
            if not isinstance(n, int) and tolerance:  # an error estimate of second order decides
                settings["electrophysiology.substep_tolerance"] = tolerance * factor**2
                what = f"{n} {what}, its tolerance x {factor**2:g}"
            self.add(part, direction, what, f"ep_step_{direction}", {"calcium": settings}, order=order)

    def own_mesh(self):
        n = self.at("electrophysiology.refinements")
        if n == "auto" and self.at("geometry.shape") == "ideal_left_ventricle":
            n = AUTO.get(self.at("geometry.mesh"), n)
        if not isinstance(n, int):
            self.notes.append(f"electrophysiology's mesh: electrophysiology.refinements is '{n}'; give a number to vary it")
            return
        for direction, other in (("finer", n + 1), ("coarser", n - 1)):
            if other >= 0:
                self.add("electrophysiology's mesh", direction, f"refinements {n} -> {other}", f"ep_mesh_{direction}",
                         {"electrophysiology.refinements": other}, order=2)

    def mesh(self):
        shape = self.at("geometry.shape")
        if shape == "ideal_left_ventricle":
            self.ventricle("finer", FINER)
            self.ventricle("coarser", COARSER)
            return
        cells = {key: n for key, n in (self.at(f"geometry.{shape}") or {}).items()
                 if isinstance(n, int) and key.startswith("cells")}
        for direction, factor in (("finer", 2), ("coarser", 0.5)):
            if cells and all(n * factor >= 1 and float(n * factor).is_integer() for n in cells.values()):
                self.add("mesh of wall and blood", direction, f"cells x {factor}", f"mesh_{direction}",
                         {f"geometry.{shape}.{key}": int(n * factor) for key, n in cells.items()}, order=2)

    def ventricle(self, direction, neighbours):
        mesh, refinements = self.at("geometry.mesh"), self.at("electrophysiology.refinements")
        if mesh not in neighbours:
            self.notes.append(f"mesh of wall and blood: there is no {direction} one than {mesh}")
            return
        other, change = neighbours[mesh]
        settings = {"geometry.mesh": other}
        if isinstance(refinements, int) and "ep" in self.scene["participants"]:
            settings["electrophysiology.refinements"] = max(0, refinements + change)
        ratio = DIAMETER[mesh] / DIAMETER[other]
        factor = self.affordable(other) if direction == "finer" else 1
        what = f"{mesh} -> {other}" + (f", both at {scaled(self.at('time.step'), factor)}" if factor > 1 else "")
        base = "scene"
        if factor > 1:
            base = f"scene_step_x{factor}"
            self.runs[base] = {"time.step": scaled(self.at("time.step"), factor), **self.same_calcium()}
            settings["time.step"] = scaled(self.at("time.step"), factor)
            if isinstance(self.at("electrophysiology.substeps"), int):
                settings["electrophysiology.substeps"] = factor * self.at("electrophysiology.substeps")
        also = "ep_mesh_finer" if direction == "finer" and base == "scene" and "ep_mesh_finer" in self.runs else ""
        self.add("mesh of wall and blood", direction, what, f"mesh_{direction}", settings, base=base, other_base=also,
                 ratio=max(ratio, 1 / ratio), order=2)

    def affordable(self, mesh):
        """The factor of the step at which a run on this mesh costs less than the limit, by what a step took elsewhere."""
        steps, factor = quantity(self.at("time.end")) / quantity(self.at("time.step")), 1
        while factor < 4 and STEP_S[mesh] * steps / factor > LIMIT_S and self.fits(2 * factor):
            factor *= 2
        if factor > 1:
            self.notes.append(f"mesh of wall and blood: about {STEP_S[mesh] * steps:.0f} CPU s on {mesh} with the scene's step; "
                              f"the pair is run with one {factor} times as large")
        return factor

    def scheme(self):
        scheme = self.at("coupling.scheme")
        if not self.has_blood:
            return
        if scheme != "E1FSinf":
            self.add("scheme", "finer", f"{scheme} -> E1FSinf", "scheme_finer", MONOLITHIC, ratio=np.inf)
        else:
            self.notes.append("scheme: E1FSinf leaves no splitting error")

    def tolerances(self):
        known = {key: number(self.at(key)) for key in TOLERANCES if number(self.at(key))}  # YAML takes 1e-6 for a text
        for direction, factor in (("finer", TIGHTER), ("coarser", 1 / TIGHTER)):
            self.add("solver tolerances", direction, f"x {factor:g}", f"tolerances_{direction}",
                     {key: float(f"{min(max(value * factor, TIGHTEST), LOOSEST):.3g}") for key, value in known.items()},
                     ratio=100)


def study_of(options, known):
    """(study, plan) of a scene."""
    scene = options.study
    plan = Plan(Study(scene, known, scene, options.settings, options.ranks, {"also": {"scene": {}}}).base_tree, known)
    end = plan.at("time.end")
    silent = {"output.every": end, "output.checkpoint.every": "0 ms"}  # once, for the mesh
    written = {"about": f"Error budget of {scene.stem}", "settings": silent, "also": plan.runs, "reference": "scene"}
    if plan.replays:
        written["calcium"] = "replay"
    study = Study(scene, known, scene, options.settings, options.ranks, written)
    study.name = f"budget_{scene.stem}"
    return study, plan


def difference(study, store, run, base):
    """{measure: run - base} in the units of OF; of V and p the relative L2 norm. Without what they do not both have."""
    one, other = (study.case(study.by_name[name]) for name in (run, base))
    folders = store.of(one), store.of(other)
    own, exact = map(indicators, folders)
    found = {name: own[key] - exact[key] for name, key in (("EF", "EF_percent"), ("p_max", "p_max_mmHg"))
             if key in own and key in exact}
    errors = measures.errors(*folders)
    found.update({name: errors[f"error_{name}"] for name in ("V", "p") if f"error_{name}" in errors})
    activated = [measures.activation(store, case) for case in (one, other)]
    if all(activated):
        found["activation"] = activated[0] - activated[1]
    return found


def scale(study, store):
    """What the measures of the scene are, so that differences of all become shares [%]."""
    case = study.case(study.by_name["scene"])
    own = indicators(store.of(case))
    return {"EF": own.get("EF_percent"), "p_max": own.get("p_max_mmHg"), "V": 100, "p": 100,
            "activation": measures.activation(store, case)}


def rows_of(study, store, plan, chosen):
    """One row for each neighbour, done or not."""
    def cost(name):
        return costs(store, [study.case(study.by_name[name])])["cost_s"]

    def partner(each):
        """The run that the neighbour is compared with: the one whose electrophysiology is more like its own."""
        names = [name for name in (each.base, each.other_base) if name]
        cases = {name: study.case(study.by_name[name]) for name in (each.run, *names)}
        if any(store.state(case) != "done" for case in cases.values()):
            return each.base
        when = {name: measures.activation(store, case) for name, case in cases.items()}
        return min(names, key=lambda name: abs(when[name] - when[each.run])) if all(when.values()) else each.base

    whole = scale(study, store) if store.state(study.case(study.by_name["scene"])) == "done" else {}
    rows = []
    for each in plan.neighbours:
        row = {"part": each.part, "direction": each.direction, "change": each.what, "run": each.run,
               "order": each.order, "ratio": each.ratio}
        states = [store.state(study.case(study.by_name[name])) for name in (each.run, each.base)]
        row["state"] = next((state for state in states if state != "done"), "done")
        if row["state"] == "failed":
            row["reason"] = store.reason(study.case(study.by_name[each.run]))
        rows.append(row)
        if row["state"] != "done":
            continue
        base = partner(each)
        if base == each.other_base:
            row["change"] += f", electrophysiology's as in {base}"
        for name, value in difference(study, store, each.run, base).items():
            if name in chosen:
                row[f"change_{name}"] = value
                signed = -value if each.direction == "finer" else value
                row[f"error_{name}"] = each.factor * (abs(value) if name in ("V", "p") else signed) + 0.  # no -0
        row["cost_s"] = cost(each.run)
        row["cost_ratio"] = cost(each.run) / cost(each.base)
        row["share"], row["of"] = max(((100 * abs(row[f"error_{name}"]) / whole[name], name) for name in chosen
                                       if f"error_{name}" in row and whole.get(name)), default=(0., ""))
        row["change_share"] = row["share"] / each.factor
        row["extra_cost"] = row["cost_ratio"] - 1
    return rows


def advice(rows):
    """What to refine next for the least cost, and what is finer than needed."""
    finer = [row for row in rows if row["direction"] == "finer" and row["state"] == "done"]
    largest = max((row["share"] for row in finer), default=0.)
    if not largest:
        return "No discretisation shows an error."
    worth = [row for row in finer if row["share"] >= largest / 10]
    best = max(worth, key=lambda row: row["change_share"] / max(row["extra_cost"], 0.02))
    text = (f"Refine next: {best['part']} ({best['change']}): it takes {best['change_share']:.2g} % of error in "
            f"{best['of']} away for {best['cost_ratio']:.2f} times the cost")
    most = max(finer, key=lambda row: row["share"])
    if most is not best:
        text += (f"; the largest error is that of {most['part']}, {most['share']:.2g} % in {most['of']}, of which {most['change']} "
                 f"takes {most['change_share']:.2g} % for {most['cost_ratio']:.2f} times the cost")
    spare = [row for row in rows if row["direction"] == "coarser" and row["state"] == "done"
             and row["change_share"] < largest / 10 and row["cost_ratio"] < 0.97]
    spare.sort(key=lambda row: row["cost_ratio"])
    known = {row["part"] for row in rows if row["direction"] == "coarser" and row["state"] == "done"}
    small = [row for row in finer if row["share"] < largest / 20 and row["part"] not in known]
    words = [f"{row['part']} ({row['change']} adds {row['change_share']:.2g} % to {row['of'] or 'nothing'} for {row['cost_ratio']:.2f} times the cost)"
             for row in spare] + [f"{row['part']} (its error is {row['share']:.2g} %)" for row in small]
    return text + "; finer than needed: " + (", ".join(words) if words else "nothing") + "."


def chosen_measures(words):
    for word in words:
        if word not in OF:
            raise StudyError(f"--of {word}: choose from {', '.join(OF)}")
    return words or list(OF)


def explore(options, known, make_store, perform):
    """Runs what is missing, writes budget.csv, .md and .png. The exit code."""
    chosen = chosen_measures(options.of)
    study, plan = study_of(options, known)
    store, schedule, folder = make_store(study)
    perform(study, store, schedule, options)
    for run in study.runs:
        store.link(study.case(run), run.name, folder / "runs")
    rows = rows_of(study, store, plan, chosen)
    write(study, plan, rows, chosen, folder)
    missing = [row for row in rows if row["state"] != "done"]
    for row in missing:
        print(f"{row['state']}: {row['run']} {row.get('reason', '')}".strip())
    if schedule.obstacle:
        print(f"stopped: {schedule.obstacle}; the same command goes on")
    return 1 if missing else 0


def write(study, plan, rows, chosen, folder):
    keys = ["part", "direction", "change", "run", "state", "order", "ratio",
            *[f"{kind}_{name}" for name in chosen for kind in ("change", "error")], "share", "of", "change_share", "cost_s",
            "cost_ratio", "reason"]
    with open(folder / "budget.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, keys, restval="", extrasaction="ignore")
        writer.writeheader()
        writer.writerows(rows)
    chosen = [name for name in chosen if any(f"error_{name}" in row for row in rows)] or chosen
    text = markdown([readable(row, chosen) for row in rows], ["run", "change", *[f"{name}, {OF[name]}" for name in chosen],
                                                              *[f"error {name}, {OF[name]}" for name in chosen], "cost"])
    lines = [text, "'error': estimate of the scene's whole error, the difference over 1 - r^-p (finer) or r^p - 1 (coarser); "
             "p and r are in budget.csv.\n", *[f"{note}.\n" for note in plan.notes], advice(rows) + "\n"]
    (folder / "budget.md").write_text("".join(lines))
    print("".join(lines), end="")
    print(f"{folder}/budget.csv")
    if any(row["state"] == "done" for row in rows):
        draw(study, rows, [name for name in chosen if any(f"error_{name}" in row for row in rows)], folder / "budget.png")


def readable(row, chosen):
    cells = {"run": f"{row['part']}, {row['direction']}", "state": row["state"], "change": row["change"],
             "cost": f"x {row['cost_ratio']:.2f}" if "cost_ratio" in row else ""}
    for name in chosen:
        for kind, key in (("change", f"{name}, {OF[name]}"), ("error", f"error {name}, {OF[name]}")):
            if f"{kind}_{name}" in row:
                cells[key] = f"{row[f'{kind}_{name}']:+.2g}" if name not in ("V", "p") else f"{row[f'{kind}_{name}']:.2g}"
    return cells


def draw(study, rows, chosen, path):
    """A panel for each measure with the estimated errors, one with the costs."""
    parts = list(dict.fromkeys(row["part"] for row in rows))
    drawing, axes = plt.subplots(1, len(chosen) + 1, figsize=(3 + 2.4 * (len(chosen) + 1), 1.6 + 0.5 * len(parts)),
                                 sharey=True, squeeze=False)
    for axis, name in zip(axes[0], [*chosen, "cost"]):
        for direction, shift in (("finer", -0.2), ("coarser", 0.2)):
            own = [row for row in rows if row["direction"] == direction and row["state"] == "done"]
            key = "cost_ratio" if name == "cost" else f"error_{name}"
            own = [row for row in own if key in row]
            axis.barh([parts.index(row["part"]) + shift for row in own], [row[key] for row in own], 0.36,
                      color=COLOURS[direction], label=f"by the {direction} neighbour")
        axis.axvline(1 if name == "cost" else 0, color="0.3", lw=0.8)
        axis.set_xlabel("cost over the scene's" if name == "cost" else f"error of {name} [{OF[name]}]", fontsize=9)
    axes[0, 0].set_yticks(range(len(parts)), parts)
    axes[0, 0].invert_yaxis()
    axes[0, -1].legend(fontsize=7, loc="lower right")
    save(drawing, path, study.about)
