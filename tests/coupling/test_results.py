"""Nothing that a run has written is lost: not to a later run, not to one beside it, not to a reader or a full disk."""
import json
import os
import shutil
import signal
import subprocess
import tempfile
import threading
import time
import unittest
from pathlib import Path

import h5py
import numpy as np
from launch import BIN, SOURCE, Launch, launch_words

PISTON = SOURCE / "configs/benchmarks/piston/efs1.yaml"
SETTINGS = ["checkpoint.every=4 ms", "checkpoint.keep=10"]
NO_PHYSICS = f"base: {PISTON}\nparticipants:\n" + "".join(
    f"  {name}: {{program: stand_in, settings: {{mischief: none, step: 0, delay: 0}}}}\n" for name in ("mech", "ale", "fluid"))


def words(*settings):
    return [word for setting in settings for word in ("--set", setting)]


class Results(unittest.TestCase):
    """Of a piston; where only the coupler writes, its participants are stand-ins, which start in no time."""
    scene = PISTON
    piston = None  # folder of the results of a run to 16 ms

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        self.sets = self.folder / "out/checkpoints"
        (self.folder / "no_physics.yaml").write_text(NO_PHYSICS)

    def copy_of_piston(self):
        if not Results.piston:
            temporary = tempfile.TemporaryDirectory()
            unittest.addModuleCleanup(temporary.cleanup)
            Results.piston = Path(temporary.name) / "out"
            self.run_well(out=Results.piston)
        shutil.copytree(Results.piston, self.folder / "out")

    def launch(self, *arguments, end=16, out="out", settings=(), during=None, scene=None):
        command = launch_words(scene or self.scene, self.folder, "--out", out, *words(*SETTINGS, f"time.end={end} ms", *settings))
        at = command.index(":")  # what follows is not checked before the launch, as by who types it
        return Launch([*command[:at], *arguments, *command[at:]], self.folder, during)

    def run_well(self, *arguments, **options):
        launch = self.launch(*arguments, **options)
        self.assertEqual(launch.code, 0, launch.output)
        return launch

    def refused(self, code, parts, *arguments, **options):
        """A launch that ends so, nobody left."""
        launch = self.launch(*arguments, **options)
        self.assertEqual(launch.code, code, launch.output)
        for part in parts:
            self.assertIn(part, launch.output)
        self.assertEqual(launch.orphans, [])
        return launch

    def refused_at_once(self, code, parts, *arguments, settings=()):
        launch = Launch([BIN / "coupler", PISTON, "--out", "out", *words("time.end=16 ms", *settings), *arguments,
                         "--validate"], self.folder)
        self.assertEqual(launch.code, code, launch.output)
        for part in parts:
            self.assertIn(part, launch.output)

    def numbers(self, folder="out/checkpoints"):
        return sorted(path.name for path in (self.folder / folder).iterdir())



class EarlyFailures(Results):
    def fails_at_the_first_step(self, *arguments):
        """A wall that cannot converge: long after the start, long before the first checkpoint."""
        return self.refused(5, [], *arguments, settings=["mechanics.solver.max_iterations=1",
                                                         "push.pressure.times=[0 ms]", "push.pressure.values=[100 kPa]"])

    def test_runs_that_fail_early_leave_all_checkpoints_where_they_are(self):
        self.copy_of_piston()
        before = {path: path.read_bytes() for path in self.sets.rglob("*") if path.is_file()}
        self.refused(2, ["write field=FILE"], "--record", "typo", scene="no_physics.yaml")
        self.refused(2, ["transfers no such field"], "--record", "nothing=x.h5", scene="no_physics.yaml")
        self.fails_at_the_first_step()
        self.fails_at_the_first_step("--restart", "4 ms")
        self.assertEqual(before, {path: path.read_bytes() for path in self.sets.rglob("*") if path.is_file()})


class WhatEarlierRunsLeft(Results):
    scene = "no_physics.yaml"

    def test_a_run_that_has_a_checkpoint_sets_those_of_others_aside(self):
        self.run_well()
        self.run_well(end=8)
        self.assertEqual(self.numbers(), ["000020", "000040"])
        self.assertEqual(self.numbers("out/checkpoints.old"), ["000020", "000040", "000060", "000080"])
        self.run_well("--restart", "4 ms", end=8)
        self.assertEqual(self.numbers(), ["000020", "000040"])
        self.assertEqual(self.numbers("out/checkpoints.old"), ["000040"])

    def test_what_is_read_stays_however_it_is_spelled(self):
        self.run_well()
        self.run_well(end=8)
        (self.folder / "link").symlink_to(self.folder / "out/checkpoints.old")
        for spelled in "link/000040", "./link/../checkpoints.old//000040/":
            with self.subTest(spelled):
                self.run_well("--restart", spelled, end=12)
                self.assertIn("000040", self.numbers("out/checkpoints.old"))
                self.assertEqual(self.numbers(), ["000060"])

    def test_odd_things_among_the_checkpoints_are_passed_over(self):
        self.run_well()
        (self.sets / ("9" * 20)).mkdir()
        (self.sets / "-1").mkdir()
        (self.sets / "000100").write_text("a file")
        (self.sets / "000120/manifest.json").mkdir(parents=True)
        os.mkfifo(self.sets / "fifo")
        (self.sets / "000140").mkdir()
        os.mkfifo(self.sets / "000140/manifest.json")
        (self.sets / "000160").mkdir()
        (self.sets / "000160/manifest.json").write_text("[" * 100000)
        (self.sets / "000180.part").mkdir()
        launch = self.run_well("--restart", "latest", end=20)
        self.assertIn("goes on from t = 16.0 ms", launch.output)
        for odd in "9" * 20, "-1", "000100", "000120", "fifo", "000140", "000160":
            self.assertIn(f"passed over: checkpoint {self.sets}/{odd}", launch.output)
        self.run_well("--restart", "4 ms", end=8)


