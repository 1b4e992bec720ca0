"""A wrong scene ends the whole launch within seconds: one message with its place, the right exit code, nobody left."""

import tempfile
import unittest
from pathlib import Path

from launch import BIN, Launch

SECONDS = 5

# (what is wrong, scene, exit code, parts of the message)
BAD_SCENES = [
    ("unknown key", "time:\n  edn: 1 ms\n", 2,
     ["scene.yaml:2: key 'time.edn' is unknown; did you mean 'end'?", "Allowed here: end, beats, until_periodic, step"]),
    ("unknown block", "time: {end: 1 ms}\ncuopling: {}\n", 2,
     ["scene.yaml:2: key 'cuopling' is unknown; did you mean 'coupling'?"]),
    ("missing unit", "coupling:\n  scheme: EFS1\n  alpha: 5000\n", 2,
     ["scene.yaml:3: key 'coupling.alpha': '5000' has no unit; write e.g. '5000 kg/(m^2 s)'"]),
    ("wrong unit", "time:\n  end: 10 mmHg\n", 2,
     ["scene.yaml:2: key 'time.end': expected a time-like unit, e.g. s; got mmHg"]),
    ("unknown unit", "time:\n  end: 10 msec\n", 2, ["scene.yaml:2:", "unit 'msec' is unknown"]),
    ("out of range", "time: {end: 1 ms}\ncoupling: {alpha: -1 kg/(m^2 s)}\n", 2,
     ["scene.yaml:2: key 'coupling.alpha': -1 kg/(m^2 s) is out of range; allowed: above 0 kg/(m^2 s)"]),
    ("unknown choice", "coupling: {scheme: EFS2}\n", 2,
     ["scene.yaml:1: key 'coupling.scheme': 'EFS2' is not a choice; did you mean 'EFS1'?"]),
    ("duplicate key", "time:\n  end: 1 ms\n  end: 2 ms\n", 2,
     ["scene.yaml:3: key 'end' is given twice; first at"]),
    ("missing base file", "base: nowhere.yaml\n", 8, ["scene.yaml:1: the base file", "nowhere.yaml' does not exist"]),
    ("not YAML", "time: {end: 1 ms\n", 2, ["scene.yaml:", "this is not YAML"]),
    ("blocks that do not fit", "time: {end: 1 ms, step: 0.3 ms}\n", 2, ["scene.yaml:1: key 'time.step': must divide"]),
    ("an end that is not that of the beats", "time:\n  end: 1 s\n  beats: 2\n", 2,
     ["scene.yaml:2: key 'time.end': is 1 s, but 'beats: 2' of 0.8 s (electrophysiology.stimulus.period) end at 1.6 s"]),
    ("nothing to compare", "time: {until_periodic: 1 %}\n", 2,
     ["scene.yaml:1: key 'time.until_periodic': compares beats: it needs 'beats', the most that are allowed, two at"]),
    ("too few programs for a scheme", "participants: {mech: {}, fluid: {}}\n", 2, ["'mech' and 'fluid' need 'ale'"]),
]


def whole_launch(*coupler_arguments, programs=("ep_solver", "mech_solver", "ale_solver", "fluid_solver")):
    command = ["mpirun", "--oversubscribe", "-n", "1", BIN / "coupler", *coupler_arguments]
    for program in programs:
        command += [":", "-n", "1", BIN / program]
    return command


class BadInput(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.scene = Path(self.folder.name) / "scene.yaml"

    def tearDown(self):
        self.folder.cleanup()

    def expect(self, launch, code, parts):
        self.assertEqual(launch.code, code, launch.output)
        for part in parts:
            self.assertIn(part, launch.output)
        self.assertLess(launch.seconds, SECONDS)
        self.assertEqual(launch.orphans, [])

    def test_each_bad_scene_is_refused_before_anything_starts(self):
        for title, text, code, parts in BAD_SCENES:
            with self.subTest(title):
                self.scene.write_text(text)
                self.expect(Launch([BIN / "coupler", "scene.yaml", "--validate"], self.folder.name), code, parts)

    def test_a_whole_launch_ends_with_the_same_message_once(self):
        for title, text, code, parts in BAD_SCENES[:2]:
            with self.subTest(title):
                self.scene.write_text(text)
                launch = Launch(whole_launch("scene.yaml"), self.folder.name)
                self.expect(launch, code, parts)
                self.assertEqual(launch.output.count(parts[0]), 1, launch.output)

    def test_a_missing_scene_is_named(self):
        self.expect(Launch([BIN / "coupler", "nowhere.yaml", "--validate"], self.folder.name), 8,
                    ["nowhere.yaml: this scene file cannot be read"])

    def test_an_absent_program_is_named_with_the_nearest(self):
        self.scene.write_text("participants:\n  ep: {program: epsolver}\ncoupling: {scheme: one_way}\n")
        self.expect(Launch([BIN / "coupler", "scene.yaml", "--launch-line"], self.folder.name), 2,
                    ["'participants.ep.program': there is no executable 'epsolver'; did you mean 'ep_solver'?"])

    def test_a_wrong_setting_is_named(self):
        self.scene.write_text("scene: settings\n")
        self.expect(Launch([BIN / "coupler", "scene.yaml", "--validate", "--set", "alhpa=1"], self.folder.name), 2,
                    ["--set alhpa: the key is unknown; did you mean 'alpha'?"])

    def test_a_participant_that_nobody_expects_is_named(self):
        self.scene.write_text("participants: {ep: {ranks: 1}}\ncoupling: {scheme: one_way}\n")
        launch = Launch(whole_launch("scene.yaml", programs=("ep_solver", "ale_solver")), self.folder.name)
        self.expect(launch, 3, ["ale"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
