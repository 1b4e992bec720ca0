"""./run as a user has it: all options, names of any kind, and one line that says why a run has ended."""
import csv
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import h5py
from launch import BIN, SOURCE, Launch, children, main_side_by_side, wait_for

LAUNCH = [sys.executable, SOURCE / "tools/launch.py"]
WITHOUT_REPORT = [sys.executable, SOURCE / "tools/check.py", "--launch"]
HOST = socket.gethostname()
SMALL = """
scene: small
time: {end: 20 s, step: 0.2 ms}
coupling: {scheme: one_way, deadline: 30 s}
participants: {ep: {ranks: 2}}
geometry: {mesh: MXS}
electrophysiology: {refinements: 1}
output: {every: 0 ms}
"""
STAND_IN = "{program: stand_in, ranks: %d, settings: {mischief: none, step: 0, delay: 0.002}}"
NO_PHYSICS = SMALL.replace("{ranks: 2}", STAND_IN % 2)  # the same in no time
PISTON = SOURCE / "configs/benchmarks/piston/efs1.yaml"


def mpirun_of(launcher):
    status = Path(f"/proc/{children(launcher)[0]}/stat").read_text()
    return int(status[status.rindex(")") + 2:].split()[1])


class Case(unittest.TestCase):
    text = NO_PHYSICS
    command = LAUNCH

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        (self.folder / "scene.yaml").write_text(self.text)
        self.history = self.folder / "results/small/history.csv"

    def is_running(self):
        return self.history.exists() and self.history.read_text().count("\n") > 5

    def launch(self, *words, during=None):
        return Launch([*self.command, *words], self.folder, during)

    def meanwhile(self, action, *words, scene="scene.yaml"):
        """A run, and what is done to it once it is under way."""
        def during(launcher):
            wait_for(self.is_running)
            action(launcher)
            self.since = time.monotonic()
        launch = self.launch(scene, *words, during=during)
        self.seconds = time.monotonic() - self.since
        self.assertEqual(launch.orphans, [])
        return launch

    def assert_causes(self, launch, code, *patterns):
        causes = [line for line in launch.output.splitlines() if line.startswith("heartbus: ")]
        self.assertEqual(launch.code, code, launch.output)
        self.assertEqual(len(causes), len(patterns), launch.output)
        for cause, pattern in zip(causes, patterns):
            self.assertRegex(cause, pattern)


