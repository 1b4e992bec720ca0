"""The figures of a study file: measures against a varied number, curves in time, bars, pictures of the fields."""
import subprocess
import sys
from fnmatch import fnmatch
from pathlib import Path

import numpy as np
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from reporting import charts, style
from reporting.style import plt
from results import ML, MMHG, Run

from .launch import ROOT
from .measures import NORM_UNITS, UNITS, order

CURVES = {"volume": ("volume [mL]", ML), "mean_pressure": ("mean pressure [mmHg]", MMHG),
          "aortic_flow": ("aortic flow [mL/s]", ML), "mitral_flow": ("mitral flow [mL/s]", ML)}
NAMES = {"EF_percent": "ejection fraction", "p_max_mmHg": "$p_{max}$", "ILI_C_percent": "$ILI_C$",
         "ILI_R_percent": "$ILI_R$", "cpu_s": "CPU time", "wall_s": "wall time", "error_EF": "error of EF",
         "error_p_max": "error of $p_{max}$", "error_ILI_C": "error of $ILI_C$", "error_ILI_R": "error of $ILI_R$",
         "error_V": "error of V(t), $L^2$", "error_p": "error of p(t), $L^2$", "max_V": r"max $|V-V_{ref}|$",
         "step_ms": "wall time of a step", "assembly_ms": "assembly for blood and wall, a step",
         "solve_ms": "solution for blood and wall, a step", "h_mm": "mean diameter h of the wall's cells",
         "max_p": r"max $|p-p_{ref}|$", "mean_coupling_iterations": "iterations a step"}
NORMS = {"d": "displacement", "u": "velocity", "pressure": "pressure field", "V": "volume", "p": "mean pressure"}
MARKERS = "osD^vP*X<>"


def label(key):
    """A measure with its unit."""
    part, _, name = key.partition("_")
    if part in ("contraction", "ejection") and name in NORMS:
        return f"{NORMS[name]} in {part} [{style.pretty(NORM_UNITS[name])}]"
    return NAMES.get(key, key.replace("_", " ")) + (f" [{style.pretty(UNITS[key])}]" if key in UNITS else "")


def draw_all(study, store, rows, folder):
    """All figures for which there are finished runs."""
    done = {row["run"]: row for row in rows if row["state"] == "done"}
    for name, figure in study.figures.items():
        wanted = figure.get("runs", ["*"])
        runs = [run for run in study.runs if run.name in done and any(fnmatch(run.name, each) for each in wanted)]
        if runs and figure["kind"] in DRAW:
            DRAW[figure["kind"]](study, store, figure, runs, done, folder / f"{name}.png")


def save(drawing, path, title):
    drawing.suptitle(title, fontsize=11)
    drawing.tight_layout()
    style.save(drawing, path.with_suffix(""))
    plt.close(drawing)
    print(path)