class Manifests(Results):
    def edit(self, step, **changes):
        path = self.sets / step / "manifest.json"
        path.write_text(json.dumps({**json.loads(path.read_text()), **changes}))

    def test_a_manifest_that_was_changed_is_refused(self):
        self.copy_of_piston()
        whole = self.sets / "000080/manifest.json"
        manifest = json.loads(whole.read_text())
        self.edit("000080")  # laid out anew, it says the same
        self.refused_at_once(0, ["valid"], "--restart", "16 ms")
        for change in {"time": 0.002}, {"step": 10}, {"step_size": 1e-4}, {"model": {}}, {"files": {}}:
            with self.subTest(change):
                whole.write_text(json.dumps({**manifest, **change}))
                self.refused_at_once(8, ["000080: manifest.json is damaged"], "--restart", "out/checkpoints/000080")
        del manifest["checksum"]
        whole.write_text(json.dumps(manifest))
        self.refused_at_once(8, ["000080: manifest.json is damaged"], "--restart", "out/checkpoints/000080")
        launch = self.run_well("--restart", "latest", end=20)
        self.assertIn("goes on from t = 12.0 ms", launch.output)

    def test_a_state_of_another_model_is_refused_with_what_differs(self):
        self.copy_of_piston()
        for setting, difference in [
            ("law=guccione", "mechanics.law is neo_hookean there and guccione here"),
            ("mechanics.active.model=rdq18_ann", "mechanics.active.model is none there and rdq18_ann here"),
            ("cells_column=4", "geometry.piston.cells_column is 3 there and 4 here"),
            ("mechanics.fixed=[z_low]", "mechanics.fixed is [] there and [z_low] here"),
            ("fibres.direction=[0, 1, 0]", "fibres.direction is [1, 0, 0] there and [0, 1, 0] here")]:
            self.refused_at_once(8, ["000080: its state is of another model than this scene: ", difference],
                                 "--restart", "latest", settings=[setting])
        self.refused_at_once(0, ["valid"], "--restart", "latest", settings=["alpha=6000 kg/(m^2 s)"])


class TwoRuns(Results):
    scene = "no_physics.yaml"

    def test_the_second_run_in_a_folder_is_refused_and_names_the_first(self):
        second = []

        def start_another(process):
            deadline = time.monotonic() + 30
            history = self.folder / "out/history.csv"
            while time.monotonic() < deadline and not (history.exists() and history.read_text().count("\n") > 5):
                time.sleep(0.01)
            (self.folder / "other name").symlink_to(self.folder / "out")
            second.append(self.launch(out="other name"))
            process.send_signal(signal.SIGUSR1)

        self.run_well(end=1000, settings=["mech.settings.delay=0.01"], during=start_another)
        self.assertEqual(second[0].code, 8, second[0].output)
        self.assertIn("another run writes its results there, process ", second[0].output)
        self.assertIn(" on " + os.uname().nodename, second[0].output)
        self.run_well()  # the lock has gone with its run


class Recordings(Results):
    scene = "no_physics.yaml"

    def recording(self, name="force.h5"):
        with h5py.File(self.folder / name, "r") as file:
            return {key: file[key][:] for key in ("values", "step", "time")}

    def assert_same(self, a, b):
        for key, values in a.items():
            np.testing.assert_array_equal(values, b[key], key)

    def test_a_recording_goes_on_with_its_run(self):
        record = ["--record", "blood_force=force.h5"]
        self.run_well(*record, end=16)
        whole = self.recording()
        self.run_well(*record, "--restart", "8 ms")
        self.assert_same(whole, self.recording())
        self.refused(5, [], *record, "--restart", "8 ms", settings=["mech.settings.mischief=fail", "mech.settings.step=41"])
        self.assert_same(whole, self.recording())  # untouched: nothing has come to be recorded
        self.run_well("--restart", "8 ms", "--record", "blood_force=late.h5")  # there is nothing to go on with
        self.assertEqual(self.recording("late.h5")["time"][0], 41 * 0.2e-3)
        self.refused(8, ["force.h5 of field 'blood_force' is of another field than displacement"],
                     "--record", "displacement=force.h5", "--restart", "8 ms")
        self.run_well(end=20)
        self.refused(8, ["ends at t = 0.016", "a gap would remain"], *record, "--restart", "latest", end=24)


