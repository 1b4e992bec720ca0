"""Two beats on the smallest mesh: their indicators are those computed by hand from the history, a run restarted within
the second beat has the same, and one that is told to be periodic stops by itself."""
import csv
import json
import math
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "coupling"))
from launch import SOURCE, run_scene  # noqa: E402

SCENE = SOURCE / "tests/regression/small_heartbeat.yaml"
PERIOD = 0.8
STEP = ["time.step=0.8 ms"]  # coarse, so that two beats take seconds
ALLOWED = 3  # beats


def run(folder, out, *settings, restart=None):
    words = [word for setting in [*STEP, *settings] for word in ("--set", setting)]
    launch = run_scene(SCENE, folder, "--ranks", "1", "--out", out, *words, *(["--restart", restart] if restart else []))
    assert launch.code == 0, launch.output
    return launch.output


def table(folder):
    with open(folder / "history.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    number = {name: [float(row[name]) for row in rows] for name in rows[0] if name != "phase"}
    return [row["phase"] for row in rows], number


def by_hand(folder, beat):
    """The indicators of a beat, from the definitions; the valves of this scene do not chatter."""
    phase, x = table(folder)
    time, V, p = x["time [s]"], x["volume [m^3]"], x["mean_pressure [Pa]"]
    begin, end = (min(range(len(time)), key=lambda i: abs(time[i] - PERIOD * b)) for b in (beat - 1, beat))
    of_beat = slice(begin, end + 1)
    opens = next(i for i in range(begin + 1, end + 1) if phase[i] == "ejection") - 1  # the last row before it
    closes = next(i for i in range(opens + 1, end + 1) if phase[i + 1] != "ejection")
    fills = next(i for i in range(closes, end + 1) if phase[i + 1] == "filling")
    shut = opens  # of the mitral valve
    while shut > 0 and phase[shut] not in ("filling", "ejection"):
        shut -= 1
    EDV, ESV = max(V[begin : opens + 1]), min(V[opens : end + 1])

    def loss(i, f):
        return 100 * abs(V[i] - V[f]) / max(V[i], V[f])

    found = {"EDV_mL": EDV * 1e6, "ESV_mL": ESV * 1e6, "EF_percent": 100 * (EDV - ESV) / EDV,
             "ILI_C_percent": loss(shut, opens), "ILI_R_percent": loss(closes, fills),
             "p_max_mmHg": max(p[of_beat]) / 133.322387415, "activation_time_ms": 1e3 * x["activation_time [s]"][end],
             "J_min": min(x["min_J"][of_beat]), "wall_volume_min_percent": 100 * min(x["wall_volume"][of_beat]),
             "clamped_share_max_percent": 100 * max(x["clamped_share"][of_beat]),
             "aortic_opens_ms": 1e3 * (time[opens] - time[begin]), "aortic_closes_ms": 1e3 * (time[closes] - time[begin]),
             "mitral_opens_ms": 1e3 * (time[fills] - time[begin])}
    if beat > 1:
        found["mitral_closes_ms"] = 1e3 * (time[shut] - time[begin])
    return found


def indicators(folder):
    return json.loads((folder / "indicators.json").read_text())


class Beats(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = Path(temporary.name)
        # EDV, ESV and p_max of this scene change by one percent from the first beat to the second
        cls.periodic = [f"time.beats={ALLOWED}", "until_periodic=3 %", "checkpoint.every=160 ms", "checkpoint.keep=100"]
        cls.text = run(cls.folder, "out", *cls.periodic)
        cls.found = indicators(cls.folder / "out")

    def test_indicators_of_both_beats_are_those_computed_by_hand(self):
        self.assertGreaterEqual(len(self.found["beats"]), 2)
        for number in (1, 2):
            beat = self.found["beats"][number - 1]
            self.assertEqual((beat["beat"], beat["complete"]), (number, True))
            for name, value in by_hand(self.folder / "out", number).items():
                self.assertTrue(math.isfinite(value), name)
                self.assertAlmostEqual(beat[name], value, delta=1e-9 * abs(value) + 1e-9, msg=f"{name} of beat {number}")

    def test_the_second_beat_has_all_phases_and_ejects(self):
        second = self.found["beats"][1]
        names = [phase["name"] for phase in second["phases"]]
        order = [names.index(name) for name in ("isovolumetric contraction", "ejection", "isovolumetric relaxation")]
        self.assertEqual(order, sorted(order))
        self.assertIn("filling", names[order[-1] :])
        self.assertGreater(second["EF_percent"], 30)
        self.assertGreater(second["ILI_C_percent"], 0)

    def test_what_is_at_the_top_is_of_the_last_beat(self):
        last = self.found["beats"][-1]
        for name in ("EF_percent", "p_max_mmHg", "ILI_C_percent", "J_min", "activation_time_ms"):
            self.assertEqual(self.found[name], last[name])

    def test_it_stops_by_itself_when_it_is_periodic(self):
        self.assertLess(len(self.found["beats"]), ALLOWED)
        self.assertIn("periodic: the last complete beat differs from the one before by EDV ", self.text)
        for name, percent in self.found["beats"][-1]["change_percent"].items():
            self.assertLess(percent, 3, name)
        steps = self.found["steps"]
        self.assertTrue((self.folder / f"out/checkpoints/{steps:06}/manifest.json").exists())

    def test_progress_and_rows_know_the_beat(self):
        self.assertIn(f"beat 2 of {ALLOWED}", self.text)
        self.assertRegex(self.text, r"beat 1  EDV_mL .* ESV_mL .*\n(.*\n)*.*beat 2  EDV_mL ")

    def test_a_restart_within_the_second_beat_ends_with_the_same_indicators(self):
        run(self.folder, "again", *self.periodic, restart="out/checkpoints/001400")  # 1.12 s
        self.assertEqual((self.folder / "again/history.csv").read_bytes(), (self.folder / "out/history.csv").read_bytes())
        again = indicators(self.folder / "again")
        self.assertEqual(again["beats"], self.found["beats"])

    def test_a_run_that_does_not_become_periodic_says_so_with_its_values(self):
        steps = self.found["steps"] - 40
        text = run(self.folder, "never", "time.beats=2", "until_periodic=0.01 %",
                   restart=f"out/checkpoints/{steps // 200 * 200:06}")
        self.assertIn("not periodic within 'time.beats: 2': the last complete beat differs from the one before by EDV ", text)
        self.assertIn("less than 0.01 % was wanted", text)
        self.assertEqual(len(indicators(self.folder / "never")["beats"]), 2)


if __name__ == "__main__":
    unittest.main(verbosity=2)
