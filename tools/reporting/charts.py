"""Charts of one run, or of several together: each function returns a figure, or None when a run lacks what it shows."""
import numpy as np

from results import ML, MMHG

from . import trace
from .style import LINES, PHASES, colour, colours, plt

ROUND_OFF = 1e-12  # m^3/s, of volume that passes the wall
WIDTH = 4.8  # inches: text is readable on a telephone, and in a column of a paper


def has(runs, *columns):
    return all(column in run.history for run in runs for column in columns)


def stacked(n_rows, height=1.75):
    figure, axes = plt.subplots(n_rows, 1, sharex=True, figsize=(WIDTH, 0.6 + height * n_rows), squeeze=False)
    figure.subplots_adjust(bottom=0.2 / n_rows, hspace=0.14)  # labels may lie outside
    axes = axes[:, 0]
    axes[-1].set_xlabel("time [ms]")
    for axis in axes:
        axis.margins(x=0)
    return figure, axes


def shade_phases(axes, run):
    """Colours the background by phase; names the phases that are wide enough above the topmost axes."""
    span = run.history.time[-1] - run.history.time[0]
    for name, begin, end in run.history.phases():
        short, shade = PHASES.get(name, (name, "#ffffff"))
        for axis in axes:
            axis.axvspan(1e3 * begin, 1e3 * end, color=shade, lw=0, zorder=0)
        if span > 0 and (end - begin) / span > 0.012 * len(short) + 0.02:
            axes[0].text(5e2 * (begin + end), 1.02, short, transform=axes[0].get_xaxis_transform(), ha="center",
                         fontsize=8)


def own_looks(runs):
    """Colour and dashes of each run's line."""
    return [{"color": shade, "ls": LINES[k % len(LINES)]} for k, shade in enumerate(colours([run.scheme for run in runs]))]


def names_of(runs):
    return [run.name for run in runs]


def finish(figure, axes, names):
    """With a legend above, where there is more than one name."""
    if len(names) > 1:
        named = {label: handle for axis in axes for handle, label in zip(*axis.get_legend_handles_labels())}
        shown = [name for name in names if name in named]
        figure.legend([named[name] for name in shown], shown, loc="lower center", bbox_to_anchor=(0.55, 1.0),
                      ncols=min(len(names), 2))
    figure.align_ylabels()
    return figure


def in_time(runs, rows):
    """`rows`: (column, scale, label) each an axis of its own, all runs in it."""
    if not has(runs, *(column for column, _, _ in rows)):
        return None
    figure, axes = stacked(len(rows))
    shade_phases(axes, runs[0])
    for axis, (column, scale, label) in zip(axes, rows):
        for run, look in zip(runs, own_looks(runs)):
            axis.plot(run.milliseconds, run.history[column] / scale, label=run.name, **look)
        axis.set_ylabel(label)
    return finish(figure, axes, names_of(runs))


def pressure_volume_loop(runs):
    """One colour a beat, or a run."""
    if not has(runs, "volume", "mean_pressure"):
        return None
    figure, axis = plt.subplots(figsize=(WIDTH, 3.9))
    for run, look in zip(runs, own_looks(runs)):
        volume, pressure = run.history["volume"] / ML, run.history["mean_pressure"] / MMHG
        for k, (beat, rows) in enumerate(run.beats()):
            own = look if len(runs) > 1 else {"color": colour(k)}
            label = f"beat {beat.get('beat', 1)}" if len(runs) == 1 else run.name if k == 0 else None
            axis.plot(volume[rows], pressure[rows], label=label, **own)
            axis.plot(volume[rows][0], pressure[rows][0], "o", color=own["color"], ms=4)
    axis.set_xlabel("volume of the ventricle [mL]")
    axis.set_ylabel("mean pressure [mmHg]")
    beats = [f"beat {beat.get('beat', 1)}" for beat, _ in runs[0].beats()]
    return finish(figure, [axis], beats if len(runs) == 1 else names_of(runs))


def volume_and_pressure(runs):
    return in_time(runs, [("volume", ML, "volume [mL]"), ("mean_pressure", MMHG, "mean pressure [mmHg]")])


def cavity(runs):
    """Of a wall without blood."""
    return None if has(runs, "volume") else in_time(runs, [("cavity_volume", ML, "volume [mL]")])


def flows(runs):
    return in_time(runs, [("aortic_flow", ML, "aortic flow,\nout [mL/s]"), ("mitral_flow", ML, "mitral flow,\nin [mL/s]")])


def wall(runs):
    return in_time(runs, [("min_J", 1, "smallest J"), ("wall_volume", 0.01, "volume of\nthe wall [%]"),
                          ("peak_tension", 1e3, "largest active\ntension [kPa]")])


