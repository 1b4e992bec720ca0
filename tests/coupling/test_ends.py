"""How a run ends, and the one line that says why: signals, stopped and killed ranks, programs that are none."""
import csv
import json
import os
import shutil
import signal
import socket
import time
from pathlib import Path

import h5py
from launch import BIN, SOURCE, children, main_side_by_side, wait_for
from small_launch import STAND_IN, WITHOUT_REPORT, Case

PISTON = SOURCE / "configs/benchmarks/piston/efs1.yaml"
HOST = socket.gethostname()
SLOW = STAND_IN.replace("0.002", "0.02") % 1  # whom others wait for: who is stopped waits then, too, most probably


def mpirun_of(launcher):
    status = Path(f"/proc/{children(launcher)[0]}/stat").read_text()
    return int(status[status.rindex(")") + 2:].split()[1])


class Deaths(Case):
    SOON = ["--set", "deadline=6 s", "--out", "results/small"]

    def kill(self, rank, number):
        return lambda launcher: os.kill(children(launcher)[rank], number)

    def test_a_rank_that_is_ended_by_a_signal_is_named_with_its_node_and_step(self):
        for rank, number, who in ((2, signal.SIGKILL, r"ep \(rank 1\)"), (1, signal.SIGSEGV, r"ep \(rank 0\)"),
                                  (1, signal.SIGTERM, r"ep \(rank 0\)"), (0, signal.SIGKILL, "coupler")):
            with self.subTest(number.name, who=who):
                memory = "; the kernel has not done it .* GiB" if number == signal.SIGKILL else ""
                self.history.unlink(missing_ok=True)
                launch = self.meanwhile(self.kill(rank, number))
                self.assert_causes(launch, 128 + number, rf"{who} on {HOST}, process \d+, was ended by signal {number:d} "
                                   rf"\({number.name}\){memory}.*; step \d+$")
                self.assertLess(self.seconds, 8)

    def test_a_program_that_is_no_participant_is_named(self):
        launch = self.launch("scene.yaml", "--set", "participants.ep.program=/bin/true", *self.SOON)
        self.assert_causes(launch, 3, r"ep \(rank 0\), ep \(rank 1\) ended without joining .*: is /bin/true a participant\?")
        self.assertLess(launch.seconds, 15)
        self.assertEqual(launch.orphans, [])

    def test_a_rank_that_is_stopped_at_the_start_is_named(self):
        program = self.folder / "stand_in"
        program.write_text(f"#!/bin/sh\n[ $PMIX_RANK = 1 ] || kill -STOP $$\nexec {BIN}/stand_in \"$@\"\n")
        program.chmod(0o755)
        launch = self.launch("scene.yaml", "--set", "participants.ep.program=./stand_in", *self.SOON)
        self.assert_causes(launch, 7, r"waited 6 s \(the deadline\) for all programs to meet",
                           r"ep \(rank 1\), process \d+, has been stopped since ")
        self.assertLess(launch.seconds, 20)
        self.assertEqual(launch.orphans, [])

    def test_a_coupler_that_is_stopped_is_named_within_the_deadline(self):
        launch = self.meanwhile(self.kill(0, signal.SIGSTOP), *self.SOON)
        self.assert_causes(launch, 7, r"a sign of life of the coupler, step \d+", r"coupler, process \d+, has been stopped")
        self.assertLess(self.seconds, 15)

    def stop(self, name, scene, *settings):
        self.history = self.folder / "out/history.csv"
        self.history.unlink(missing_ok=True)

        def stop(launcher):
            pid = next(pid for pid in children(launcher).values()
                       if Path(f"/proc/{pid}/cmdline").read_bytes().endswith(f"--name\0{name}\0".encode()))
            os.kill(pid, signal.SIGSTOP)
        return self.meanwhile(stop, "--out", "out", "--ranks", "1", "--set", "deadline=4 s", *settings, scene=scene)

    def assert_stopped(self, launch, name):
        self.assertNotIn("each other", launch.output)
        self.assert_causes(launch, 7, rf"{name} is busy with|{name} does not take ", rf"{name}, process \d+, has been stopped")

    def test_a_participant_that_is_stopped_is_blamed_whoever_waits_for_whom(self):
        names = ("mech", "ale", "fluid")
        (self.folder / "piston.yaml").write_text(
            f"base: {PISTON}\nparticipants:\n" + "".join(f"  {name}: {SLOW}\n" for name in names))
        for name in names:
            with self.subTest(name):
                self.assert_stopped(self.stop(name, "piston.yaml", "--set", "time.end=20 s", "--set", f"{name}.settings.delay=0"),
                                    name)

    def test_so_is_a_monolithic_solver(self):
        (self.folder / "monolithic.yaml").write_text(f"base: {PISTON}\ncoupling: {{scheme: E1FSinf}}\n"
                                                     f"participants: {{mech: , fluid: , ale: {SLOW}, fsi: {{program: fsi_solver}}}}\n")
        self.assert_stopped(self.stop("fsi", "monolithic.yaml", "--set", "time.end=20 s"), "fsi")

    def test_so_is_a_replay(self):
        (self.folder / "ventricle.yaml").write_text(
            f"base: {SOURCE}/tests/regression/small_heartbeat.yaml\ncoupling: {{scheme: one_way}}\n"
            f"participants: {{ep: {SLOW}, mech: {SLOW}, ale: , fluid: }}\n")
        launch = self.launch("ventricle.yaml", "--out", "recorded", "--record", "calcium=calcium.h5", "--set", "time.end=0.4 ms",
                             "--ranks", "1")
        self.assertEqual(launch.code, 0, launch.output)
        with h5py.File(self.folder / "calcium.h5", "r+") as file:  # its last value, held
            for name, late in (("values", file["values"][1]), ("step", 100000), ("time", 20.)):
                file[name].resize(3, axis=0)
                file[name][2] = late
        (self.folder / "replayed.yaml").write_text(
            (self.folder / "ventricle.yaml").read_text().replace(SLOW, "{program: replay, settings: {file: calcium.h5}}", 1))
        self.assert_stopped(self.stop("ep", "replayed.yaml", "--set", "time.end=20 s"), "ep")


