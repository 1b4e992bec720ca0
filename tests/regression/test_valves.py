"""Valves that switch by the paper's rule alone, without blanking: four phases in order, nothing flows back."""
import csv
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "coupling"))
from launch import SOURCE, run_scene  # noqa: E402

HEARTBEAT = SOURCE / "tests/regression/small_heartbeat.yaml"
PHASES = ["isovolumetric contraction", "ejection", "isovolumetric relaxation", "filling"]
AFTER = ["diastasis", "isovolumetric contraction"]  # when the mitral valve has closed: of the next beat
FLOW = {"ejection": "aortic_flow [m^3/s]", "filling": "mitral_flow [m^3/s]"}
MERGED = "participants: {mech: , fluid: , fsi: {program: fsi_solver, ranks: 1}, ep: {program: replay, ranks: 1, " \
         "settings: {file: calcium.h5}}}\ncoupling: {scheme: E1FSinf}\n"
PARTITIONED = "participants: {ep: {program: replay, ranks: 1, settings: {file: calcium.h5}}}\n"
ML = 1e-6


class Valves(unittest.TestCase):
    """EFS1 beats with its own electrophysiology, the others with its calcium."""

    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = Path(temporary.name)
        scenes = {"EFS1": HEARTBEAT, "EFS1-corrected": cls.scene("corrected", PARTITIONED + "coupling: {scheme: EFS1-corrected}\n"),
                  "E1FSinf": cls.scene("merged", MERGED)}
        record = ["--record", "calcium=calcium.h5"]
        cls.beats = {}
        for name, scene in scenes.items():
            settings = ["--set", "valve_blanking=0 s", "--set", "checkpoint.every=0 ms"]
            launch = run_scene(scene, cls.folder, "--ranks", "1", "--out", name, *settings, *record)
            assert launch.code == 0, launch.output
            record = []
            with open(cls.folder / name / "history.csv", encoding="utf-8") as file:
                cls.beats[name] = list(csv.DictReader(file))

    @classmethod
    def scene(cls, name, text):
        path = cls.folder / f"{name}.yaml"
        path.write_text(f"base: {HEARTBEAT}\nscene: {name}\n{text}")
        return path

    def test_pass_four_phases_in_order_and_each_once(self):
        for scheme, rows in self.beats.items():
            phases = [row["phase"] for row in rows]
            changes = [phase for n, phase in enumerate(phases) if n == 0 or phase != phases[n - 1]]
            self.assertGreaterEqual(len(changes), 4, scheme)
            self.assertEqual(changes, (PHASES + AFTER)[: len(changes)], scheme)

    def test_let_nothing_back_from_opening_to_the_decision_to_close(self):
        for scheme, rows in self.beats.items():
            for phase, column in FLOW.items():
                flow = [float(row[column]) / ML for row in rows if row["phase"] == phase]
                self.assertGreater(len(flow), 100, scheme)
                # the last step is the one that decides: its flow is the first that is not forward
                self.assertGreater(min(flow[:-1]), -0.1, f"{scheme}, {phase}")

    def test_the_corrected_scheme_keeps_the_volume_through_all_switches(self):
        loss = [float(row["volume_loss"]) for row in self.beats["EFS1-corrected"][1:]]
        self.assertLess(max(loss), 1e-9)


if __name__ == "__main__":
    unittest.main(verbosity=2)
