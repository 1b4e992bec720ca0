"""Films of a run: frames of the same instants from several fields, as one JSON file that a page plays."""
import base64
import io
import json

import numpy as np
import vtk
from PIL import Image

from rendering import (actor, arrows, bounds, lattice, milliseconds, moved_bounds, opened, plt, render, section, streamlines, surface,
                       thinned, warped)
from results import MMHG

SIZE = (300, 440)  # pixels of a frame
N_FRAMES = 41      # at most


def encoded(image):
    """An RGB image as text that stands in a page."""
    file = io.BytesIO()
    Image.fromarray(image).save(file, "WEBP", quality=80)
    return "data:image/webp;base64," + base64.b64encode(file.getvalue()).decode()


class Follower:
    """Moves points of one mesh as the nodes of another, coarser one around them move."""

    def __init__(self, points, series):
        grid, locator = series.grid(), vtk.vtkStaticCellLocator()
        locator.SetDataSet(grid)
        locator.BuildLocator()
        cell, weights, place = vtk.vtkGenericCell(), [0.0] * 27, [0.0] * 3
        n = series.cells.shape[1]
        self.nodes = np.zeros((len(points), n), dtype=int)
        self.weights = np.zeros((len(points), n))
        tolerance = (1e-3 * np.linalg.norm(series.points.max(0) - series.points.min(0)))**2
        for k, x in enumerate(points):
            found = locator.FindCell(x, tolerance, cell, place, weights)
            if found >= 0:
                self.nodes[k], self.weights[k] = series.cells[found], weights[:n]
            else:  # outside by rounding of a curved surface: as the nearest node
                self.nodes[k, 0] = np.argmin(((series.points - x)**2).sum(1))
                self.weights[k, 0] = 1

    def __call__(self, values):
        return np.einsum("ki,kic->kc", self.weights, values[self.nodes])


class Film:
    """Frames of one quantity with its scale; `draw(time)` returns the actors."""

    def __init__(self, label, limits, colours, box, draw):
        self.label, self.limits, self.colours, self.box, self.draw = label, limits, colours, box, draw

    def frame(self, time):
        return encoded(render(self.draw(time), self.box, SIZE))

    def scale(self):
        colours = [matplotlib_hex(self.colours, x) for x in np.linspace(0, 1, 9)]
        return {"label": self.label, "low": f"{self.limits[0]:.3g}", "high": f"{self.limits[1]:.3g}", "colours": colours}


def matplotlib_hex(colours, x):
    return "#" + "".join(f"{int(255 * c):02x}" for c in plt.get_cmap(colours)(x)[:3])


def largest(series, name, times, measure):
    return max(float(measure(series.field(name, series.nearest(time)))) for time in times)


def wall_films(series, times):
    """Potential, calcium and displacement on the moving wall."""
    ep, mech = series.get("ep"), series.get("mech")
    films, box = {}, bounds((ep or mech).points)
    if mech:
        moved = np.concatenate([mech.points + mech.field("displacement", mech.nearest(time)) for time in times])
        box = bounds(np.concatenate([moved, mech.points]))
    if ep:
        follow = Follower(ep.points, mech) if mech else None

        def electric(name, factor, limits, colours):
            def draw(time):
                i = ep.nearest(time)
                d = follow(mech.field("displacement", mech.nearest(time))) if follow else np.zeros_like(ep.points)
                grid = opened(ep.grid(i, value=factor * ep.field(name, i), d=d))
                return [actor(surface(warped(grid, "d")), "value", limits, colours)]
            return draw
        highest = max(0.1, largest(ep, "calcium", times, np.max))
        films["potential"] = Film("potential [mV]", (-90, 40), "inferno", box, electric("potential", 1e3, (-90, 40), "inferno"))
        films["calcium"] = Film("calcium [µM]", (0, highest), "viridis", box, electric("calcium", 1, (0, highest), "viridis"))
    if mech:
        most = max(0.1, largest(mech, "displacement", times, lambda d: 1e3 * np.linalg.norm(d, axis=1).max()))

        def displaced(time):
            d = mech.field("displacement", mech.nearest(time))
            grid = opened(mech.grid(d=d, size=1e3 * np.linalg.norm(d, axis=1)))
            return [actor(surface(warped(grid, "d")), "size", (0, most), "cividis", edges=True)]
        films["displacement"] = Film("displacement [mm]", (0, most), "cividis", box, displaced)
        if mech.has("fibres"):
            films["fibres"] = fibre_film(mech, times, box)
    return films


