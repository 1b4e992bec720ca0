"""The bus between whole programs: every test's name is the sentence it ensures."""
import os
import signal
import subprocess
import tempfile
import threading
import time
import unittest
import uuid
from pathlib import Path

from launch import SANITIZED, has_mark, main_side_by_side

BIN = os.environ.get("HEARTBUS_BIN", "build/release/bin")
SEQUENCE, DUMMY, REPLAY = (os.path.join(BIN, name) for name in ("coupling_sequence", "coupling_dummy", "replay"))
ENVIRONMENT = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                   OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_MCA_mpi_yield_when_idle="1")


class Run:
    """A launch: apps are lists of words; afterwards its exit code, texts and the time from the cause to the end."""

    def __init__(self, *apps, during=None, variables=()):
        command = ["mpirun"]
        for app in apps:
            command += (["-n"] if len(command) == 1 else [":", "-n"]) + [str(word) for word in app]
        environment = {**ENVIRONMENT, **dict(variables), "HEARTBUS_TEST_MARK": uuid.uuid4().hex}
        self.mark = "HEARTBUS_TEST_MARK=" + environment["HEARTBUS_TEST_MARK"]
        with tempfile.TemporaryFile("w+") as out:
            process = subprocess.Popen(command, env=environment, stdout=out, stderr=subprocess.PIPE, text=True)
            limit = threading.Timer(60, process.terminate)
            limit.start()
            if during:
                during(process)
            self.err, since = "", time.time()
            for line in process.stderr:
                if line.startswith("heartbus: "):
                    since = time.time()
                self.err += line
            process.stderr.close()
            self.code = process.wait()
            self.seconds_to_end = time.time() - since
            limit.cancel()
            out.seek(0)
            self.out = out.read()
        self.causes = [line for line in self.err.splitlines() if line.startswith("heartbus: ")]

    def left_over(self):
        """Its processes that are still there a moment after it has ended."""
        for _ in range(20):
            alive = [path.parent.name for path in Path("/proc").glob("[0-9]*/environ") if has_mark(path, self.mark)]
            if not alive:
                return []
            time.sleep(0.1)
        return alive


def sequence(*words, steps=2, dt=0.1, deadline=10):
    return [1, SEQUENCE, steps, dt, deadline, *words]


def pair(*words, a=1, b=1, variables=(), during=None, **options):
    return Run(sequence(*words, **options), [a, DUMMY, "--name", "a"], [b, DUMMY, "--name", "b"], during=during, variables=variables)