def budget(runs):
    """What the explicit coupling loses: volume that passes the wall. Nothing where all runs keep it to round-off."""
    if not has(runs, "volume_defect") or max(abs(run.history["volume_defect"]).max() for run in runs) < ROUND_OFF:
        return None
    figure, axes = stacked(2)
    shade_phases(axes, runs[0])
    for run, look in zip(runs, own_looks(runs)):
        time, defect = run.history.time, run.history["volume_defect"]
        lost = np.concatenate(([0], np.cumsum(defect[1:] * np.diff(time))))
        axes[0].plot(run.milliseconds, defect / ML, label=run.name, **look)
        axes[1].plot(run.milliseconds, lost / ML, **look)
    axes[0].set_ylabel("through the wall\n[mL/s]")
    axes[1].set_ylabel("its sum over\ntime [mL]")
    return finish(figure, axes, names_of(runs))


def iterations(runs):
    """Means over a hundredth of the run each."""
    names = sorted({name for run in runs for name in run.history.columns if name.endswith("_iterations")})
    names = [name for name in names if any(name in run.history and run.history[name].max() > 1 for run in runs)]
    if not names:
        return None
    figure, axes = stacked(len(names), 1.0)
    for axis, name in zip(axes, names):
        for run, look in zip(runs, own_looks(runs)):
            if name in run.history:
                parts = np.array_split(np.arange(len(run.history.time)), min(100, len(run.history.time)))
                axis.plot([run.milliseconds[part].mean() for part in parts],
                          [run.history[name][part].mean() for part in parts], label=run.name, **look)
        axis.set_xlim(*(edge([edge(run.milliseconds) for run in runs]) for edge in (min, max)))
        axis.set_ylabel(name.removesuffix("_iterations"))
        axis.set_ylim(bottom=0)
    return finish(figure, axes, names_of(runs))


def cost(runs):
    """Wall time of each participant by its work, waiting left out; what is little is put together."""
    rows = [(f"{run.name}, {name}" if len(runs) > 1 else name, works) for run in runs
            for name, works in run.indicators.get("wall_s_by_work", {}).items()]
    if not rows:
        return None
    total = {}
    for _, works in rows:
        for work, seconds in works.items():
            if work not in ("waiting", "other"):
                total[work] = total.get(work, 0) + seconds
    shown = sorted(total, key=total.get, reverse=True)[:7]
    figure, axis = plt.subplots(figsize=(WIDTH, 1.0 + 0.32 * len(rows)))
    left = np.zeros(len(rows))
    for i, work in enumerate([*shown, "other"]):
        values = [sum(seconds for each, seconds in works.items() if each not in [*shown, "waiting"]) if work == "other"
                  else works.get(work, 0) for _, works in rows]
        axis.barh(range(len(rows)), values, left=left, color=colour(i), label=work, height=0.7)
        left += values
    axis.set_yticks(range(len(rows)), [name for name, _ in rows])
    axis.invert_yaxis()
    axis.grid(axis="y", visible=False)
    axis.set_xlabel("wall time [s], mean of the ranks, without waiting")
    figure.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, columnspacing=1.0)
    return figure


def trace_of_steps(runs):
    """Who works when, in two steps of a run with a trace that take as long as most do: a row for each rank."""
    file = runs[0].folder / "trace.json"
    if len(runs) > 1 or not file.exists():
        return None
    commands = [each for each in trace.slices(file) if trace.is_work(each)]
    first = trace.usual_step(commands)
    shown = [each for each in commands if each.step in (first, first + 1)]
    if not shown:
        return None
    rows = sorted({(each.who, each.rank) for each in commands})
    figure, axis = plt.subplots(figsize=(WIDTH, 1.0 + 0.3 * len(rows)))
    begin = min(each.begin for each in shown)
    for k, command in enumerate(trace.COMMANDS):
        own = [each for each in shown if each.what.split(":")[0] == command]
        axis.barh([rows.index((each.who, each.rank)) for each in own], [1e-3 * (each.end - each.begin) for each in own],
                  left=[1e-3 * (each.begin - begin) for each in own], height=0.7, color=colour(k), label=command)
    axis.set_yticks(range(len(rows)), [f"{who}, rank {rank}" for who, rank in rows])
    axis.invert_yaxis()
    axis.grid(axis="y", visible=False)
    axis.set_xlabel(f"wall time [ms] in the steps {first} and {first + 1}")
    figure.legend(loc="lower center", bbox_to_anchor=(0.55, 1.0), ncols=4, columnspacing=1.0)
    figure.tight_layout()
    return figure


# File, title in the page, function.
ALL = (("pv_loop", "Pressure-volume loop", pressure_volume_loop),
       ("volume_pressure", "Volume and pressure of the ventricle", volume_and_pressure),
       ("cavity", "Volume of the cavity", cavity),
       ("flows", "Flow through the valves", flows), ("budget", "Blood that passes the wall", budget),
       ("wall", "Wall", wall), ("iterations", "Iterations a step", iterations), ("cost", "Cost by part", cost),
       ("trace", "Who works when", trace_of_steps))
