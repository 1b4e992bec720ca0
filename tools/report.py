#!/usr/bin/python3
"""Plots of a run: pressure-volume loop, one colour a beat, with a table of the beats; volume and pressure, flows, balance
of volume at the wall.

    tools/report.py results/ideal_lv_efs1 [--compare results/ideal_lv_e1fs2 ...] [--out FOLDER]
"""
import argparse
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from results import ML, MMHG, PHASES, History, indicators

plt.rcParams.update({"figure.dpi": 150, "font.size": 10, "axes.grid": True, "grid.alpha": 0.25, "axes.axisbelow": True,
                     "axes.spines.top": False, "axes.spines.right": False, "lines.linewidth": 1.8,
                     "legend.frameon": False})


# Indicators of a beat that are shown: name, label, digits, unit.
SHOWN = (("EF_percent", "EF", 1, "%"), ("p_max_mmHg", "$p_{max}$", 1, "mmHg"), ("EDV_mL", "EDV", 1, "mL"),
         ("ESV_mL", "ESV", 1, "mL"), ("ILI_C_percent", "$ILI_C$", 2, "%"), ("ILI_R_percent", "$ILI_R$", 2, "%"),
         ("activation_time_ms", "last activation", 1, "ms"), ("J_min", "smallest J", 3, ""),
         ("wall_volume_min_percent", "smallest wall volume", 1, "%"),
         ("clamped_share_max_percent", "most clamped sarcomeres", 0, "%"))


class Run:
    def __init__(self, folder):
        self.name = Path(folder).resolve().name
        self.history = History(folder)
        self.indicators = indicators(folder)
        self.milliseconds = 1e3 * self.history.time

    def beats(self):
        """(its indicators, its rows of the history) of each beat; of a run without them, all rows."""
        time = self.history.time
        for beat in self.indicators.get("beats") or [{"start": time[0], "end": time[-1]}]:
            yield beat, (time >= beat["start"] - 1e-9) & (time <= beat["end"] + 1e-9)


def shade_phases(axes, run):
    """Colours the background by phase; names the phases that are wide enough above the topmost axes."""
    stretches = run.history.phases()
    span = run.history.time[-1] - run.history.time[0]
    for name, begin, end in stretches:
        short, colour = PHASES.get(name, (name, "#ffffff"))
        for axis in axes:
            axis.axvspan(1e3 * begin, 1e3 * end, color=colour, alpha=0.6, lw=0)
        if end - begin > 0.04 * span:
            axes[0].text(5e2 * (begin + end), 1.02, short, transform=axes[0].get_xaxis_transform(), ha="center",
                         fontsize=8, color="#444444")


def stacked(n_rows, height=2.4):
    figure, axes = plt.subplots(n_rows, 1, sharex=True, figsize=(7.5, 0.9 + height * n_rows), squeeze=False)
    axes = axes[:, 0]
    axes[-1].set_xlabel("time [ms]")
    axes[-1].margins(x=0)
    return figure, axes


def draw(axis, runs, column, scale=1.0):
    for run in runs:
        if column in run.history:
            axis.plot(run.milliseconds, run.history[column] / scale, label=run.name)


def save(figure, folder, name, title, runs):
    figure.suptitle(title if len(runs) > 1 else f"{title}: {runs[0].name}", fontsize=12)
    if len(runs) > 1:
        figure.axes[0].legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(Path(folder) / name)
    plt.close(figure)
    print(Path(folder) / name)


def pressure_volume_loop(runs, folder):
    figure, axis = plt.subplots(figsize=(6, 5))
    for run in runs:
        volume, pressure, line = run.history["volume"] / ML, run.history["mean_pressure"] / MMHG, None
        for beat, rows in run.beats():
            if len(runs) == 1:
                line, = axis.plot(volume[rows], pressure[rows], label=f"beat {beat.get('beat', 1)}")
            elif line is None:
                line, = axis.plot(volume, pressure, label=run.name)
            axis.plot(volume[rows][0], pressure[rows][0], "o", color=line.get_color(), ms=5)
    axis.set_xlabel("volume of the ventricle [mL]")
    axis.set_ylabel("mean pressure [mmHg]")
    if len(runs) == 1:
        show_indicators(figure, axis, runs[0])
    save(figure, folder, "pv_loop.png", "Pressure-volume loop", runs)