class Bus(unittest.TestCase):
    def assert_cause(self, run, code, *parts):
        """One message of the cause, from the coupler alone, and the culprit's exit code within five seconds."""
        self.assertEqual(run.code, code, run.err)
        self.assertEqual(len(run.causes), 1, run.err)
        for part in parts:
            self.assertIn(part, run.err)
        self.assertLess(run.seconds_to_end, 5)
        self.assertEqual(run.left_over(), [])

    def test_values_arrive_at_the_right_points_on_one_rank_each(self):
        run = pair()
        self.assertEqual(run.code, 0, run.err)
        self.assertIn("a was prepared 2 times, phase of b is 0", run.out)
        self.assertIn("lowest 0, highest 10, unknown 1, ranks 1", run.out)
        self.assertIn("b has finished after 2 steps", run.out)

    def test_values_arrive_at_the_right_points_from_two_ranks_to_three(self):
        run = pair(a=2, b=3, steps=50)
        self.assertEqual(run.code, 0, run.err)
        self.assertIn("lowest -1, highest 11, unknown nan, ranks 2", run.out)
        self.assertIn("coupler heard 100 transfers", run.out)

    def test_values_arrive_from_node_to_node(self):
        elsewhere = ["env", "HEARTBUS_NODE=1", DUMMY, "--name"]
        run = Run(sequence(steps=20), [1, DUMMY, "--name", "a"], [1, *elsewhere, "a"], [1, DUMMY, "--name", "b"],
                  [2, *elsewhere, "b"])
        self.assertEqual(run.code, 0, run.err)
        self.assertIn("lowest -1, highest 11, unknown nan, ranks 2", run.out)
        self.assertIn("coupler heard 40 transfers", run.out)

    def test_a_failure_on_another_node_ends_all(self):
        run = Run(sequence("fail", "a"), [2, "env", "HEARTBUS_NODE=1", DUMMY, "--name", "a"], [2, DUMMY, "--name", "b"])
        self.assert_cause(run, 5, "heartbus: a (rank 1): CG has not converged in 7 iterations")

    def test_a_point_without_partner_is_named_with_its_neighbour(self):
        run = pair("shifted", "b", b=2)
        self.assert_cause(run, 4, "1 of 30 points of b.points", "(0.0173, ", "(0.017, ", "is 0.0003 m away")

    def test_a_mesh_in_millimetres_is_recognised(self):
        self.assert_cause(pair("millimetres", "b"), 4, "b.points looks like millimetres")

    def test_different_units_are_refused(self):
        self.assert_cause(pair("other_unit", "a"), 3, "'kPa'", "'Pa'")

    def test_an_unknown_field_is_refused_with_what_there_is(self):
        self.assert_cause(pair("unknown_field", "nobody"), 3, "a declares no output 'sound'; it has: signal")

    def test_a_missing_participant_is_named_with_who_came(self):
        run = Run(sequence(), [1, DUMMY, "--name", "a"])
        self.assert_cause(run, 3, "participant 'b' is missing", "expected: a (coupling_dummy), b (coupling_dummy)",
                          "came: coupler (coupler, 1 rank), a (coupling_dummy, 1 rank)")

    def test_an_unexpected_participant_is_named(self):
        run = Run(sequence(), *([1, DUMMY, "--name", name] for name in "abc"))
        self.assert_cause(run, 3, "participant 'c' is not in the scene")

    def test_one_name_for_two_programs_is_refused(self):
        run = Run(sequence(), [1, DUMMY, "--name", "a"], [1, REPLAY, "--name", "a"])
        self.assert_cause(run, 3, "two programs claim the name 'a': coupling_dummy and replay")

    def test_another_protocol_is_named(self):
        old = ("import struct, numpy as np\nfrom mpi4py import MPI\ncontrol, data = MPI.COMM_WORLD.Dup(), MPI.COMM_WORLD.Dup()\n"
               "sizes = np.empty(control.size, 'i')\ncontrol.Allgather(np.array([4], 'i'), sizes)\n"
               "control.Allgatherv(struct.pack('i', 8), [bytearray(sizes.sum()), sizes.tolist(), MPI.BYTE])\n")
        run = Run(sequence(), [1, DUMMY, "--name", "a"], [1, "/usr/bin/python3", "-c", old])
        self.assertEqual(run.code, 3, run.err)
        self.assertRegex(run.err, r"heartbus: rank 2 speaks protocol 8 of the bus instead of \d+: build all programs from the same source")

    def test_a_launch_without_coupler_is_refused(self):
        self.assert_cause(Run([2, DUMMY, "--name", "a"]), 3, "nobody in this launch is the coupler")

    def test_a_deadline_names_who_waits_for_whom_and_why(self):
        run = pair("hang", "a", deadline=1, b=2)
        self.assert_cause(run, 7, "heartbus: b (rank ", "waited 1 s (the deadline) for field 'signal' from a (rank 0)",
                          "step 1, iteration 0; a is busy with solve")

    def test_a_transfer_that_nobody_sends_is_explained(self):
        self.assert_cause(pair("forget", "coupler", deadline=1), 7, "a has not been ordered to do anything more")

    def test_the_failure_of_one_rank_ends_all_with_its_code(self):
        run = pair("fail", "a", a=3, b=2)
        self.assert_cause(run, 5, "heartbus: a (rank 2): CG has not converged in 7 iterations")

    def test_everybody_closes_files_before_the_launch_ends_after_a_failure(self):
        for _ in range(5):
            self.assertEqual(pair("fail", "a", a=2, b=3).out.count("has closed its files"), 5)

    def test_ranks_stuck_in_a_collective_of_their_solver_are_ended_too(self):
        run = pair("fail_in_collective", "a", a=3)
        self.assert_cause(run, 5, "heartbus: a (rank 2)")

    def test_a_failure_before_the_first_command_ends_all(self):
        self.assert_cause(pair("fail_early", "b", b=2), 8, "heartbus: b (rank 0): cannot read the mesh")

    def test_an_unforeseen_exception_ends_all(self):
        self.assert_cause(pair("exception", "a"), 1, "heartbus: a (rank 0): something else went wrong")

    def test_a_failure_of_the_coupler_ends_all(self):
        self.assert_cause(pair("fail", "coupler"), 2, "heartbus: coupler: the scene is wrong")

    def test_a_crash_ends_all(self):
        run = pair("crash", "a", a=2)
        self.assertNotEqual(run.code, 0)
        self.assertLess(run.seconds_to_end, 20)
        self.assertEqual(run.left_over(), [])

    def test_nan_is_refused_by_the_sender(self):
        self.assert_cause(pair("nan", "a"), 6, "heartbus: a (rank 0): field 'signal' is nan at point (0, 0, 0.002)",
                          "component 1, step 1, iteration 0")

    def test_what_would_overflow_is_refused_by_the_sender(self):
        self.assert_cause(pair("huge", "a"), 6, "heartbus: a (rank 0): field 'signal' is 1e+300 at point (0, 0, 0.002)",
                          "component 1, step 1, iteration 0")

    def test_a_waiting_participant_uses_less_than_a_twentieth_of_a_core_and_outlives_sigusr1(self):
        def send_signal(process):
            time.sleep(1.5)
            process.send_signal(signal.SIGUSR1)
        run = pair("slow", "a", b=2, steps=1, during=send_signal)
        self.assertEqual(run.code, 0, run.err)
        words = next(line for line in run.out.splitlines() if line.startswith("b received")).split()
        waited, cpu = float(words[3]), float(words[7])
        print(f"  2 ranks have waited {waited:.1f} s and used {cpu:.3f} CPU s", flush=True)
        self.assertGreater(waited, 5)
        self.assertLess(cpu / 2, 0.05 * waited)

    def assert_nobody_oversleeps(self, run):
        self.assertEqual(run.code, 0, run.err)
        self.assertIn("coupler heard 60 transfers", run.out)
        words = next(line for line in run.out.splitlines() if "overslept" in line)
        print("  " + words, flush=True)
        self.assertTrue(SANITIZED or words.startswith("0 waits overslept"), words)

    def test_no_ring_is_lost_by_twelve_ranks_each_that_fill_the_transport(self):
        self.assert_nobody_oversleeps(pair("chatter", "all", a=12, b=12, steps=30))

    def test_no_ring_is_lost_by_twenty_ranks_each_that_fill_the_transport(self):
        self.assert_nobody_oversleeps(pair("chatter", "all", a=20, b=20, steps=30))

    def test_no_ring_is_lost_by_a_transport_with_tiny_buffers(self):
        tiny = {"OMPI_MCA_btl_vader_segment_size": "65536"}
        self.assert_nobody_oversleeps(pair("chatter", "all", a=12, b=8, steps=30, variables=tiny))

    def test_no_ring_is_lost_where_ranks_share_a_number_in_sets_of_63(self):
        self.assert_nobody_oversleeps(pair(a=33, b=33, steps=30))