def fibre_film(mech, times, box):
    """Streamlines of the fibres on the moving wall, by the tension that they hold."""
    size = np.ptp(mech.points, axis=0).max()
    most = max(0.1, largest(mech, "active_tension", times, lambda tension: 1e-3 * tension.max()))

    def draw(time):
        i = mech.nearest(time)
        grid = opened(mech.grid(fibre=mech.field("fibres", 0), d=mech.field("displacement", i),
                                tension=1e-3 * mech.field("active_tension", i)))
        lines = streamlines(grid, "fibre", thinned(grid, 500), 0.2 * size, 0.005 * size)
        return [actor(surface(warped(grid, "d")), colour=(0.93, 0.88, 0.86), opacity=0.15),
                actor(warped(lines, "d"), "tension", (0, most), "plasma")]
    return Film("fibres: tension [kPa]", (0, most), "plasma", box, draw)


def blood_films(fluid, times):
    """Velocity with streamlines and arrows, and the pressure less its mean, in the section y = 0."""
    fastest = max(0.01, largest(fluid, "velocity", times, lambda u: np.percentile(np.linalg.norm(u, axis=1), 99.8)))
    spreads = [np.percentile(abs(p - np.median(p)), 99) for p in (fluid.field("pressure", fluid.nearest(t)) for t in times)]
    spread = max(0.01, np.percentile(spreads, 90) / MMHG)  # not of the instants at which valves switch
    box = moved_bounds(fluid, {fluid.nearest(time) for time in times})

    def velocity(time):
        i = fluid.nearest(time)
        u = fluid.field("velocity", i)
        grid = fluid.grid(i, "motion", u=u, speed=np.linalg.norm(u, axis=1))
        spacing = (box[1][2] - box[0][2]) / 22
        pointing = arrows(lattice(grid, spacing, box), "u", 2.3 * spacing / fastest)
        lines = streamlines(grid, "u", lattice(grid, 2 * spacing, box), 6 * spacing, 0.04 * spacing)
        return [actor(section(grid), "speed", (0, fastest), "YlGnBu"), actor(lines, colour=(0.45, 0.45, 0.45)),
                actor(pointing, colour=(0.1, 0.1, 0.1))]

    def pressure(time):
        i = fluid.nearest(time)
        p = fluid.field("pressure", i)
        return [actor(section(fluid.grid(i, "motion", p=(p - np.median(p)) / MMHG)), "p", (-spread, spread), "coolwarm")]
    return {"velocity": Film("speed [m/s]", (0, fastest), "YlGnBu", box, velocity),
            "pressure": Film("pressure less its median [mmHg]", (-spread, spread), "coolwarm", box, pressure)}


def instants(series, history):
    """Of the last whole beat, or of what there is; as many as a film has frames."""
    times = max((each.times for name, each in series.items() if name != "activation"), key=len)
    times = times[np.linspace(0, len(times) - 1, min(N_FRAMES, len(times))).round().astype(int)]
    phases = history.phases()
    names = [next((name for name, begin, end in phases if begin <= time <= end), "") for time in times]
    return times, [f"{milliseconds(time)[4:]} {name.replace('isovolumetric', 'isovol.')}".strip() for time, name in zip(times, names)]


def write(series, history, path):
    """`path`: captions of all instants, frames and scale of each film."""
    if not set(series) - {"activation"}:
        return
    times, captions = instants(series, history)
    films = wall_films(series, times) if {"ep", "mech"} & set(series) else {}
    if "fluid" in series:
        films.update(blood_films(series["fluid"], times))
    frames = {name: [film.frame(time) for time in times] for name, film in films.items()}
    path.write_text(json.dumps({"captions": captions, "frames": frames, "scales": {k: f.scale() for k, f in films.items()}}))
    print(path)