def panels(n, size=(4.2, 3.6)):
    columns = 2 if n == 4 else min(n, 3)
    drawing, axes = plt.subplots(-(-n // columns), columns, squeeze=False,
                                 figsize=(size[0] * columns, size[1] * -(-n // columns)))
    for unused in axes.ravel()[n:]:
        unused.set_visible(False)
    return drawing, axes.ravel()[:n]


def against(study, _, figure, runs, done, path):
    """Measures against a varied number or another measure; runs that do not have it as dashed lines, the paper's hollow."""
    drawing, axes = panels(len(figure["y"]))
    groups, x = {}, {run.name: run.values.get(figure["x"], done[run.name].get(figure["x"])) for run in runs}
    for run in runs:
        groups.setdefault(run.parts.get(figure.get("by"), ""), []).append(run)
    for axis, measure in zip(axes, figure["y"]):
        lines = [run for run in runs if x[run.name] is None and measure in done[run.name]]
        for i, ((group, members), shade) in enumerate(zip(groups.items(), style.colours(list(groups)))):
            points = sorted(((x[run.name], done[run.name][measure], run) for run in members
                             if x[run.name] is not None and measure in done[run.name]), key=lambda point: point[0])
            if points:
                draw_group(axis, figure, measure, group, (MARKERS[i % len(MARKERS)], shade), points, study.paper)
        for run in lines:
            draw_level(axis, run.name, done[run.name][measure], study.paper.get(run.name, {}).get(measure))
        axis.set_xlabel(style.pretty(figure.get("x_label", label(figure["x"]))))
        axis.set_ylabel(label(measure), fontsize=9)
        if "x" in figure.get("log", []):
            log_axis(axis, sorted({value for value in x.values() if value is not None}))
        if "y" in figure.get("log", []):
            log_ordinate(axis)
        if axis.has_data():
            axis.legend(fontsize=7)
    save(drawing, path, figure.get("title", study.about))


def log_axis(axis, values):
    """A logarithmic abscissa marked at the values there are."""
    axis.set_xscale("log")
    axis.set_xticks(values, [f"{value:.6g}" for value in values], fontsize=8, rotation=0 if len(values) < 6 else 45)
    axis.minorticks_off()


def plain(value):
    """2,000, 0.05, 5·10⁻⁶."""
    digits, power = f"{value:.0e}".split("e")
    return f"{value:,.10g}" if value >= 1e-3 else f"{digits}·10{str(int(power)).translate(style.POWERS)}"


def log_ordinate(axis):
    """A logarithmic ordinate, which has several numbers also where it spans less than one or two powers of ten."""
    axis.set_yscale("log")
    low, high = axis.get_ylim()
    if high < 1000 * low:
        axis.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: plain(value)))
        axis.yaxis.set_minor_formatter(NullFormatter())


def draw_group(axis, figure, measure, group, look, points, paper):
    """`look`: marker and colour."""
    marker, shade = look
    x, y = np.array([point[0] for point in points]), np.array([point[1] for point in points])
    name = group
    if figure.get("fit") and len(x) > 1 and min(y) > 0:
        slope, deviation = order(x, y)
        spread = f" ± {deviation:.2f}" if np.isfinite(deviation) else ""
        name = f"{group} slope {slope:.2f}{spread}"
        shift = np.mean(np.log(y) - slope * np.log(x))
        axis.plot(x, np.exp(shift) * x**slope, "--", lw=1, color=shade)
    axis.plot(x, y, marker + ("" if figure.get("fit") else "-"), color=shade, label=name, ms=5)
    known = [(at, paper[run.name][measure]) for at, _, run in points
             if measure in paper.get(run.name, {})]
    if known:
        axis.plot(*zip(*known), marker, color=shade, mfc="none", ms=9, label=f"{group} paper")


def draw_level(axis, name, value, published):
    line = axis.axhline(value, ls="--", color="0.3", lw=1.2, label=name)
    if published is not None:
        axis.axhline(published, ls=":", color=line.get_color(), lw=1.2, label=f"{name} paper")


def curves(study, store, figure, runs, _, path):
    """Columns of history.csv in time, phases of the first run behind."""
    drawing, axes = charts.stacked(len(figure["columns"]))
    loaded = [(run.name, Run(store.of(study.case(run)))) for run in runs]
    charts.shade_phases(axes, loaded[0][1])
    for axis, column in zip(axes, figure["columns"]):
        title, scale = CURVES.get(column, (column.replace("_", " "), 1))
        for i, ((name, run), shade) in enumerate(zip(loaded, style.colours([name for name, _ in loaded]))):
            if column in run.history:
                axis.plot(run.milliseconds, run.history[column] / scale, label=name, lw=1.4, color=shade,
                          ls=("-", "--", "-.", ":")[i // len(style.PALETTE) % 4])
        axis.set_ylabel(title)
    axes[0].set_xlim(figure.get("from_ms"), figure.get("until_ms"))
    axes[0].legend(fontsize=7, ncols=1 + len(loaded) // 6)
    save(drawing, path, figure.get("title", study.about))


def bars(study, _, figure, runs, done, path):
    """Measures of each run, the paper's as diamonds."""
    drawing, axes = panels(len(figure["y"]), (4.2, 1.4 + 0.26 * len(runs)))
    names = [run.name for run in runs]
    diamonds = []
    for i, (axis, measure) in enumerate(zip(axes, figure["y"])):
        values = [done[name].get(measure, np.nan) for name in names]
        known = {k: study.paper[name][measure] for k, name in enumerate(names) if measure in study.paper.get(name, {})}
        axis.barh(range(len(names)), values, color=style.colours(names), alpha=0.75)
        for k, value in enumerate(values):  # in a column beside the axes, where no bar and no diamond comes
            if np.isfinite(value):
                axis.text(1.02, k, f"{value:.3g}", transform=axis.get_yaxis_transform(), ha="left", va="center",
                          fontsize=7)
        axis.set_yticks(range(len(names)), names)
        if known:
            diamonds = axis.plot(known.values(), known.keys(), "kD", mfc="none", ms=6, label="paper")
        axis.set_xlabel(label(measure))
        axis.set_ylim(len(names) - 0.4, -0.6)  # the same rows in all panels
        axis.tick_params(axis="y", labelsize=7, labelleft=i % (2 if len(axes) == 4 else 3) == 0)
    if diamonds:
        drawing.legend(handles=diamonds, fontsize=8, loc="upper right")
    save(drawing, path, figure.get("title", study.about))


def picture(arguments):
    """By a program of its own, since it may need a virtual display."""
    result = subprocess.run(["/usr/bin/python3", str(ROOT / "tools/pictures.py"), *map(str, arguments)])
    if result.returncode != 0:
        print(f"no pictures: tools/pictures.py ended with {result.returncode}", file=sys.stderr)


def flow(study, store, _, runs, __, path):
    """Velocity and pressure in contraction, ejection and filling, the runs side by side."""
    named = [f"{run.name}={store.of(study.case(run))}" for run in runs]
    picture(["--flow", *named, "--out", path.parent, "--name", path.stem])


def potential(study, store, figure, runs, _, path):
    """Potential and calcium at some instants, from the electrophysiology that the runs have replayed."""
    calcium = study.case(runs[0]).calcium
    folder = Path(store.of(calcium or study.case(runs[0])))
    picture(["--electric", folder, "--times", *figure.get("times_ms", [30, 60, 100, 300]), "--out", path.parent,
             "--name", path.stem])


DRAW = {"against": against, "curves": curves, "bars": bars, "flow": flow, "potential": potential}
