"""./run as a user has it: all options, and names of any kind."""
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from launch import BIN, SOURCE, Launch, main_side_by_side
from small_launch import SMALL, WITHOUT_REPORT, Case

PISTON = SOURCE / "configs/benchmarks/piston/efs1.yaml"


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


if __name__ == "__main__":
    main_side_by_side(3)