class Readers(Results):
    WEAKER = ["output.every=2 ms", "push.pressure.values=[0 Pa, 100 Pa]"]

    def test_fields_and_recordings_can_be_read_while_they_are_written_and_afterwards(self):
        seen, wrong = [], []
        stop = threading.Event()

        def read(first=[None]):
            while not stop.is_set():
                try:
                    with h5py.File(self.folder / "out/fields/fluid.h5", "r") as file:
                        groups = [name for name in file if name != "mesh"]
                        for name in groups:
                            if not np.isfinite(file[name]["velocity"][:]).all():
                                wrong.append(name)
                        seen.append(len(groups))
                    with h5py.File(self.folder / "force.h5", "r") as file:
                        seen.append(len(file["step"]))
                except FileNotFoundError:
                    pass
                except (OSError, KeyError, RuntimeError) as error:
                    wrong.append(repr(error))
                time.sleep(0.001)

        reader = threading.Thread(target=read)
        reader.start()
        try:
            self.run_well("--record", "blood_force=force.h5", settings=["output.every=0.2 ms"])
        finally:
            stop.set()
            reader.join()
        self.assertEqual(wrong, [])
        self.assertGreater(len(set(seen)), 5)
        self.what_a_reader_has_open_stays_as_it_was()
        self.the_series_of_a_run_that_goes_on_is_whole()

    def what_a_reader_has_open_stays_as_it_was(self):
        with h5py.File(self.folder / "out/fields/fluid.h5", "r") as fields, \
             h5py.File(self.folder / "force.h5", "r") as force:
            with h5py.File(self.folder / "out/fields/fluid.h5", "r") as now:
                self.assertAlmostEqual(now["000060"].attrs["time"], 12e-3)
                velocity, values = {n: now[f"{n}/velocity"][:] for n in ("000006", "000060")}, force["values"][:]
            self.run_well("--record", "blood_force=force.h5", settings=self.WEAKER)
            for n, before in velocity.items():
                np.testing.assert_array_equal(fields[f"{n}/velocity"][:], before)
            np.testing.assert_array_equal(force["values"][:], values)
        with h5py.File(self.folder / "out/fields/fluid.h5", "r") as now:
            self.assertAlmostEqual(now["000006"].attrs["time"], 12e-3)
            self.assertGreater(np.abs(now["000006/velocity"][:] - velocity["000060"]).max(), 0)

    def the_series_of_a_run_that_goes_on_is_whole(self):
        whole = (self.folder / "out/fields/mech.xdmf").read_text().count("<Time")
        self.run_well("--restart", "8 ms", settings=self.WEAKER)
        with h5py.File(self.folder / "out/fields/mech.h5", "r") as file:
            times = [file[name].attrs["time"] for name in file if name != "mesh"]
        np.testing.assert_allclose(times, np.arange(0, 17, 2) * 1e-3, atol=1e-12)
        self.assertEqual((self.folder / "out/fields/mech.xdmf").read_text().count("<Time"), whole)


class FullDisks(Results):
    def expect_end(self, launch):
        self.assertEqual(launch.code, 8, launch.output)
        self.assertRegex(launch.output, r"disk full\?|No space left on device")
        for crash in "Segmentation fault", "signal 11", "Signal:", "terminate called":
            self.assertNotIn(crash, launch.output)
        self.assertEqual(launch.orphans, [])

    def small_disk(self, kilobytes):
        disk = self.folder / "disk"
        disk.mkdir(exist_ok=True)
        if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "none", disk], stderr=subprocess.DEVNULL).returncode:
            self.skipTest("mounting a small file system is not permitted here")
        self.addCleanup(lambda: subprocess.run(["umount", disk], check=True))

    def test_a_disk_that_fills_up_with_fields_ends_the_run_and_the_last_checkpoint_restarts(self):
        self.small_disk(1200)
        self.expect_end(self.launch(out="disk/out", settings=["output.every=0.2 ms"], end=400))
        launch = self.run_well("--restart", "disk/out", end=24)
        self.assertIn("goes on from t = ", launch.output)

    def test_a_disk_that_fills_up_with_states_leaves_the_sets_before(self):
        self.small_disk(700)
        self.expect_end(self.launch(out="disk/out", settings=["checkpoint.keep=1000"], end=400))
        self.run_well("--restart", "disk/out", end=100)

    def test_a_disk_that_fills_up_with_a_recording_ends_the_run(self):
        self.small_disk(200)
        self.expect_end(self.launch("--record", "mesh_motion=disk/motion.h5", end=400, scene="no_physics.yaml"))


if __name__ == "__main__":
    unittest.main(verbosity=2)
