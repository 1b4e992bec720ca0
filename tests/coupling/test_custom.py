"""A scheme that a scene says itself: the lines that a run prints give the very same run; a line that does not fit is refused
at its place before the first step."""
import re
import tempfile
import textwrap
import unittest
from pathlib import Path

from launch import BIN, SOURCE, Launch, run_scene

PISTON = SOURCE / "configs/benchmarks/piston/efs1.yaml"


def custom(folder, lines):
    """A scene of the piston whose scheme is these lines."""
    file = Path(folder) / "scene.yaml"
    file.write_text(f"base: {PISTON}\ncoupling:\n  scheme: custom\n  sequence:\n"
                    + textwrap.indent(textwrap.dedent(lines), "    ") + "\n")
    return file


def printed(output):
    """What a run prints of its scheme."""
    return re.search(r"the scheme \S+ is\n((?: +.*\n)+)", output)[1]


class Custom(unittest.TestCase):
    def run_of(self, folder, scene, out, *settings):
        words = [word for setting in settings for word in ("--set", setting)]
        launch = run_scene(scene, folder, "--ranks", "1", "--out", out, *words)
        self.assertEqual((launch.code, launch.orphans), (0, []), launch.output)
        return launch.output, (Path(folder) / out / "history.csv").read_text()

    def test_the_lines_that_a_run_prints_give_the_same_run(self):
        with tempfile.TemporaryDirectory() as folder:
            output, history = self.run_of(folder, PISTON, "ours", "time.end=4 ms", "scheme=E1FS", "iterations=30",
                                          "coupling.tolerance=1e-8")
            again, same = self.run_of(folder, custom(folder, printed(output)), "custom", "time.end=4 ms")
            self.assertEqual(same, history)
            self.assertEqual(printed(again), printed(output))
            self.assertEqual(self.run_of(folder, Path(folder) / "custom/scene.resolved.yaml", "resolved")[1], history)

    def test_the_scene_that_writes_out_efs1_is_efs1(self):
        with tempfile.TemporaryDirectory() as folder:
            histories = [self.run_of(folder, SOURCE / f"configs/ideal_lv/{name}.yaml", name, "mesh=MXS", "time.end=4 ms",
                                     "output.every=0 ms")[1] for name in ("efs1", "custom")]
            self.assertEqual(*histories)

    def test_a_line_that_does_not_fit_is_refused_at_its_place_before_the_first_step(self):
        right = ["displacement mech->ale", "solve ale", "mesh_motion ale->fluid", "prepare mech", "wall_velocity mech->fluid",
                 "wall_force mech->fluid", "solve fluid", "blood_force fluid->mech", "solve mech", "commit mech", "commit ale",
                 "commit fluid"]
        for lines, wrong, code, message in (
                (["slove", *right], "slove", 2, "'slove' is no line of a sequence; those are 'solve P'"),
                (["solve mehc", *right], "solve mehc", 2, "has no participant 'mehc'; did you mean 'mech'? It has ale, fluid, mech"),
                (["wall_farce mech->fluid", *right], "wall_farce mech->fluid", 3,
                 "'wall_farce' from mech to fluid (mech declares no such output; did you mean 'wall_force'?)"),
                ([line for line in right if line != "blood_force fluid->mech"], "solve mech", 3,
                 "'mech' is solved before it has received 'blood_force': 'blood_force fluid->mech' comes first")):
            with self.subTest(message), tempfile.TemporaryDirectory() as folder:
                scene = custom(folder, "once: [held mech->fluid]\nstart: [inflate mech]\nstep:\n" + "\n".join("- " + line for line in lines))
                text = scene.read_text().splitlines()
                place = max(k for k, line in enumerate(text, 1) if line.strip().startswith("- " + wrong))
                if code == 2:  # seen without a launch
                    launch = Launch([BIN / "coupler", scene, "--validate"], folder)
                else:
                    launch = run_scene(scene, folder, "--ranks", "1", "--out", "out")
                self.assertEqual((launch.code, launch.orphans), (code, []), launch.output)
                self.assertIn(f"scene.yaml:{place}: ", launch.output)
                self.assertIn(message, launch.output)
                self.assertFalse((Path(folder) / "out/history.csv").exists())


if __name__ == "__main__":
    unittest.main(verbosity=2)