class Signals(Case):
    command = WITHOUT_REPORT

    def assert_saved(self, launch):
        self.assertEqual(launch.code, 0, launch.output)
        self.assertIn("stopped on request", launch.output)
        saved = [json.loads(file.read_text())["time"] for file in (self.history.parent / "checkpoints").glob("*/manifest.json")]
        rows = self.history.read_text().splitlines()
        last = next(csv.DictReader([rows[0], rows[-1]]))
        self.assertAlmostEqual(max(saved, default=0), float(last["time [s]"]), msg="the last step is not saved")

    def test_each_signal_saves_wherever_it_arrives(self):
        def to_mpirun(launcher):
            os.kill(mpirun_of(launcher), signal.SIGTERM)
        for title, action in (("terminal closed", lambda launcher: launcher.send_signal(signal.SIGHUP)),
                              ("SIGTERM", lambda launcher: launcher.send_signal(signal.SIGTERM)),
                              ("SIGTERM to mpirun", to_mpirun)):
            with self.subTest(title):
                shutil.rmtree(self.history.parent, ignore_errors=True)
                self.assert_saved(self.meanwhile(action))

    def test_a_second_signal_ends_at_once(self):
        def twice(launcher):
            os.kill(children(launcher)[1], signal.SIGSTOP)  # so that the first one cannot be followed
            for _ in range(2):
                launcher.send_signal(signal.SIGINT)
                time.sleep(0.5)
        launch = self.meanwhile(twice)
        self.assertEqual(launch.code, 128 + signal.SIGINT, launch.output)
        self.assertLess(self.seconds, 5)

    def test_a_signal_while_programs_start_ends_them(self):
        for delay in (0.05, 0.2, 0.4, 0.8):
            with self.subTest(delay):
                def stop(launcher, delay=delay):
                    lines = iter(launcher.stdout.readline, "")  # another test's dead run may be cleared first
                    self.assertTrue(any("mpirun" in line for line in lines))
                    time.sleep(delay)
                    launcher.send_signal(signal.SIGTERM)
                launch = self.launch("scene.yaml", "--set", "time.end=200 s", "--out", f"results/{delay}", during=stop)
                self.assertIn(launch.code, (0, 128 + signal.SIGTERM), launch.output)
                self.assertEqual(launch.code == 0, "stopped on request" in launch.output, launch.output)
                self.assertEqual(launch.orphans, [])

    def test_what_a_run_leaves_that_died_hard_is_cleared_by_the_next(self):
        """With a folder for sessions of its own: launches of others on this machine clear what they find as well."""
        sessions = self.folder / "tmp"
        sessions.mkdir()
        before = os.environ.get("TMPDIR")
        os.environ["TMPDIR"] = str(sessions)
        self.addCleanup(lambda: os.environ.update(TMPDIR=before) if before else os.environ.pop("TMPDIR"))

        def kill_all(launcher):
            self.name = f"heartbus.{os.geteuid()}.{launcher.pid}"
            self.assertTrue(any((Path("/dev/shm") / self.name).iterdir()))
            ranks = children(launcher)
            for pid in (mpirun_of(launcher), launcher.pid, *ranks.values()):
                os.kill(pid, signal.SIGKILL)
            wait_for(lambda: not any(os.path.exists(f"/proc/{pid}/exe") for pid in ranks.values()))
        self.meanwhile(kill_all)
        self.assertTrue(any((sessions / self.name).rglob("*")))
        launch = self.launch("scene.yaml", "--set", "time.end=2 ms")
        self.assertRegex(launch.output, r"Cleared [\d.]+ MiB")
        self.assertEqual([path.name for path in sessions.glob("heartbus.*")], [])
        self.assertFalse((Path("/dev/shm") / self.name).exists())
        self.assertEqual([path.name for path in self.history.parent.glob(".run-*")], [])

    def test_a_launcher_that_is_killed_takes_its_run_along(self):
        def kill(launcher):
            ranks = children(launcher)
            launcher.kill()
            wait_for(lambda: not any(os.path.exists(f"/proc/{pid}/exe") for pid in ranks.values()), 10)
        self.meanwhile(kill)


if __name__ == "__main__":
    main_side_by_side(3)
