"""A launch from scene to results, with electrophysiology alone as the smallest of all casts."""
import csv
import json
import re
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

from launch import BIN, SOURCE, Launch, run_scene

SCENE = """
scene: small
time: {end: 4 ms, step: 0.2 ms}
coupling: {scheme: one_way}
participants: {ep: {ranks: 1}}
geometry: {mesh: MXS}
output: {every: 1 ms}
"""


def history(folder):
    with open(folder / "history.csv", encoding="utf-8") as file:
        return list(csv.DictReader(file))


class Launches(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = Path(self.temporary.name)
        (self.folder / "scene.yaml").write_text(SCENE)

    def tearDown(self):
        self.temporary.cleanup()

    def test_a_solver_does_not_load_what_deal_ii_has_for_cad(self):
        for program in ("ep_solver", "mech_solver", "ale_solver", "fluid_solver", "fsi_solver"):
            loaded = subprocess.run(["ldd", BIN / program], stdout=subprocess.PIPE, text=True, check=True).stdout
            self.assertIn("libdeal.ii", loaded)
            self.assertNotRegex(loaded, "libTKV3d|libfltk|libjasper")  # which OpenCASCADE, Gmsh and Gmsh need
            for name, path in re.findall(r"(libTK\w+|libgmsh|libassimp)[.\d so]* => (\S+)", loaded):
                self.assertTrue(Path(path).resolve().parent.match("heartbus"), f"{name} of {program} is {path}")

    def test_every_scene_of_the_project_is_valid(self):
        for scene in sorted(set(SOURCE.glob("configs/**/*.yaml")) - set(SOURCE.glob("configs/studies/*"))):
            with self.subTest(scene.name):
                launch = Launch([BIN / "coupler", scene, "--validate"], self.folder)
                self.assertEqual(launch.code, 0, launch.output)

    def test_the_results_of_a_run_are_complete(self):
        launch = run_scene("scene.yaml", self.folder)
        self.assertEqual(launch.code, 0, launch.output)
        results = self.folder / "results/small"
        rows = history(results)
        self.assertEqual([int(row["step"]) for row in rows], list(range(21)))
        self.assertAlmostEqual(float(rows[-1]["time [s]"]), 4e-3)
        indicators = json.loads((results / "indicators.json").read_text())
        self.assertEqual(indicators["steps"], 20)
        self.assertEqual(list(indicators["wall_s_by_part"]), ["ep"])
        works = indicators["wall_s_by_work"]["ep"]
        self.assertLessEqual({"ionic model", "assembly", "linear solve", "other", "bus", "waiting"}, set(works))
        self.assertGreater(works["other"], 0)
        self.assertAlmostEqual(sum(works.values()), sum(indicators["wall_s_by_command"]["ep"].values()), 3)
        self.assertLess(indicators["cpu_s_by_part"]["ep"], indicators["cpu_s"])
        self.assertTrue((results / "logs/coupler.log").stat().st_size > 0)

    def test_the_resolved_scene_resolves_to_itself(self):
        launch = run_scene("scene.yaml", self.folder, "--set", "time.end=0.2 ms")
        resolved = self.folder / "results/small/scene.resolved.yaml"
        self.assertIn("2e-04 s", resolved.read_text(), launch.output)
        (self.folder / "again.yaml").write_text(resolved.read_text())
        run_scene("again.yaml", self.folder, "--out", "again")
        self.assertEqual((self.folder / "again/scene.resolved.yaml").read_text(), resolved.read_text())

    def test_a_signal_ends_the_run_soon_with_complete_results(self):
        csv_file = self.folder / "results/small/history.csv"

        def stop(process):
            deadline = time.monotonic() + 30
            while time.monotonic() < deadline and not (csv_file.exists() and csv_file.read_text().count("\n") > 5):
                time.sleep(0.02)
            process.send_signal(signal.SIGUSR1)

        launch = run_scene("scene.yaml", self.folder, "--set", "time.end=20 s", during=stop)
        self.assertEqual(launch.code, 0, launch.output)
        self.assertEqual(launch.orphans, [])
        self.assertIn("stopped on request", launch.output)
        indicators = json.loads((csv_file.parent / "indicators.json").read_text())
        self.assertEqual(indicators["steps"] + 1, len(history(csv_file.parent)))

    def test_the_defaults_that_are_printed_are_a_scene(self):
        text = subprocess.run([BIN / "coupler", "--print-defaults"], stdout=subprocess.PIPE, check=True).stdout
        (self.folder / "defaults.yaml").write_bytes(text)
        launch = Launch([BIN / "coupler", "defaults.yaml", "--validate"], self.folder)
        self.assertEqual(launch.code, 0, launch.output)

    def test_programs_tell_the_version_of_the_project(self):
        version = re.search(r"project\(heartbus VERSION ([\d.]+)", (SOURCE / "CMakeLists.txt").read_text())[1]
        for program in ("coupler", "ep_solver", "replay"):
            launch = Launch([BIN / program, "--version"], self.folder)
            self.assertEqual(launch.code, 0, launch.output)
            self.assertRegex(launch.output, rf"{program} \(heartbus {version}, compiler .*\), protocol \d+")


if __name__ == "__main__":
    unittest.main(verbosity=2)
