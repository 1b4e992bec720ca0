#!/usr/bin/python3
"""Pictures of a run from its fields: fibres, electric potential, blood flow and pressure, deformation.

    tools/pictures.py results/ideal_lv_efs1 [--times 30 60 100 300] [--out FOLDER]
    tools/pictures.py --flow E1FSinf=results/ideal_lv_e1fsinf EFS1=results/ideal_lv_efs1 --out FOLDER

VTK renders the bodies off screen, matplotlib adds titles and colour bars. Without a display it restarts under xvfb-run.
"""
import argparse
import os
import shutil
import sys
from pathlib import Path

import numpy as np

try:
    import vtk

    import films
except ImportError as error:
    sys.exit(f"pictures need VTK and h5py for Python, and one is missing ({error}); in Debian: python3-vtk9, python3-h5py")

from rendering import (Series, actor, arrows, bounds, compose, compose_rows, drawn_inwards, far_half, lattice, line, milliseconds,
                       moved_bounds, opened, render, run, section, streamlines, surface, thinned, values_of, warped)
from results import MMHG, History, origin, resolved_scene

INK = (0.1, 0.1, 0.1)


def arrows_of(grid, box, fastest):
    """Of the velocity, on an even lattice; the fastest reach over two of its spacings."""
    spacing = (box[1][2] - box[0][2]) / 24
    return arrows(lattice(grid, spacing, box), "u", 2.3 * spacing / fastest)


def sides(folder):
    """Captions of a body from outside and cut open."""
    scene = resolved_scene(folder)
    is_heart = "ventric" in str(scene.get("geometry.shape", "")) or scene.get("fibres.rule", "file") not in ("constant", "file")
    return ("epicardium", "endocardium and section") if is_heart else ("surface", "section")


def long_axis(x):
    """Centre and direction: the principal axis around which a body is most alike. Its sense does not matter."""
    centre = x.mean(axis=0)
    spread, axes = np.linalg.eigh(np.cov((x - centre).T))
    return centre, axes[:, 2 if spread[1] - spread[0] < spread[2] - spread[1] else 0]


def helix_angle(f, x):
    """Of unit vectors that lie in a wall [degrees]: from the circumference, around the body's own long axis."""
    centre, axis = long_axis(x)
    across = np.cross(axis, x - centre)
    around = (f * across).sum(axis=1) / np.maximum(np.linalg.norm(across, axis=1), 1e-12)
    along = np.sqrt(np.maximum(1 - around**2, 0)) * np.sign(f @ axis)
    return np.degrees(np.arctan2(along * np.where(around < 0, -1, 1), abs(around)))


def picture_fibres(mech, captions, path):
    f, x = mech.field("fibres", 0), mech.points
    grid = mech.grid(0, fibre=f, angle=helix_angle(f, x))
    panels = []
    size = np.ptp(x, axis=0).max()
    lines = streamlines(grid, "fibre", thinned(drawn_inwards(grid, 0.1), 2000), 0.2 * size, 0.0035 * size)
    for half, along, caption in zip((grid, far_half(grid)), (lines, far_half(lines)), captions):
        panels.append((render([actor(surface(half), colour=(0.93, 0.88, 0.86), opacity=0.15),
                               actor(surface(along), "angle", (-60, 60), "coolwarm")], bounds(x)), caption))
    compose(panels, [("helix angle [degrees]", (-60, 60), "coolwarm", 0, 1)], "Fibres", path,
            mech.origin)


def picture_potential(ep, times, path):
    limits, panels = (-90, 40), []
    for instant in sorted({ep.nearest(time) for time in times}):
        wall = surface(opened(ep.grid(instant, v=1e3 * ep.field("potential", instant))))
        image = render([actor(wall, "v", limits, "inferno")], bounds(ep.points))
        panels.append((image, milliseconds(ep.times[instant])))
    bar = ("transmembrane potential [mV]", limits, "inferno", 0, len(panels) - 1)
    compose(panels, [bar], "Electric activity", path, ep.origin)


