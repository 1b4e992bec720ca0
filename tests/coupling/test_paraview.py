"""Fields as ParaView finds them: one series over restarts, units, wall and blood that meet, and the state that opens all."""
import json
import runpy
import sys
import tempfile
import types
import unittest
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import h5py
import numpy as np
from launch import SOURCE, Launch

PISTON = SOURCE / "configs/benchmarks/piston/efs1.yaml"
ELECTROMECHANICS = SOURCE / "configs/ideal_lv/electromechanics.yaml"


class Series:
    """A time series as its description has it, each table opened."""

    def __init__(self, file):
        self.times, self.fields, self.points = [], [], None
        for grid in ElementTree.parse(file).getroot().iter("Grid"):
            if grid.get("GridType") != "Uniform":
                continue
            self.times.append(float(grid.find("Time").get("Value")))
            self.points = self.table(file, grid.find("Geometry/DataItem"))
            self.table(file, grid.find("Topology/DataItem"))
            self.fields.append({each.get("Name"): self.table(file, each.find("DataItem")) for each in grid.findall("Attribute")})

    @staticmethod
    def table(file, item):
        name, place = item.text.split(":")
        with h5py.File(file.parent / name, "r") as opened:
            values = opened[place][:]
        assert list(values.shape) == [int(n) for n in item.get("Dimensions").split()], item.text
        return values


class Proxy(types.SimpleNamespace):
    """What a state gets of ParaView for a source, display or view; of a reader with what the file holds."""

    def __init__(self, FileNames=(), Input=None, **more):
        self.series = Series(Path(FileNames[0])) if FileNames else Input.series if isinstance(Input, Proxy) else None
        super().__init__(ClipType=types.SimpleNamespace(), **more)
        if self.series:
            self.TimestepValues = self.series.times
            if "Vectors" in more:
                assert more["Vectors"][1] in self.series.fields[0], more["Vectors"]
            self.PointData = {name: types.SimpleNamespace(
                GetNumberOfComponents=lambda v=values: v.shape[1], GetRange=lambda _, v=values: (v.min(), v.max()))
                for name, values in self.series.fields[0].items()}

    def __getattr__(self, name):
        if name == "GetDataInformation":
            points = self.series.points
            bounds = [edge for i in range(3) for edge in (points[:, i].min(), points[:, i].max())]
            return lambda: types.SimpleNamespace(GetBounds=lambda: bounds)
        return lambda *_, **__: None


def opened_by(state):
    """{name: series} that a state opens, and the fields by which it colours what it shows."""
    readers, coloured = {}, []

    def read(registrationName, FileNames):
        readers[registrationName] = Proxy(FileNames)
        return readers[registrationName]
    simple = types.ModuleType("paraview.simple")
    for name in ("AnnotateTimeFilter", "Clip", "WarpByVector", "GetActiveViewOrCreate", "GetAnimationScene", "GetColorTransferFunction",
                 "Hide", "Render", "ResetCamera"):
        setattr(simple, name, lambda *_, **given: Proxy(**given))
    simple.XDMFReader = read
    simple.Show = lambda source, _: source
    simple.ColorBy = lambda source, field: coloured.append(source.series.fields[0][field[1]].size and field[1])
    modules = {"paraview": types.ModuleType("paraview"), "paraview.simple": simple}
    sys.modules.update(modules)
    try:
        runpy.run_path(str(state))
    finally:
        for name in modules:
            del sys.modules[name]
    return {name: reader.series for name, reader in readers.items()}, coloured


class ParaView(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def run_well(self, scene, *words):
        launch = Launch([sys.executable, SOURCE / "tools/launch.py", scene, "--ranks", "1", "--oversubscribe", "--out", "out", *words],
                        self.folder)
        self.assertEqual(launch.code, 0, launch.output)
        return opened_by(self.folder / "out/paraview_state.py")

    def test_one_series_over_restarts_in_which_wall_and_blood_meet(self):
        for end, restart in ((4, []), (6, ["--restart", "latest"]), (8, ["--restart", "4 ms"])):
            series, coloured = self.run_well(PISTON, "--set", f"time.end={end} ms", "--set", "output.every=1 ms", *restart)
        self.assertEqual(sorted(series), ["blood", "wall"])
        self.assertEqual(coloured, ["active_tension [Pa]", "velocity [m/s]"])
        wall, blood = series["wall"], series["blood"]
        for each in series.values():
            np.testing.assert_allclose(each.times, 1e-3 * np.arange(9), atol=1e-12)
        self.assertEqual(set(blood.fields[0]), {"velocity [m/s]", "pressure [Pa]", "motion [m]"})
        self.assertEqual(set(wall.fields[0]), {"displacement [m]", "active_tension [Pa]", "fibre_stretch", "fibres"})
        place = {tuple(point): k for k, point in enumerate(np.round(1e9 * wall.points))}
        common = [(place[tuple(point)], k) for k, point in enumerate(np.round(1e9 * blood.points)) if tuple(point) in place]
        on_wall, on_blood = np.transpose(common)
        self.assertGreater(len(common), 3)
        for k in range(9):
            moved = wall.fields[k]["displacement [m]"][on_wall]
            np.testing.assert_allclose(blood.fields[k]["motion [m]"][on_blood], moved, atol=1e-12)
        self.assertGreater(np.abs(moved).max(), 1e-6)
        self.the_films_of_these_fields_are_whole()

    def the_films_of_these_fields_are_whole(self):
        pictures = Launch([sys.executable, SOURCE / "tools/pictures.py", "out", "--films", "--times", "4"], self.folder)
        if pictures.code and "pictures need" in pictures.output:  # VTK, or a display
            return
        self.assertEqual(pictures.code, 0, pictures.output)
        films = json.loads((self.folder / "out/report/films.json").read_text())
        self.assertEqual({name: len(set(frames)) > 1 for name, frames in films["frames"].items()},
                         {"displacement": True, "fibres": True, "velocity": True, "pressure": True})
        self.assertEqual({len(frames) for frames in films["frames"].values()}, {9})

    def test_electromechanics_alone_has_its_fields_and_the_volume_of_its_cavity(self):
        series, coloured = self.run_well(ELECTROMECHANICS, "--set", "mesh=MXS", "--set", "refinements=0", "--set", "time.end=2 ms",
                                         "--set", "output.every=1 ms")
        self.assertEqual(sorted(series), ["activation", "electrophysiology", "wall"])
        self.assertEqual(coloured, ["active_tension [Pa]", "potential [V]", "activation_time [s]"])
        self.assertEqual(set(series["electrophysiology"].fields[0]), {"potential [V]", "calcium [uM]"})
        self.assertEqual(len(series["wall"].times), 3)
        self.assertIn("cavity_volume [m^3]", (self.folder / "out/history.csv").read_text())
        self.assertIn("Volume of the cavity", (self.folder / "out/report/report.html").read_text())


if __name__ == "__main__":
    unittest.main(verbosity=2)