class Source(unittest.TestCase):
    def test_only_the_bus_names_the_world_of_all_programs(self):
        source = os.environ.get("HEARTBUS_SOURCE", ".")
        named = subprocess.run(["grep", "-rl", "--include=*.cpp", "--include=*.h", "--exclude-dir=build",
                                "--exclude-dir=tests", "MPI_COMM_WORLD", "."],
                               cwd=source, stdout=subprocess.PIPE, text=True).stdout.split()
        self.assertEqual(sorted(named), ["./common/bus/world.cpp", "./common/bus/world.h"])


class Recording(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.file = os.path.join(folder.name, "signal.h5")
        run = pair("record", "coupler", cls.file, a=2, steps=3)
        assert run.code == 0, run.err

    def replay(self, **options):
        return Run(sequence("replay", "a", self.file, **options), [2, REPLAY, "--name", "a"],
                   [3, DUMMY, "--name", "b"])

    def test_a_replayed_participant_cannot_be_told_from_the_original(self):
        run = self.replay(steps=3)
        self.assertEqual(run.code, 0, run.err)
        self.assertIn("coupler heard 6 transfers", run.out)

    def test_a_replay_with_smaller_steps_is_interpolated(self):
        run = self.replay(steps=2, dt=0.05)  # b is content with step 1, held before the recording begins, then hears it again
        self.assertEqual(run.code, 4, run.err)
        self.assertRegex(run.err, "a wrong value has arrived|has heard a wrong value")  # whoever is first

    def test_a_replay_beyond_the_recording_is_refused(self):
        run = self.replay(steps=4)
        self.assertEqual(run.code, 8, run.err)
        self.assertIn("ends at t = 0.3 s, this run is at t = 0.4 s", run.err)


if __name__ == "__main__":
    main_side_by_side(2)
