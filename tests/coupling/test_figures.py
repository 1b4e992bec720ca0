"""What studies make of finished runs: choices, figures, errors and costs, borders, budgets."""
import json
import sys
import tempfile
import unittest
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

from launch import SOURCE

sys.path.insert(0, str(SOURCE / "tools"))
import numpy as np  # noqa: E402

from study import figures, measures, table  # noqa: E402
from study.budget import Neighbour, advice  # noqa: E402
from study.figures import log_ordinate, plain  # noqa: E402
from study.growth import digits, growth  # noqa: E402
from study.launch import beginning, checkpoint, defaults  # noqa: E402
from study.pareto import cheapest, front, limits, plt, put_labels, shapes_of  # noqa: E402
from study.plan import Study  # noqa: E402
from study.scene import StudyError  # noqa: E402

PISTON = SOURCE / "configs/benchmarks/piston/efs1.yaml"


class Choice(unittest.TestCase):
    ROWS = [{"run": name, "cost_s": cost, "error_EF": EF, "error_p_max": p}
            for name, cost, EF, p in (("cheap", 1, 5, 5), ("fair", 2, 1.5, 4), ("good", 3, 1, 1), ("dear", 4, 2, 0.5))]

    def test_the_front_is_what_no_other_beats_in_both(self):
        self.assertEqual(front([(row["cost_s"], row["error_EF"]) for row in self.ROWS]), [True, True, True, False])

    def test_the_cheapest_choice_within_all_limits_is_advised(self):
        for words, name in ((["EF=2%"], "fair"), (["EF=2%", "p_max=3"], "good"), (["EF=10%"], "cheap")):
            self.assertEqual(cheapest(self.ROWS, limits(words))["run"], name)
        self.assertIsNone(cheapest(self.ROWS, limits(["EF=0.1%"])))
        self.assertEqual(cheapest([*self.ROWS, {"run": "as cheap", "cost_s": 2.05, "error_EF": 0.5}], limits(["EF=2%"]))["run"],
                         "as cheap", "noise must not decide")
        with self.assertRaises(StudyError):
            limits(["EF 2%"])

    def test_a_mesh_has_one_shape_in_all_charts(self):
        shapes = shapes_of(["M0", "M0e1", "MXSe2", "M0e1", ""])
        self.assertEqual((shapes["M0"], shapes["M1"]), ("s", "D"))
        self.assertEqual(len(set(shapes.values())), len(shapes))

    def test_names_of_points_stay_within_the_axes(self):
        drawing, axis = plt.subplots(figsize=(4, 3))
        axis.set_xlim(0, 10)
        points = [(0.1, 0.5, "a_name_of_some_length"), (9.9, 0.5, "another_name_of_some_length"), (0.2, 0.52, "a_third_name")]
        put_labels(drawing, axis, points, [point[:2] for point in points])
        drawing.canvas.draw()
        frame = axis.get_window_extent()
        for label in axis.texts:
            box = label.get_window_extent()
            self.assertTrue(frame.x0 <= box.x0 and box.x1 <= frame.x1, label.get_text())
        plt.close(drawing)