class Words(Case):
    text = SMALL

    def installation(self):
        """As another user has it: nothing in it may be written, nothing is to be built."""
        root = self.folder / "installation"
        (root / "build/release").mkdir(parents=True)
        shutil.copytree(BIN, root / "build/release/bin", symlinks=True, copy_function=os.symlink)
        for name in ("tools", "configs"):
            shutil.copytree(SOURCE / name, root / name, ignore=shutil.ignore_patterns("__pycache__"))
        for name in ("run", "packages.txt"):
            shutil.copy(SOURCE / name, root)
        for path in [root, *root.rglob("*")]:
            if not path.is_symlink():
                path.chmod(path.stat().st_mode & ~0o222)
        self.addCleanup(lambda: subprocess.run(["chmod", "-R", "u+w", root], check=True))
        here = self.folder / "here"
        here.mkdir()
        shutil.copy(self.folder / "scene.yaml", here)
        if os.geteuid() == 0:  # who may write everywhere
            self.folder.chmod(0o755)
            shutil.chown(here, 65534)
            as_somebody = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"]
        else:
            as_somebody = []
        return here, [*as_somebody, "env", "-u", "HEARTBUS_BIN", f"HOME={here}", root / "run"]

    def installs(self, missing, instead=()):
        """What would be installed on a machine that lacks some of the packages and has others instead."""
        tools = self.folder / "package_tools"
        tools.mkdir(exist_ok=True)
        wanted = re.sub("^#.*$", "", (SOURCE / "packages.txt").read_text(), flags=re.M).replace("|", " ").split()
        there = [name for name in wanted if name not in missing and name != "python3-paraview"] + list(instead)
        for name, does in (("dpkg-query", "cat <<E\n" + "\n".join(f"{name} installed" for name in there) + "\nE\nexit 1"),
                           ("apt-get", f'echo "$@" >> {tools}/asked'), ("sudo", '"$@"')):
            (tools / name).write_text(f"#!/bin/sh\n{does}\n")
            (tools / name).chmod(0o755)
        (tools / "asked").write_text("")
        subprocess.run(["bash", "-c", f"source {SOURCE}/tools/setup.sh; install_packages"], check=True, stdout=subprocess.DEVNULL,
                       env={**os.environ, "PATH": f"{tools}:{os.environ['PATH']}"})
        return [line for line in (tools / "asked").read_text().splitlines() if "install" in line]

    def test_what_is_missing_is_installed_and_nothing_removed_for_it(self):
        self.assertEqual(self.installs([]), [])
        self.assertEqual(self.installs(["python3-vtk9"], ["python3-paraview"]), [], "which exclude each other")
        asked = self.installs(["cmake", "python3-vtk9"])
        self.assertEqual(len(asked), 1)
        self.assertEqual(asked[0].split()[-2:], ["cmake", "python3-vtk9"])
        self.assertIn("--no-remove", asked[0])

    def run_there(self, *words):
        if not hasattr(self, "there"):
            self.there = self.installation()
        return Launch([*self.there[1], *words], self.there[0])

    def test_a_read_only_installation_serves_everybody_and_reads_no_name_as_a_command(self):
        launch = self.run_there("scene.yaml", "--set", "time.end=2 ms")
        self.assertEqual(launch.code, 0, launch.output)
        here = self.there[0]
        self.assertTrue((here / "results/small/history.csv").exists())
        self.assertEqual(list(Path(tempfile.gettempdir()).glob("heartbus.65534.*")), [])
        before = sorted(here.rglob("*"))
        for words in (["$(touch pwned).yaml", "--validate"], ["`touch pwned`.yaml"], ["scene.yaml", "--set", "$(touch pwned)=1"],
                      ["a'; touch pwned; '.yaml"], ["--validate"], ["scene.yaml", "--validate"], ["--print-defaults"],
                      ["--help"], ["scene.yaml", "--print", "mpirun"], ["scene.yaml", "--print", "slurm", "--cores", "1"]):
            with self.subTest(words):
                launch = self.run_there(*words)
                self.assertEqual(launch.code == 0, "touch" not in " ".join(words), launch.output)
                self.assertEqual(sorted(here.rglob("*")), before)
                self.assertNotIn("\nmpirun -n", "\n" + launch.output)

    def test_odd_names_reach_the_programs_as_they_are(self):
        out = "a $(touch pwned) 'b' \"c\";é"
        launch = self.launch("scene.yaml", "--set", "time.end=2 ms", "--out", out)
        self.assertEqual(launch.code, 0, launch.output)
        self.assertTrue((self.folder / out / "history.csv").exists())
        self.assertFalse((self.folder / "pwned").exists())

    def test_help_of_run_is_told_before_anything_is_built(self):
        (self.folder / "tools").mkdir()
        shutil.copy(SOURCE / "tools/setup.sh", self.folder / "tools")
        shutil.copy(SOURCE / "run", self.folder)
        help_of_run = Launch(["./run", "--help"], self.folder)
        self.assertEqual(help_of_run.code, 0, help_of_run.output)
        self.assertTrue(help_of_run.output.startswith("./run [SCENE] "), help_of_run.output)
        self.assertFalse((self.folder / "build").exists())

    def test_options_of_the_coupler_and_of_the_launch_are_told(self):
        text = self.launch("--help").output
        self.assertTrue(text.startswith(f"Usage: {self.command[-1]} [SCENE]"), text)
        self.assertNotIn("Usage: coupler", text)
        for option in ("--set", "--restart", "--validate", "--hosts", "--print", "--oversubscribe", "--force"):
            self.assertIn(option, text)

    def test_more_ranks_than_cores_are_refused_unless_they_are_meant(self):
        launch = self.launch("scene.yaml", "--ranks", "9999")
        self.assertEqual(launch.code, 2, launch.output)
        self.assertIn("9999 ranks, but this machine has", launch.output)
        self.assertEqual(self.launch("scene.yaml", "--ranks", "9999", "--oversubscribe", "--print", "mpirun").code, 0)



