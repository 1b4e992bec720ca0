"""What a run tells people when it is done: what is implausible, the page, its tables."""
import html
import html.parser
import json
import shutil
import subprocess
import sys
import unittest

import yaml
from browser import BROWSER, WINDOWS, faults, look
from launch import BIN, SOURCE, Forked, Launch
from made_runs import Temporary, healthy, write

sys.path.insert(0, str(SOURCE / "tools"))
import numpy as np  # noqa: E402
from PIL import Image  # noqa: E402

from reporting import plausibility, style, tables  # noqa: E402
from reporting.page import table  # noqa: E402
from results import Run  # noqa: E402

PISTON = SOURCE / "configs/benchmarks/piston/efs1.yaml"


class Plausibility(Temporary):
    def found(self, columns=None, beat=None, without=(), more=()):
        """Findings of the healthy beat with these changes."""
        own, beats = healthy()
        own.update({name: [value] * 81 if np.isscalar(value) else list(value) for name, value in (columns or {}).items()})
        beats[0].update(beat or {})
        for key in without:
            del beats[0][key]
        return plausibility.findings(Run(write(self.folder / "run", own, beats + list(more))))

    def assert_only(self, found, key, *parts):
        self.assertEqual([finding.key for finding in found], [key], [str(each) for each in found])
        for part in parts:
            self.assertIn(part, str(found[0]))

    def test_a_healthy_beat_has_nothing(self):
        self.assertEqual([str(each) for each in self.found()], [])

    def test_a_wall_that_is_never_or_partly_activated(self):
        never = self.found({"activated_share": 0.0}, {"activated_percent": 0.0}, ["activation_time_ms"])
        self.assert_only(never, "electrophysiology.stimulus", "no point of the wall")
        partly = self.found({"activated_share": 0.4}, {"activated_percent": 40.0}, ["activation_time_ms"])
        self.assert_only(partly, "electrophysiology.refinements", "only 40.0 %")

    def test_activation_that_has_come_to_rest_before_the_beat_has_ended(self):
        """The run ends at 240 ms; activation stood still for 200 ms, and for 40."""
        columns, beats = healthy()
        columns = {name: values[:25] for name, values in columns.items()}
        beats[0] = {"beat": 1, "start": 0.0, "end": 0.24, "complete": False}
        for last, percent, found in ((0.04, 40.0, ["only 40.0 % of the wall is activated"]), (0.2, 90.0, []),
                                     (0.0, 0.0, ["no point of the wall is activated"])):
            with self.subTest(percent):
                share = np.minimum(np.array(columns["time [s]"]) / last if last else np.zeros(25), 1) * percent / 100
                run = Run(write(self.folder / str(percent), {**columns, "activated_share": share},
                                [{**beats[0], "activated_percent": percent}]))
                self.assertEqual([each.what for each in plausibility.findings(run)], found)

    def test_valves_that_never_open(self):
        self.assert_only(self.found(without=["aortic_opens_ms", "aortic_closes_ms", "mitral_opens_ms"]),
                         "mechanics.active.tension_max", "aortic valve never opens", "120.0 mmHg")
        self.assert_only(self.found(without=["mitral_opens_ms"]), "fluid.mitral_pressure", "mitral valve never opens")

    def test_crushed_cells_and_a_wall_that_loses_volume(self):
        self.assert_only(self.found({"min_J": 0.69}), "mechanics.guccione.kappa", "J 0.690", "50000 Pa")
        self.assertEqual(self.found({"min_J": 0.71}), [])
        self.assert_only(self.found({"wall_volume": 0.965}), "mechanics.guccione.kappa", "-3.5 %")
        self.assert_only(self.found({"wall_volume": 1.04}), "mechanics.guccione.kappa", "+4.0 %")

    def test_sarcomeres_out_of_the_models_range(self):
        self.assert_only(self.found({"clamped_share": 0.3}), "mechanics.active.sarcomere_length", "30 %", "1.75 um")

    def test_alpha_near_its_limit(self):
        self.assert_only(self.found({"alpha_limit [kg/(m^2 s)]": 5500}), "coupling.alpha", "5000", "5500")
        self.assertEqual(self.found({"alpha_limit [kg/(m^2 s)]": 5600}), [])
        self.assertEqual(self.found({"alpha_limit [kg/(m^2 s)]": 0}), [], "not estimated yet")

    def test_a_mesh_that_is_nearly_inverted(self):
        self.assert_only(self.found({"mesh_min_J": 0.15}), "geometry", "15 %")

    def test_disagreement_of_blood_and_wall(self):
        self.assert_only(self.found(beat={"ILI_C_percent": 7.0}), "coupling.alpha", "7.0 %", "contraction")
        spike = np.full(81, 10.0)
        spike[20:24] = 1e3  # a valve switches
        self.assertEqual(self.found({"disagreement [Pa]": spike}), [])
        spike[20:28] = 1e3
        self.assert_only(self.found({"disagreement [Pa]": spike}), "time.step", "1000 Pa")

    def test_beats_that_are_not_periodic(self):
        columns, _ = healthy()
        volume = np.array(columns["volume [m^3]"])
        volume[-1] = 110e-6
        self.assert_only(self.found({"volume [m^3]": volume}), "time.beats", "begins with 120.0 mL and ends with 110.0 mL")
        second = {"beat": 2, "start": 0.0, "end": 0.8, "complete": True, "aortic_opens_ms": 90, "mitral_opens_ms": 400,
                  "change_percent": {"EDV": 5.0, "ESV": 1.0, "p_max": 0.1}}
        self.assert_only(self.found(more=[second]), "time.beats", "EDV changes by 5.0 %")
        second["change_percent"]["EDV"] = 1.0
        self.assertEqual(self.found(more=[second]), [])

    def test_a_warning_names_the_law_and_the_beat_it_is_about(self):
        second = {**healthy()[1][0], "beat": 2, "start": 0.8, "end": 1.6, "activated_percent": 0.0, "ILI_R_percent": 6.0}
        found = {finding.key: str(finding) for finding in self.found(more=[second])}
        self.assertEqual(set(found), {"electrophysiology.stimulus", "coupling.alpha"})
        self.assertIn("in isovolumetric relaxation in beat 2", found["coupling.alpha"])
        self.assertIn("no point of the wall is activated in beat 2", found["electrophysiology.stimulus"])
        columns, beats = healthy()
        columns["min_J"] = [0.5] * 81
        folder = write(self.folder / "other", columns, beats, {"mechanics": {"law": "neo_hookean", "neo_hookean": {"kappa": "9 kPa"}}})
        self.assert_only(plausibility.findings(Run(folder)), "mechanics.neo_hookean.kappa", "9 kPa resists too little")

    def test_every_warning_names_keys_of_scenes(self):
        """Those that are provoked above, each by a rule of its own."""
        known = yaml.safe_load(subprocess.run([BIN / "coupler", "--print-defaults"], stdout=subprocess.PIPE, check=True).stdout)
        provoked = {
            "activation": [({}, {"activated_percent": 0.0}, []), ({}, {"activated_percent": 40.0}, [])],
            "valves": [({}, {}, ["aortic_opens_ms"]), ({}, {}, ["mitral_opens_ms"])],
            "crushed_cells": [({"min_J": 0.6}, {}, [])], "wall_volume": [({"wall_volume": 0.9}, {}, [])],
            "sarcomeres": [({"clamped_share": 0.3}, {}, [])], "alpha": [({"alpha_limit [kg/(m^2 s)]": 5000}, {}, [])],
            "mesh_quality": [({"mesh_min_J": 0.1}, {}, [])],
            "disagreement": [({}, {"ILI_C_percent": 7.0}, []), ({"disagreement [Pa]": 1e3}, {}, [])],
            "periodicity": [({"volume [m^3]": np.linspace(120e-6, 100e-6, 81)}, {}, [])]}
        self.assertEqual(set(provoked), {rule.__name__ for rule in plausibility.RULES})
        for rule, provocations in provoked.items():
            for columns, beat, without in provocations:
                found = self.found(columns, beat, without)
                self.assertEqual(len(found), 1, rule)
                value = known
                for name in found[0].key.split("."):
                    self.assertIn(name, value, f"{rule} names {found[0].key}")
                    value = value[name]

    def test_an_unfinished_beat_is_not_judged_by_what_it_has_not_reached(self):
        growing = {"activated_share": np.linspace(0, 0.03, 81)}
        self.assertEqual(self.found(growing, beat={"complete": False, "activated_percent": 3.0},
                                    without=["activation_time_ms", "aortic_opens_ms", "mitral_opens_ms"]), [])