class Figures(unittest.TestCase):
    def test_a_logarithmic_ordinate_has_several_numbers(self):
        for low, high in ((1.2, 12), (0.02, 0.3), (4000, 64000), (9, 9.6), (1e-6, 1e3)):
            with self.subTest(low=low, high=high):
                drawing, axis = plt.subplots(figsize=(4, 3))
                axis.plot([1, 2], [low, high])
                log_ordinate(axis)
                drawing.canvas.draw()
                bottom, top = axis.get_ylim()
                shown = [label.get_text() for at, label in zip(axis.get_yticks(), axis.get_yticklabels()) if bottom <= at <= top]
                self.assertGreaterEqual(sum(map(bool, shown)), 3, shown)
                self.assertEqual(len(shown), len(set(shown)), shown)
                plt.close(drawing)

    def test_numbers_at_an_axis_are_as_a_page_writes_them(self):
        self.assertEqual([plain(value) for value in (20000, 5, 0.5, 0.05, 5e-6)], ["20,000", "5", "0.5", "0.05", "5·10⁻⁶"])

    def test_no_number_of_a_bar_is_where_bars_and_diamonds_are(self):
        runs, kept = [SimpleNamespace(name=name) for name in ("EFS1", "E1FSinf")], []
        study = SimpleNamespace(paper={"EFS1": {"EF_percent": 53.4}, "E1FSinf": {"EF_percent": 57.0}}, about="")
        done = {"EFS1": {"EF_percent": 50.3}, "E1FSinf": {"EF_percent": 52.4}}
        with mock.patch.object(figures, "save", lambda drawing, *_: kept.append(drawing)):
            figures.bars(study, None, {"y": ["EF_percent"]}, runs, done, None)
        kept[0].canvas.draw()
        axis = kept[0].axes[0]
        self.assertEqual([number.get_text() for number in axis.texts], ["50.3", "52.4"])
        for number in axis.texts:
            self.assertGreater(number.get_window_extent().x0, axis.get_window_extent().x1)
        plt.close(kept[0])

    def test_all_charts_have_the_style_of_the_project(self):
        own = [str(path.relative_to(SOURCE)) for path in sorted((SOURCE / "tools").rglob("*"))
               if path.is_file() and b"import matplotlib.pyplot" in path.read_bytes()]
        self.assertEqual([name for name in own if not name.endswith(".pyc")], ["tools/rendering.py", "tools/reporting/style.py"])


class Results(unittest.TestCase):
    """Of runs that have been written by hand."""

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def write(self, name, step, opens=90e-3):
        """V(t) = t^2 to 0.1 s as history.csv has it, one step late; a valve that opens, checkpoints every 20 steps."""
        folder, n = self.folder / name, round(0.1 / step)
        folder.mkdir()
        rows = [(k * step, (max(k - 1, 0) * step)**2, "ejection" if k * step > opens + 1e-9 else "isovolumetric contraction")
                for k in range(n + 1)]
        (folder / "history.csv").write_text("time [s],volume [m^3],phase\n" + "".join(f"{t!r},{v!r},{p}\n" for t, v, p in rows))
        for k in range(20, n + 1, 20):
            (folder / f"checkpoints/{k}").mkdir(parents=True)
            (folder / f"checkpoints/{k}/manifest.json").write_text(json.dumps({"time": k * step}))
        return folder

    def test_volumes_are_compared_at_the_time_they_belong_to(self):
        coarse, fine = self.write("coarse", 0.8e-3), self.write("fine", 0.2e-3)
        self.assertLess(measures.errors(coarse, fine)["error_V"], 1e-10)

    def test_a_start_in_a_phase_is_its_very_beginning(self):
        folder = self.write("run", 0.2e-3, opens=90.8e-3)
        self.assertAlmostEqual(beginning(folder, "ejection", 0), 90.8e-3)
        self.assertAlmostEqual(beginning(folder, "ejection", 0, 0.8e-3), 91.2e-3)
        self.assertAlmostEqual(checkpoint(folder, ["before", "ejection", 0, 0], 0)[1], 88e-3)
        with self.assertRaises(StudyError):
            beginning(folder, "filling", 0)

    def test_an_opening_that_moves_moves_no_window(self):
        runs = [self.write("early", 0.2e-3, opens=85e-3), self.write("late", 0.2e-3, opens=95e-3)]
        spans = [measures.window(folder, folder) for folder in runs]
        self.assertEqual(measures.common(spans), (0, spans[0][1]))
        self.assertAlmostEqual(spans[0][1], 85e-3)

    def test_a_run_belongs_to_the_content_of_its_mesh(self):
        (self.folder / "mesh.yaml").write_text("base: scene.yaml\nalso: {one: {}, other: {mesh: other.h5}}\n")
        (self.folder / "scene.yaml").write_text("geometry: {shape: file, mesh: one.h5}\n")

        def fingerprints(one, other):
            for name, text in (("one.h5", one), ("other.h5", other)):
                (self.folder / name).write_text(text)
            study = Study(self.folder / "mesh.yaml", defaults())
            return [study.repetitions(run)[0].fingerprint for run in study.runs]
        same = fingerprints("a mesh", "a mesh")
        self.assertEqual(same[0], same[1])
        self.assertNotIn(same[0], fingerprints("another", "a third"))

    def test_repetitions_are_runs_of_their_own_and_their_median_counts(self):
        (self.folder / "three.yaml").write_text(f"base: {PISTON}\nalso: {{once: {{}}, thrice: {{repeat: 3}}}}\n")
        study = Study(self.folder / "three.yaml", defaults())
        once, thrice = (study.repetitions(run) for run in study.runs)
        self.assertEqual([case.fingerprint for case in once], [thrice[0].fingerprint])
        self.assertEqual(len({case.fingerprint for case in thrice}), 3)

        class Known:
            def state(self, _):
                return "done"

            def of(_, case):
                folder = self.folder / case.fingerprint
                folder.mkdir(exist_ok=True)
                (folder / "indicators.json").write_text(json.dumps({"cpu_s": [5., 4., 9.][case.repetition],
                                                                   "start_cpu_s_by_part": {"mech": 1.5, "fluid": 0.5}}))
                return folder
        self.assertEqual(table.costs(Known(), thrice), {"cost_s": 5, "start_s": 2, "repetitions": 3, "cost_min_s": 4, "cost_max_s": 9})