class Names(Case):
    command = WITHOUT_REPORT

    def run_well(self, *words):
        launch = self.launch("scene.yaml", *words)
        self.assertEqual(launch.code, 0, launch.output)
        return launch.output

    def test_results_are_named_by_what_is_set_and_a_longer_run_goes_on_in_them(self):
        short, long = ["--set", "time.end=4 ms"], ["--set", "time.end=8 ms"]
        self.run_well(*short)
        self.run_well(*short, "--set", "time.step=0.1 ms", "--set", "mesh=M0")
        folders = ["small", "small-mesh=M0-time.step=0.1ms"]
        self.assertEqual(sorted(path.name for path in (self.folder / "results").iterdir()), folders)
        refused = self.launch("scene.yaml", *long)
        self.assertEqual(refused.code, 8, refused.output)
        self.assertIn("results/small: holds the results of a run; --force", refused.output)
        self.assertIn("goes on from t = 4.0 ms", self.run_well(*long, "--restart", "latest"))
        self.run_well(*short, "--force")
        nowhere = self.launch("scene.yaml", *long, "--set", "deadline=9 s", "--restart", "latest")
        self.assertEqual(nowhere.code, 8, nowhere.output)
        self.assertIn("no complete checkpoint in results/small-deadline=9s/checkpoints; there are checkpoints in results/small, "
                      "results/small-mesh=M0-time.step=0.1ms: --restart FOLDER", nowhere.output)


