"""Charts of runs: all is seen, and nothing cut off."""
import sys
import unittest

import numpy as np
from launch import SOURCE
from made_runs import Temporary, healthy, write
from PIL import Image

sys.path.insert(0, str(SOURCE / "tools"))
from reporting import charts, style  # noqa: E402
from results import Run, origin  # noqa: E402


class Charts(Temporary):
    def test_nothing_is_cut_off_a_figure(self):
        figure, axis = style.plt.subplots(figsize=(3, 2))
        axis.plot([0, 1], label="a name that is much longer than the axes are wide " * 2)
        figure.legend(loc="upper center", bbox_to_anchor=(0.5, 0.0))
        style.save(figure, self.folder / "legend")
        pixels = np.asarray(Image.open(self.folder / "legend.png").convert("L"))
        for edge in (pixels[0], pixels[-1], pixels[:, 0], pixels[:, -1]):
            self.assertEqual(edge.min(), 255)

    def test_a_picture_says_of_what_it_is(self):
        run = write(self.folder / "run", *healthy())
        (run / "provenance.json").write_text('{"heartbus": "1.2.3"}')
        figure, axis = style.plt.subplots()
        style.save(figure, self.folder / "picture", origin=origin([run, run]))
        said = "made, EFS1, mesh M0, heartbus 1.2.3"
        self.assertEqual(Image.open(self.folder / "picture.png").text["Source"], f"{said}; {said}")
        for ending in ("svg", "pdf"):
            self.assertIn(said.encode(), (self.folder / f"picture.{ending}").read_bytes())

    def test_numbers_beside_an_axis_are_whole(self):
        """Not 0.04 with an offset of 107.1 above."""
        columns, beats = healthy()
        columns["volume [m^3]"] = 107.1e-6 + 1e-8 * np.linspace(0, 1, 81)
        figure = charts.volume_and_pressure([Run(write(self.folder / "run", columns, beats))])
        figure.canvas.draw()
        self.assertEqual([axis.yaxis.get_offset_text().get_text() for axis in figure.axes], [""] * len(figure.axes))

    def test_no_text_lies_over_the_loop_of_a_run_that_does_not_eject(self):
        columns, beats = healthy()
        columns["volume [m^3]"] = 107.1e-6 + 1e-9 * np.sin(np.linspace(0, 12.5, 81))
        beats[0]["end"] = 0.4
        run = Run(write(self.folder / "run", columns, [*beats, {"beat": 2, "start": 0.4, "end": 0.8, "complete": True}]))
        figure = charts.pressure_volume_loop([run])
        figure.canvas.draw()
        frame = figure.axes[0].get_window_extent()
        texts = [*figure.axes[0].texts, *figure.legends, *filter(None, [figure.axes[0].get_legend()])]
        self.assertEqual([text for text in texts if text.get_window_extent().overlaps(frame)], [])
        self.assertEqual([text.get_text() for text in figure.legends[0].get_texts()], ["beat 1", "beat 2"])

    def test_curves_that_coincide_are_all_seen(self):
        runs = [Run(write(self.folder / scheme, *healthy(), {"coupling": {"scheme": scheme}}))
                for scheme in ("EFS1", "adaptive", "EFS1-corrected", "E1FSinf")]
        figure = charts.pressure_volume_loop(runs)
        figure.legends[0].remove()
        figure.savefig(self.folder / "loop.png")
        pixels = np.asarray(Image.open(self.folder / "loop.png").convert("RGB")).astype(int)
        for look in charts.own_looks(runs):
            near = abs(pixels - 255 * np.array(style.to_rgb(look["color"]))).max(axis=2) < 12
            self.assertGreater(near.sum(), 100, look["color"])

    def test_time_goes_from_one_edge_of_a_chart_to_the_other(self):
        columns, beats = healthy()
        run = Run(write(self.folder / "run", {**columns, "lifting_iterations": [2] * 81}, beats))
        for chart in (charts.volume_and_pressure, charts.flows, charts.budget, charts.wall, charts.iterations):
            for axis in chart([run]).axes:
                self.assertEqual(axis.get_xlim(), (0, 800), chart.__name__)

    def test_a_legend_names_every_run_also_those_that_the_first_chart_lacks(self):
        columns, beats = healthy()
        runs = [Run(write(self.folder / "one", {**columns, "coupling_iterations": [2] * 81}, beats)),
                Run(write(self.folder / "two", {"fsi_iterations" if name == "coupling_iterations" else name: [3] * 81
                                                if name == "coupling_iterations" else values for name, values in columns.items()}, beats))]
        figure = charts.iterations(runs)
        self.assertEqual([text.get_text() for text in figure.legends[0].get_texts()], ["one", "two"])

    def test_a_scheme_has_its_colour_everywhere(self):
        alone, beside = style.colours(["EFS1"]), style.colours(["E1FSinf", "E1FS2_a5000", "EFS1_a2000", "EFS1_auto", "corrected"])
        self.assertEqual(alone[0], beside[2])
        self.assertEqual(len(set(beside)), 5)
        self.assertNotIn(beside[3], style.PALETTE, "a second one of a scheme has none of another scheme's")
        self.assertTrue(set(style.colours(["EFS1"] * 4)) < set(style.PALETTE), "of one scheme only, all differ clearly")
        self.assertEqual(style.pretty("kg/(m^2 s)"), "kg/(m² s)")


if __name__ == "__main__":
    unittest.main(verbosity=2)