def picture_activation(activation, captions, path):
    times = 1e3 * activation.field("activation_time", 0)
    limits = (0, max(1.0, np.nanmax(times)))
    grid = activation.grid(0, t=np.where(np.isfinite(times), times, limits[1]))
    isochrones = vtk.vtkContourFilter()
    isochrones.SetInputArrayToProcess(0, 0, 0, 0, "t")
    isochrones.GenerateValues(int(limits[1] // 10), 10, 10 * (limits[1] // 10))
    panels = []
    for half, caption in zip((grid, far_half(grid)), captions):
        skin = surface(half)
        lines = line(run(isochrones, skin), (0.1, 0.1, 0.1), 1.5)
        panels.append((render([actor(skin, "t", limits, "viridis_r"), lines], bounds(activation.points)), caption))
    compose(panels, [("activation time [ms], a line every 10 ms", limits, "viridis_r", 0, 1)], "Activation", path,
            activation.origin)


def picture_flow(fluid, instant, what, path):
    u, p = fluid.field("velocity", instant), fluid.field("pressure", instant) / MMHG
    speed = np.linalg.norm(u, axis=1)
    fastest = max(np.ceil(20 * speed.max()) / 20, 0.05)
    low, high = np.percentile(p, [0.5, 99.5])
    limits = (low, max(high, low + 0.1))
    grid = fluid.grid(instant, "motion", u=u, speed=speed, p=p)
    cut, box = section(grid), moved_bounds(fluid, [instant])
    pointing = arrows_of(grid, box, fastest)
    velocity = [actor(cut, "speed", (0, fastest), "YlGnBu"), actor(pointing, colour=INK)]
    panels = [(render(velocity, box), "velocity"), (render([actor(cut, "p", limits, "viridis")], box), "pressure")]
    compose(panels, [("speed [m/s]", (0, fastest), "YlGnBu", 0, 0), ("pressure [mmHg]", limits, "viridis", 1, 1)],
            f"Blood in {what}, {milliseconds(fluid.times[instant])}", path, fluid.origin)


def picture_deformation(mech, times, path):
    instants = sorted({mech.nearest(time) for time in times})
    sizes = {i: 1e3 * np.linalg.norm(mech.field("displacement", i), axis=1) for i in instants}
    limits = (0, max(1.0, max(size.max() for size in sizes.values())))
    rest = run(vtk.vtkFeatureEdges(), surface(opened(mech.grid())))
    moved = np.concatenate([mech.points + mech.field("displacement", i) for i in instants] + [mech.points])
    panels = []
    for i in instants:
        d = mech.field("displacement", i)
        wall = surface(warped(opened(mech.grid(d=d, size=sizes[i])), "d"))  # the same half of the tissue always
        panels.append((render([actor(wall, "size", limits, "cividis", edges=True), line(rest, (0.75, 0.1, 0.1), 1.5)],
                              bounds(moved)), milliseconds(mech.times[i])))
    compose(panels, [("displacement [mm]; red: shape at rest", limits, "cividis", 0, len(panels) - 1)], "Deformation",
            path, mech.origin)


def picture_electric(ep, times, path):
    """Potential above, calcium below, at some instants."""
    limits, calcium_limits, rows = (-90, 40), (0, 1.2), [[], []]
    for instant in sorted({ep.nearest(time) for time in times}):
        grid = ep.grid(instant, v=1e3 * ep.field("potential", instant), c=ep.field("calcium", instant))
        wall, box = surface(opened(grid)), bounds(ep.points)
        rows[0].append((render([actor(wall, "v", limits, "inferno")], box), milliseconds(ep.times[instant])))
        rows[1].append((render([actor(wall, "c", calcium_limits, "viridis")], box), ""))
    last = len(rows[0]) - 1
    compose_rows(rows, [[("transmembrane potential [mV]", limits, "inferno", 0, last)],
                        [("intracellular calcium [µM]", calcium_limits, "viridis", 0, last)]], "Electric activity", path,
                 ep.origin)


def instants_of_flow(history):
    """(name, time) of three quarters of the contraction and of the largest flows."""
    found = [(name, begin + 0.75 * (end - begin)) for name, begin, end in history.phases()[:1]]
    for flow, name in (("aortic_flow", "ejection"), ("mitral_flow", "filling")):
        if flow in history and history[flow].max() > 0:
            found.append((name, history.time[np.argmax(history[flow])]))
    return found


def picture_flows(named_folders, path):
    """Velocity and pressure of several runs side by side, a row for each of contraction, ejection, filling."""
    runs = {name: Series(folder / "fields/fluid.h5") for name, folder in named_folders.items()}
    rows, bars, n = [], [], len(runs)
    for what, time in instants_of_flow(History(next(iter(named_folders.values())))):
        fields, boxes = {}, {}
        for name, fluid in runs.items():
            i = fluid.nearest(time)
            boxes[name] = moved_bounds(fluid, [i])
            u = fluid.field("velocity", i)
            fields[name] = fluid.grid(i, "motion", u=u, speed=np.linalg.norm(u, axis=1), p=fluid.field("pressure", i) / MMHG)
        speed = np.concatenate([values_of(grid, "speed") for grid in fields.values()])
        fastest = max(np.ceil(20 * np.percentile(speed, 99.8)) / 20, 0.05)
        low, high = np.percentile(np.concatenate([values_of(grid, "p") for grid in fields.values()]), [0.5, 99.5])
        limits = (low, max(high, low + 0.1))
        velocities, pressures = [], []
        for name, grid in fields.items():
            caption = f"{name}: {what.removeprefix('isovolumetric ')}, {milliseconds(runs[name].times[runs[name].nearest(time)])}"
            cut, box = section(grid), boxes[name]
            pointing = arrows_of(grid, box, fastest)
            velocities.append((render([actor(cut, "speed", (0, fastest), "YlGnBu"), actor(pointing, colour=INK)], box),
                               caption))
            pressures.append((render([actor(cut, "p", limits, "viridis")], box), caption))
        rows.append(velocities + pressures)
        bars.append([("speed [m/s]", (0, fastest), "YlGnBu", 0, n - 1),
                     ("pressure [mmHg]", limits, "viridis", n, 2 * n - 1)])
    compose_rows(rows, bars, "Velocity and pressure of the blood", path, origin(named_folders.values()))


def restart_with_display():
    if os.environ.get("DISPLAY"):
        return
    if not shutil.which("xvfb-run"):
        sys.exit("pictures need a display: set DISPLAY or install xvfb")
    os.execvp("xvfb-run", ["xvfb-run", "-a", "-s", "-screen 0 1280x1024x24 -noreset", sys.executable, __file__, *sys.argv[1:]])


def pictures_of(folder, times, out, with_films):
    """All pictures that the fields of a run allow."""
    series = {path.stem: Series(path) for path in sorted((folder / "fields").glob("*.h5"))}
    if with_films:
        films.write(series, History(folder), out / "films.json")
    if "mech" in series:
        if series["mech"].has("fibres"):
            picture_fibres(series["mech"], sides(folder), out / "fibres.png")
        picture_deformation(series["mech"], times, out / "deformation.png")
    if "ep" in series:
        picture_potential(series["ep"], times, out / "potential.png")
    if "activation" in series:
        picture_activation(series["activation"], sides(folder), out / "activation.png")
    if "fluid" in series:
        history = History(folder)
        for flow, what in (("aortic_flow", "ejection"), ("mitral_flow", "filling")):
            if flow in history and history[flow].max() > 0:
                peak = history.time[np.argmax(history[flow])]
                picture_flow(series["fluid"], series["fluid"].nearest(peak), what, out / f"{what}.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, help="results folder of a run")
    parser.add_argument("--flow", nargs="+", default=[], metavar="NAME=FOLDER", help="flow of several runs side by side")
    parser.add_argument("--electric", type=Path, metavar="FOLDER", help="potential and calcium of a run")
    parser.add_argument("--name", default="picture", help="of the picture of --flow and --electric")
    parser.add_argument("--times", nargs="+", type=float, default=[30, 60, 100, 300], metavar="MS",
                        help="instants of the potential and the deformation [ms]")
    parser.add_argument("--films", action="store_true", help="films.json, too, for report.html")
    parser.add_argument("--out", help="folder for the pictures; default: FOLDER/report")
    options = parser.parse_args()
    if not (options.out or options.folder):
        parser.error("a results folder is missing, or --out beside --flow or --electric")
    restart_with_display()
    times = [1e-3 * time for time in options.times]
    out = Path(options.out or options.folder / "report")
    out.mkdir(parents=True, exist_ok=True)
    if options.flow:
        picture_flows({name: Path(folder) for name, _, folder in (word.partition("=") for word in options.flow)},
                      out / f"{options.name}.png")
    if options.electric:
        picture_electric(Series(options.electric / "fields/ep.h5"), times, out / f"{options.name}.png")
    if options.folder:
        pictures_of(options.folder, times, out, options.films)


if __name__ == "__main__":
    main()