class Nodes(Case):
    """Where ranks go on several nodes; tests/coupling/test_nodes.py runs there."""

    def line(self, hosts, *words, scene=PISTON):
        (self.folder / "hosts").write_text(hosts)
        launch = self.launch(scene, "--hosts", "hosts", "--print", "mpirun", *words)
        return launch, re.findall(r"--host (\S+) -n (\d+) \S+/(\w+)", launch.output)

    def test_participants_share_all_nodes_or_have_nodes_of_their_own(self):
        hosts = "# two\nnode-a slots=4\nnode-b:4 # as well\n"
        self.assertEqual(self.line(hosts, "--ranks", "4")[1], [
            ("node-a:1", "1", "coupler"), *(("node-a:2,node-b:2", "4", f"{name}_solver") for name in ("ale", "fluid", "mech"))])
        self.assertEqual(self.line(hosts, "--ranks", "4", "--placement", "spread")[1], [
            ("node-a:1", "1", "coupler"), ("node-a:4", "4", "ale_solver"), ("node-b:4", "4", "fluid_solver"),
            ("node-a:4", "4", "mech_solver")])
        self.assertEqual(self.line("node-a slots=3\nnode-b slots=1\n", "--ranks", "4")[1][1][0], "node-a:3,node-b:1")

    def test_what_does_not_fit_or_is_no_hosts_file_is_refused(self):
        for hosts, words, part in (("node-a slots=4\nnode-b slots=4\n", ["--ranks", "9"], "9 ranks, but the 2 nodes have 8 cores"),
                                   ("node-a slots=4\nnode b\n", [], "hosts:2: 'node b' is no host"), ("", [], "hosts: names no host")):
            with self.subTest(part):
                launch, _ = self.line(hosts, *words)
                self.assertEqual(launch.code, 2, launch.output)
                self.assertIn(part, launch.output)

    def test_a_job_script_starts_every_task_where_it_belongs(self):
        """With stand-ins for what SLURM brings along, which start the same programs by mpirun."""
        (self.folder / "scontrol").write_text("#!/bin/sh\necho one; echo two\n")
        (self.folder / "srun").write_text(f"#!{sys.executable}\n" + """
import os, shlex, sys
file = sys.argv[sys.argv.index("--multi-prog") + 1]
words = []
for line in open(file):
    ranks, *program = shlex.split(line)
    first, _, last = ranks.partition("-")
    words += [":"] * bool(words) + ["-n", str(int(last or first) - int(first) + 1), *program]
open("tasks", "w").write(open(os.environ["SLURM_HOSTFILE"]).read())
os.execvp("mpirun", ["mpirun", *words])
""")
        for name in ("srun", "scontrol"):
            (self.folder / name).chmod(0o755)
        for placement, tasks in (("shared", "one one two"), ("spread", "one one one two two"),):
            with self.subTest(placement):
                n_nodes = 2
                more = [] if placement == "shared" else ["--set", "participants.ep.ranks=4"]
                job = self.launch("scene.yaml", "--set", "time.end=2 ms", "--out", f"out {placement}", "--print", "slurm", "--nodes",
                                  n_nodes, "--cores", "2", "--placement", placement, *more)
                self.assertEqual(job.code, 0, job.output)
                self.assertIn(f"#SBATCH --nodes={n_nodes}\n", job.output)
                self.assertRegex(job.output, r"#SBATCH --mem=[1-9]\d\d+M\n")
                (self.folder / "job").write_text(job.output)
                launch = Launch(["env", f"PATH={self.folder}:{os.environ['PATH']}", "SLURM_JOB_NODELIST=x", "bash", "job"], self.folder)
                self.assertEqual(launch.code, 0, launch.output)
                self.assertEqual((self.folder / "tasks").read_text().split(), tasks.split())
                self.assertTrue((self.folder / f"out {placement}/history.csv").exists())
                self.assertEqual(list(self.folder.glob(".job*")), [])


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
        program.write_text(f"#!/bin/sh\n[ $OMPI_COMM_WORLD_RANK = 1 ] || kill -STOP $$\nexec {BIN}/stand_in \"$@\"\n")
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
            f"base: {PISTON}\nparticipants:\n" + "".join(f"  {name}: {STAND_IN % 1}\n" for name in names))
        for name in names:
            with self.subTest(name):
                self.assert_stopped(self.stop(name, "piston.yaml", "--set", "time.end=20 s"), name)

    def test_so_is_a_monolithic_solver(self):
        (self.folder / "monolithic.yaml").write_text(f"base: {PISTON}\ncoupling: {{scheme: E1FSinf}}\n"
                                                     "participants: {mech: , fluid: , fsi: {program: fsi_solver}}\n")
        self.assert_stopped(self.stop("fsi", "monolithic.yaml", "--set", "time.end=20 s"), "fsi")

    def test_so_is_a_replay(self):
        (self.folder / "ventricle.yaml").write_text(
            f"base: {SOURCE}/tests/regression/small_heartbeat.yaml\ncoupling: {{scheme: one_way}}\n"
            f"participants: {{ep: {STAND_IN % 1}, mech: {STAND_IN % 1}, ale: , fluid: }}\n")
        launch = self.launch("ventricle.yaml", "--out", "recorded", "--record", "calcium=calcium.h5", "--set", "time.end=0.4 ms",
                             "--ranks", "1")
        self.assertEqual(launch.code, 0, launch.output)
        with h5py.File(self.folder / "calcium.h5", "r+") as file:  # its last value, held
            for name, late in (("values", file["values"][1]), ("step", 100000), ("time", 20.)):
                file[name].resize(3, axis=0)
                file[name][2] = late
        (self.folder / "replayed.yaml").write_text(
            (self.folder / "ventricle.yaml").read_text().replace(STAND_IN % 1, "{program: replay, settings: {file: calcium.h5}}", 1))
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
                launch = self.launch("scene.yaml", "--set", "time.end=200 s", during=stop)
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