class Parser(html.parser.HTMLParser):
    """All that a page would load, and whether its elements are closed."""
    VOID = {"meta", "img", "input", "br", "path", "use", "rect", "image"}

    def __init__(self):
        super().__init__()
        self.loaded, self.open, self.ids = [], [], []

    def handle_starttag(self, tag, attributes):
        if tag not in self.VOID:
            self.open.append(tag)
        for name, value in attributes:
            if name in ("src", "href", "xlink:href"):
                self.loaded.append(value)
            if name == "id":
                self.ids.append(value)

    def handle_endtag(self, tag):
        if tag not in self.VOID:
            while self.open and self.open.pop() != tag:
                pass


class Reports(Temporary):
    def report(self, *words, before=()):
        """`before`: a command that runs this one."""
        script = SOURCE / "tools/report.py"
        launch = Launch([*before, sys.executable, script, *words], self.folder) if before else Forked(script, words, self.folder)
        self.assertEqual(launch.code, 0, launch.output)
        return launch.output

    def run_with_picture(self, name="one"):
        folder = write(self.folder / name, *healthy())
        (folder / "report").mkdir(exist_ok=True)
        Image.new("RGB", (60, 40), "red").save(folder / "report/fibres.png")
        return folder

    def page(self, file):
        text, parser = file.read_text(), Parser()
        parser.feed(text)
        self.assertEqual([each for each in parser.loaded if not each.startswith(("data:", "#"))], [], "not self-contained")
        self.assertEqual(len(parser.ids), len(set(parser.ids)), "ids are not unique")
        self.assertEqual(parser.open, [])
        return text

    def test_a_run_and_a_comparison_each_become_one_page(self):
        one, two = self.run_with_picture("one"), write(self.folder / "two", *healthy())
        self.report(one, "--charts")
        text = self.page(one / "report/report.html")
        for part in ("ejection fraction", "50.0", "Pressure-volume loop", "Cost by part", "Nothing implausible", "data:image/webp",
                     "scene.resolved.yaml"):
            self.assertIn(part, text)
        self.assertEqual([each.suffix for each in (one / "report").glob("pv_loop.*")], [".svg"])
        self.report(one, two, "--out", "both")
        for ending in style.FORMATS:
            self.assertGreater((self.folder / f"both/pv_loop.{ending}").stat().st_size, 2000)
        text = self.page(self.folder / "both/report.html")
        self.assertIn("Comparison of one, two", text)

    def test_all_that_is_implausible_is_on_the_page_with_its_key(self):
        columns, beats = healthy()
        columns |= {"min_J": [0.6] * 81, "clamped_share": [0.3] * 81, "mesh_min_J": [0.1] * 81}
        run = Run(write(self.folder / "run", columns, beats))
        self.assertEqual(len(plausibility.findings(run)), 3)
        self.report(run.folder, "--charts")
        text = html.unescape(self.page(run.folder / "report/report.html"))
        for finding in plausibility.findings(run):
            self.assertIn(f"<li>{finding.what}. <code>{finding.key}</code>: {finding.hint}</li>", text)

    def test_a_trace_and_the_error_budget_of_the_scene_are_on_the_page(self):
        folder = write(self.folder / "results/made", *healthy())
        self.report(folder, "--charts")
        self.assertNotIn("nobody works", self.page(folder / "report/report.html"))
        names = [{"ph": "M", "name": "process_name", "pid": k, "tid": 0, "args": {"name": name}} for k, name in enumerate(("ep", "mech"))]
        spans = [(0, "solve", 0, 400), (0, "send calcium", 400, 420), (1, "solve", 450, 900), (1, "commit", 900, 950)]
        steps = [{"ph": "X", "name": what, "pid": k, "tid": 0, "ts": 1000 * n + begin, "dur": end - begin, "args": {"step": n}}
                 for n in range(1, 9) for k, what, begin, end in spans]
        (folder / "trace.json").write_text(json.dumps({"traceEvents": names + steps}))
        studies = self.folder / "results/studies/budget_made"
        shutil.copytree(folder, studies / "runs/scene")
        (studies / "budget.csv").write_text(
            "part,direction,change,run,state,order,ratio,change_EF,error_EF,share,of,cost_s,cost_ratio,reason\n"
            "coupling step,finer,0.2 ms -> 0.1 ms,step_finer,done,1,2,0.98,-1.96,4.6,EF,63,1.32,\n"
            "scheme,finer,EFS1 -> E1FSinf,scheme_finer,failed,1,2,,,,,,,it\n")
        self.report(folder, "--charts")
        text = html.unescape(self.page(folder / "report/report.html"))
        for part in ("nobody works (7 steps of", "<td>50.0</td>", "Who works when", "ep, rank 0", "Error budget", "Of this scene.",
                     "error of EF, points", "<td>-2</td>", "x 1.32"):
            self.assertIn(part, text)
        self.assertNotIn("scheme_finer", text)
        scene = yaml.safe_load((folder / "scene.resolved.yaml").read_text())
        scene["geometry"]["mesh"] = "M1"
        (folder / "scene.resolved.yaml").write_text(yaml.safe_dump(scene))
        self.report(folder, "--charts")
        self.assertIn("Of the same scene but for geometry.mesh: M0.", self.page(folder / "report/report.html"))

    def test_what_cannot_be_drawn_is_said(self):
        folder = write(self.folder / "run", *healthy())
        (folder / "fields").mkdir()
        (folder / "fields/mech.h5").write_bytes(b"")
        (self.folder / "missing").mkdir()
        (self.folder / "missing/vtk.py").write_text("raise ImportError('no VTK here')\n")
        said = self.report(folder, before=["env", f"PYTHONPATH={self.folder / 'missing'}"])
        self.assertIn("python3-vtk9", said)
        self.assertIn("python3-vtk9", self.page(folder / "report/report.html"))

    @unittest.skipUnless(BROWSER, "there is no Chromium here (Debian: chromium-headless-shell)")
    def test_a_browser_shows_it_without_errors_at_any_width_light_and_dark(self):
        folder, other = self.run_with_picture(), write(self.folder / "two", *healthy())
        frame = "data:image/gif;base64,R0lGODlhAQABAAAAACwAAAAAAQABAAA="
        (folder / "report/films.json").write_text(json.dumps({
            "captions": ["0 ms", "10 ms"], "frames": {"potential": [frame] * 2},
            "scales": {"potential": {"label": "potential [mV]", "low": "-90", "high": "40", "colours": ["#000000", "#ffffff"]}}}))
        self.report(folder, "--charts")
        self.report(folder, other, "--out", "both")
        for page in (folder / "report/report.html", self.folder / "both/report.html"):
            for width, dark in WINDOWS:
                with self.subTest((page.parent.name, width, dark)):
                    seen = look(page, width, dark)
                    self.assertEqual(faults(seen), [])
                    self.assertEqual((seen["pictures"], seen["told"]), (2, "10 ms"))
                    self.assertGreaterEqual(seen["charts"], 5)

    @unittest.skipUnless(BROWSER, "there is no Chromium here (Debian: chromium-headless-shell)")
    def test_what_a_browser_would_show_wrong_is_seen(self):
        page = self.folder / "wrong.html"
        page.write_text('<body style="background: #eee; color: #ccc"><img src="nowhere.png"><div style="width: 900px">x</div>'
                        "<script>console.error('wrong')</script></body>")
        self.assertEqual(len(faults(look(page, 400, False))), 5)

    def test_the_command_that_has_made_a_run_can_be_typed(self):
        folder = write(self.folder / "run", *healthy())
        (folder / "provenance.json").write_text(json.dumps({"command": ["/somewhere/bin/coupler", "a.yaml", "--set", "mesh=M1"]}))
        self.report(folder, "--charts")
        self.assertIn("heartbus run a.yaml --set mesh=M1</pre>", self.page(folder / "report/report.html"))

    def test_keys_break_at_their_dots(self):
        self.assertIn("<td>a.<wbr>long.<wbr>key</td><td>0.5</td>", table(["", ""], [["a.long.key", "0.5"]], words=True))


