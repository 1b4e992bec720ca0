#!/usr/bin/python3
"""Draws the pictures of docs/failures.md from the results of its commands, and of the same runs as they should be.

    docs/pictures/failures.py results --out docs/pictures

Beside results/alpha, auto and inflow are drawn alpha_cured, auto_cured and inflow_cured, if they are there: the same commands
with the key that the message proposes.
"""
import argparse
import sys
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))
from reporting.style import INK, colour, plt  # noqa: E402
from results import ML, History  # noqa: E402

DPI = 110


def save_png(figure, path):
    plt.rcParams["savefig.dpi"] = DPI
    figure.savefig(path, bbox_inches="tight", pad_inches=0.05)
    plt.close(figure)


def beside(results, name, column, labels, unit, scale, path, log=False):
    """One column of a run that fails, and of the one that does not."""
    figure, axis = plt.subplots(figsize=(5.2, 2.4))
    for k, (folder, label) in enumerate(zip((name, f"{name}_cured"), labels)):
        if (results / folder / "history.csv").exists():
            history = History(results / folder)
            rows = history.time > 0
            axis.plot(1e3 * history.time[rows], history[column][rows] / scale, color=colour(1 - k), label=label)
            if k == 0:
                axis.plot(1e3 * history.time[-1], history[column][-1] / scale, "x", color=INK, label="the run ends")
    axis.set(xlabel="time [ms]", ylabel=unit, yscale="log" if log else "linear")
    axis.legend()
    save_png(figure, path)


def misprint(results, path):
    """What flows through the valve, and by how much the cavity grows, of E1FS2 as printed and done right."""
    figure, axes = plt.subplots(1, 2, figsize=(6.4, 2.4), layout="constrained", sharex=True, sharey=True)
    for axis, name, title in zip(axes, ("misprint", "misprint_cured"), ("as printed", "E1FS2")):
        history = History(results / name)
        flow, lost = history["mitral_flow"][1:] / ML, history["volume_defect"][1:] / ML
        axis.plot(1e3 * history.time[1:], flow, color=colour(1), label="through the valve")
        axis.plot(1e3 * history.time[1:], flow - lost, "--", color=colour(0), label="taken up by the wall")
        axis.set(title=title, xlabel="time [ms]")
    axes[0].set_ylabel("blood [mL/s]")
    axes[1].legend(loc="lower right")
    save_png(figure, path)


def front(results, path):
    """When each point of the face z = 0 of the slab is activated."""
    figure, axes = plt.subplots(1, 2, figsize=(6.4, 1.6), layout="constrained", sharey=True)
    levels = np.arange(0, 66, 5)
    for axis, cell in zip(axes, ("0.5", "1")):
        with h5py.File(results / f"front_{cell}/fields/activation.h5") as file:
            points, times = 1e3 * file["mesh/points"][:], 1e3 * file["000000/activation_time"][:].ravel()
        face = np.isclose(points[:, 2], 0)
        columns, rows = np.unique(points[face, 0].round(6)), np.unique(points[face, 1].round(6))
        order = np.lexsort((points[face, 0].round(6), points[face, 1].round(6)))
        shown = np.ma.masked_invalid(times[face][order].reshape(len(rows), len(columns)))
        drawn = axis.contourf(columns, rows, shown, levels, cmap="viridis_r")
        axis.set(title=f"cells of {cell} mm", xlabel="x [mm]", aspect="equal", xlim=(0, 20), ylim=(0, 7), facecolor="#cccccc")
        axis.grid(False)
    axes[0].set_ylabel("y [mm]")
    figure.colorbar(drawn, ax=axes, label="activated [ms]", ticks=levels[::3])
    save_png(figure, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", type=Path)
    parser.add_argument("--out", type=Path, default=Path())
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    beside(options.results, "alpha", "mean_pressure", ("α = 30,000 kg/(m² s)", "α = 15,000 kg/(m² s)"), "mean pressure [Pa]", 1,
           options.out / "failure_alpha.png")
    beside(options.results, "auto", "disagreement", ("E1FS2, α auto", "E1FS2, half of it"), "disagreement [Pa]", 1,
           options.out / "failure_auto.png", log=True)
    beside(options.results, "inflow", "mitral_flow", ("backflow: 0", "backflow: 1"), "inflow [mL/s]", ML,
           options.out / "failure_inflow.png")
    misprint(options.results, options.out / "failure_misprint.png")
    front(options.results, options.out / "failure_front.png")


if __name__ == "__main__":
    main()
