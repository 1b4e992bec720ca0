"""Two nodes made of namespaces of this machine: networks of their own, joined by one cable, host names and shared memory of
their own. What several machines have in common, they have, too: the files."""
import csv
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

from launch import SOURCE, Launch, main_side_by_side

SCENE = SOURCE / "tests/regression/small_heartbeat.yaml"
MANY = """
scene: many
time: {end: 20 s, step: 0.2 ms}
coupling: {scheme: one_way}
participants: {ep: {program: stand_in, ranks: 8, settings: {mischief: none, step: 0, delay: 0.002}}}
geometry: {mesh: MXS}
electrophysiology: {refinements: 0}
output: {every: 0 ms}
"""
NODES = {"node-a": "10.213.77.1", "node-b": "10.213.77.2"}
AGENT = """#!/bin/sh
# How mpirun reaches a node: AGENT NODE COMMAND...
exec {folder}/enter "$@"
"""
ENTER = """#!/bin/sh
case $1 in
{cases}
esac
shift
exec nsenter -t $pid -n -u -m sh -c "cd $PWD; $*"
"""


def command(*words):
    subprocess.run([str(word) for word in words], check=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)


class Cluster:
    """The nodes; each lives while its first process does."""

    def __init__(self, folder):
        self.folder = Path(folder)
        (self.folder / "names").write_text("127.0.0.1 localhost\n" + "".join(f"{ip} {name}\n" for name, ip in NODES.items()))
        self.pids = {}
        for name in NODES:
            process = subprocess.Popen(["unshare", "-n", "-u", "-m", "sh", "-c",
                                        f"hostname {name} && mount -t tmpfs none /dev/shm && mount --bind {folder}/names "
                                        f"/etc/hosts && ip link set lo up && touch {folder}/{name} && exec sleep 1000"],
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            self.pids[name] = process
        end = time.monotonic() + 10
        while not all((self.folder / name).exists() for name in NODES):
            if time.monotonic() > end or any(process.poll() is not None for process in self.pids.values()):
                raise PermissionError("namespaces are not permitted")
            time.sleep(0.02)
        a, b = (f"hb{os.getpid()}{end}" for end in "ab")
        command("ip", "link", "add", a, "type", "veth", "peer", "name", b)
        for cable, (name, ip) in zip((a, b), NODES.items()):
            command("ip", "link", "set", cable, "netns", self.pids[name].pid)
            for words in (["addr", "add", f"{ip}/24", "dev", cable], ["link", "set", cable, "up"]):
                command("nsenter", "-t", self.pids[name].pid, "-n", "ip", *words)
        self.cable = b
        cases = "\n".join(f"{name}|{NODES[name]}) pid={process.pid} ;;" for name, process in self.pids.items())
        for name, text in (("enter", ENTER.format(cases=cases)), ("agent", AGENT.format(folder=folder))):
            (self.folder / name).write_text(text)
            (self.folder / name).chmod(0o755)

    def on_first_node(self, *words):
        return ["nsenter", "-t", str(self.pids["node-a"].pid), "-n", "-u", "-m", "env", "-C", str(self.folder),
                f"OMPI_MCA_plm_rsh_agent={self.folder}/agent", *words]

    def pull_the_plug(self):
        command("nsenter", "-t", self.pids["node-b"].pid, "-n", "ip", "link", "set", self.cable, "down")

    def processes(self, name):
        """Of a node: those in its network."""
        network = os.readlink(f"/proc/{self.pids[name].pid}/ns/net")
        found = []
        for pid in (int(entry) for entry in os.listdir("/proc") if entry.isdigit()):
            try:
                if os.readlink(f"/proc/{pid}/ns/net") == network and pid != self.pids[name].pid:
                    found.append(pid)
            except OSError:
                pass
        return found

    def close(self):
        for name, first in self.pids.items():
            if first.poll() is None:
                for pid in self.processes(name):
                    os.kill(pid, signal.SIGKILL)
            first.kill()
            first.wait()


def history(folder):
    with open(folder / "history.csv", encoding="utf-8") as file:
        return list(csv.DictReader(file))


class TwoNodes(unittest.TestCase):
    def setUp(self):
        if missing := [program for program in ("ip", "nsenter", "unshare") if not shutil.which(program)]:
            self.skipTest(f"{', '.join(missing)} not installed (iproute2, util-linux)")
        if os.geteuid() != 0:
            self.skipTest("only root may make nodes of namespaces")
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        try:
            self.cluster = Cluster(self.folder)
        except (PermissionError, subprocess.CalledProcessError) as error:
            self.skipTest(f"no namespaces here: {error}")
        self.addCleanup(self.cluster.close)

    def run_scene(self, *words, scene=SCENE, ranks=2, hosts=None, during=None):
        launch = [sys.executable, str(SOURCE / "tools/check.py"), "--launch", str(scene), "--ranks", str(ranks), *words]
        if hosts:
            (self.folder / "hosts").write_text(hosts)
            launch = self.cluster.on_first_node(*launch, "--hosts", "hosts")
        return Launch(launch, self.folder, during)

    def test_fields_travel_by_tcp_and_the_history_is_the_same_wherever_ranks_are(self):
        beat = ["--set", "time.end=4 ms", "--set", "electrophysiology.refinements=0"]
        launch = self.run_scene(*beat, "--out", "here")
        self.assertEqual(launch.code, 0, launch.output)
        expected = history(self.folder / "here")
        for placement, slots in (("shared", 1), ("spread", 2)):
            with self.subTest(placement):
                launch = self.run_scene(*beat, "--out", placement, "--placement", placement,
                                        hosts=f"node-a slots={slots}\nnode-b slots={slots}\n")
                self.assertEqual(launch.code, 0, launch.output)
                self.assertEqual(launch.orphans, [])
                self.assertIn("--host node-b:" if placement == "spread" else "--host node-a:1,node-b:1", launch.output)
                rows = history(self.folder / placement)
                self.assertEqual(len(rows), len(expected))
                for row, wanted in zip(rows, expected):
                    for key, value in wanted.items():
                        if value[-1:].isdigit():
                            self.assertAlmostEqual(float(row[key]), float(value), delta=1e-10 * max(1, abs(float(value))), msg=key)
                        else:
                            self.assertEqual(row[key], value)

    def vanish(self, how, **options):
        """Ends a run on both nodes while it works; returns it and how long it took to end."""
        def during(_launcher):
            file, end = self.folder / "out/history.csv", time.monotonic() + 60
            while not (file.exists() and file.read_text().count("\n") > 5):
                self.assertLess(time.monotonic(), end)
                time.sleep(0.05)
            self.assertGreater(len(self.cluster.processes("node-b")), 4)
            how()
            self.since = time.monotonic()
        launch = self.run_scene("--set", "deadline=15 s", "--set", "time.end=800 ms", "--out", "out",
                                hosts="node-a slots=4\nnode-b slots=4\n", during=during, **options)
        return launch, time.monotonic() - self.since

    def assert_missed(self, launch, seconds):
        self.assertNotEqual(launch.code, 0)
        causes = [line for line in launch.output.splitlines() if line.startswith("heartbus: ")]
        self.assertEqual(len(causes), 1, launch.output)
        self.assertRegex(causes[0], r"(node node-b does not answer any more|a node cannot be reached, or mpirun's daemon there has "
                                    r"ended: node-b); step \d+")
        self.assertLess(seconds, 15)

    def test_a_node_that_loses_its_network_ends_the_run_within_the_deadline(self):
        launch, seconds = self.vanish(self.cluster.pull_the_plug)
        self.assert_missed(launch, seconds)
        end = time.monotonic() + 30
        while self.cluster.processes("node-b") and time.monotonic() < end:
            time.sleep(0.2)
        self.assertEqual(self.cluster.processes("node-b"), [])

    def test_a_node_that_dies_ends_the_run_at_once(self):
        def die():
            for pid in self.cluster.processes("node-b"):
                os.kill(pid, signal.SIGKILL)
        (self.folder / "many.yaml").write_text(MANY)  # without physics: it is mpirun that notices
        self.assert_missed(*self.vanish(die, scene="many.yaml", ranks=8))

    def test_a_node_that_cannot_be_reached_is_told_at_the_start(self):
        self.cluster.pids["node-b"].kill()
        launch = self.run_scene("--out", "out", hosts="node-a slots=1\nnode-b slots=1\n")
        self.assertNotEqual(launch.code, 0)
        self.assertIn("heartbus: a node cannot be reached, or mpirun's daemon there has ended: node-b; it was starting", launch.output)
        self.assertIn("check network connectivity", launch.output)
        self.assertEqual(launch.orphans, [])


if __name__ == "__main__":
    main_side_by_side(2)