class Tables(Temporary):
    def test_a_column_for_each_beat_with_units(self):
        columns, beats = healthy()
        beats[0]["end"] = 0.4
        beats.append({"beat": 2, "start": 0.4, "end": 0.8, "complete": False, "EDV_mL": 118.0, "change_percent": {"EDV": 1.5}})
        heading, rows = tables.indicators([Run(write(self.folder / "run", columns, beats))])
        self.assertEqual(heading, ["", "unit", "beat 1", "beat 2 (incomplete)"])
        self.assertIn(["ejection fraction", "%", "50.0", ""], rows)
        self.assertIn(["EDV changed since the beat before", "%", "", "1.50"], rows)

    def test_keys_of_a_scene_that_differ_and_no_others(self):
        wall = {"law": "guccione", "guccione": {"c": "880 Pa"}, "neo_hookean": {"mu": "1 kPa"}}
        scene = {"mechanics": {**wall, "regions": {"ring": {**wall, "law": "neo_hookean", "contracts": False}}},
                 "stimulus": {"sites": [{"centre": ["0.013900000000000001 m", "-0.023899999999999998 m"], "radius": "1e-05 m"}]}}
        run = Run(write(self.folder / "run", *healthy(), scene))
        self.assertEqual(tables.scene_differences([run], {"mechanics": wall})[1], [
            ["mechanics.regions.ring.contracts", "false", ""], ["mechanics.regions.ring.law", "neo_hookean", "guccione"],
            ["stimulus.sites", "[{centre: [0.0139 m, -0.0239 m], radius: 1e-05 m}]", ""]])

    def test_origins_of_several_runs_are_one_table(self):
        runs = [Run(write(self.folder / name, *healthy())) for name in ("one", "two")]
        for run in runs:
            (run.folder / "provenance.json").write_text(json.dumps({"command": ["x"], "in_folder": "/here", "MPI": run.name}))
        self.assertEqual(tables.origin(runs), (["", "one", "two"], [["in folder", "/here", "/here"], ["MPI", "one", "two"]]))
        self.assertEqual(tables.origin(runs[:1]), (["", ""], [["in folder", "/here"], ["MPI", "one"]]))

    def test_a_run_without_beats_has_one_column(self):
        columns = {"step": range(3), "time [s]": [0, 0.5, 1.0], "min_J": [1, 0.9, 0.8]}
        run = Run(write(self.folder / "run", columns, [{"start": 0.0, "end": 1.0, "complete": True, "J_min": 0.8}]))
        heading, rows = tables.indicators([run])
        self.assertEqual((heading, rows), (["", "unit", "run"], [["smallest J of the wall", "", "0.800"]]))


if __name__ == "__main__":
    unittest.main(verbosity=2)