def show_indicators(figure, axis, run):
    """Inside the loop; of several beats a table below it, one column each."""
    beats = [beat for beat, _ in run.beats()]
    shown = [row for row in SHOWN if any(row[0] in beat for beat in beats)]

    def value(beat, key, digits):
        return f"{beat[key]:.{digits}f}" if key in beat else ""

    if len(beats) == 1:
        lines = [f"{label} {value(beats[0], key, digits)} {unit}" for key, label, digits, unit in shown]
        axis.text(0.5, 0.45, "\n".join(lines), transform=axis.transAxes, ha="center", va="center", fontsize=8)
        return
    axis.legend(fontsize=8)
    height = 0.22 * (len(shown) + 1)  # inches
    figure.set_figheight(5.4 + height)
    table = axis.table([[value(beat, key, digits) for beat in beats] for key, _, digits, _ in shown],
                       rowLabels=[f"{label} [{unit}]" if unit else label for _, label, _, unit in shown],
                       colLabels=[f"beat {beat['beat']}" + ("" if beat["complete"] else " (incomplete)")
                                  for beat in beats], edges="horizontal", cellLoc="right",
                       bbox=[0.1, -0.16 - height / 4.2, 0.9, height / 4.2])
    table.auto_set_font_size(False)
    table.set_fontsize(8)


def volume_and_pressure(runs, folder):
    figure, (top, bottom) = stacked(2)
    shade_phases((top, bottom), runs[0])
    draw(top, runs, "volume", ML)
    draw(bottom, runs, "mean_pressure", MMHG)
    top.set_ylabel("volume [mL]")
    bottom.set_ylabel("mean pressure [mmHg]")
    save(figure, folder, "volume_pressure.png", "Volume and pressure of the ventricle", runs)


def flows(runs, folder):
    figure, (top, bottom) = stacked(2)
    shade_phases((top, bottom), runs[0])
    draw(top, runs, "aortic_flow", ML)
    draw(bottom, runs, "mitral_flow", ML)
    top.set_ylabel("aortic flow, out [mL/s]")
    bottom.set_ylabel("mitral flow, in [mL/s]")
    save(figure, folder, "flows.png", "Flow through the valves", runs)


def budget(runs, folder):
    """What the explicit coupling loses: volume that passes the wall, and the power of the interface's mismatch."""
    figure, axes = stacked(2)
    shade_phases(axes, runs[0])
    for run in runs:
        time, defect = run.history.time, run.history["volume_defect"]
        lost = np.concatenate(([0], np.cumsum(defect[1:] * np.diff(time))))
        axes[0].plot(run.milliseconds, defect / ML, label=run.name)
        axes[1].plot(run.milliseconds, lost / ML)
    axes[0].set_ylabel(r"$\int_\Sigma (u - v)\cdot n$ [mL/s]")
    axes[1].set_ylabel("its sum over time [mL]")
    save(figure, folder, "budget.png", "Blood that passes the wall", runs)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="results folder of a run")
    parser.add_argument("--compare", nargs="*", default=[], metavar="FOLDER", help="other runs in the same plots")
    parser.add_argument("--out", help="folder for the plots; default: FOLDER/report")
    options = parser.parse_args()
    runs = [Run(folder) for folder in [options.folder, *options.compare]]
    out = Path(options.out or Path(options.folder) / "report")
    out.mkdir(parents=True, exist_ok=True)
    plots = {pressure_volume_loop: {"volume", "mean_pressure"}, volume_and_pressure: {"volume", "mean_pressure"},
             flows: {"aortic_flow", "mitral_flow"}, budget: {"volume_defect"}}
    for plot, needed in plots.items():
        if all(column in run.history for run in runs for column in needed):
            plot(runs, out)


if __name__ == "__main__":
    main()