class Border(unittest.TestCase):
    def state(self, signal):
        return growth(np.asarray(signal)).state

    def test_slow_growth_behind_a_transient_is_seen(self):
        n = np.arange(200)
        for transient, start, rate in ((0.9, 1e-6, 1.01), (0.9, 1e-4, 1.003), (0.97, 1e-5, 1.05)):
            found = growth(transient**n + start * rate**n)
            self.assertEqual(found.state, "growing")
            self.assertAlmostEqual(found.rate / np.log(rate), 1, delta=0.35)
            self.assertEqual(self.state(transient**n + start * (-rate)**n), "growing")

    def test_what_decays_is_stable_whatever_floor_it_falls_to(self):
        n, noise = np.arange(200), np.random.default_rng(1).random(200)
        for signal in (0.95**n, 0.997**n * (1 + 0.05 * noise), 0.8**n + 1e-7 * noise, (-0.98)**n, 0.99**n * np.cos(0.3 * n)):
            self.assertEqual(self.state(signal), "stable")

    def test_what_neither_grows_nor_decays_is_not_called_either(self):
        self.assertEqual(self.state(1 + 0.01 * np.random.default_rng(1).random(200)), "undecided")
        self.assertEqual(self.state(np.ones(20)), "undecided")

    def test_a_border_has_the_digits_of_its_uncertainty(self):
        for value, uncertainty, text in ((25080, 400, "25.1e3 ± 0.4e3"), (25080, 1400, "25.1e3 ± 1.4e3"),
                                         (580123, 58000, "580e3 ± 60e3"), (25080, 19, "25.080e3 ± 0.019e3"),
                                         (0.0123, 0.002, "12e-3 ± 2e-3"), (12.3, 4, "12 ± 4")):
            self.assertEqual(digits(value, uncertainty), text)


class Budget(unittest.TestCase):
    def test_a_difference_is_as_much_of_the_error_as_its_order_says(self):
        for direction, ratio, order, factor in (("finer", 2, 1, 2), ("finer", 2, 2, 4 / 3), ("coarser", 2, 1, 1),
                                                ("coarser", 2, 2, 1 / 3), ("finer", np.inf, 1, 1)):
            self.assertAlmostEqual(Neighbour("", direction, "", "", ratio=ratio, order=order).factor, factor)

    def test_the_advice_is_what_takes_most_away_for_its_cost(self):
        def row(part, direction, share, cost):
            return {"part": part, "direction": direction, "change": "x 2", "state": "done", "of": "EF", "share": share,
                    "change_share": share, "cost_ratio": cost, "extra_cost": cost - 1}

        rows = [row("mesh", "finer", 6, 9), row("step", "finer", 4, 1.5), row("tolerances", "finer", 0.01, 1.01),
                row("tolerances", "coarser", 0.02, 0.8), row("step", "coarser", 5, 0.6)]
        self.assertRegex(advice(rows), r"^Refine next: step .* 1.50 times .*the largest error is that of mesh.*finer than needed: tolerances [^,]*\.$")


if __name__ == "__main__":
    unittest.main(verbosity=2)
