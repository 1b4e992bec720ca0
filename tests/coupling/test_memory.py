"""Memory stays flat over 6,000 steps, more than a heartbeat's worth: in each participant, and in the coupler but for its history."""
import tempfile
import time
import unittest
from pathlib import Path

from launch import SOURCE, has_mark, run_scene, unless_sanitized

PISTON = SOURCE / "configs/benchmarks/piston/efs1.yaml"
STEPS, FIRST, LAST = 6000, 800, 5800  # the first steps allocate what is allocated once; after the last ones nobody may be left
MOST = 0.01


def resident(environ):
    """(name of the program, KiB) of a process."""
    status = (environ.parent / "status").read_text()
    fields = dict(line.split(":", 1) for line in status.splitlines())
    return fields["Name"].strip(), int(fields["VmRSS"].split()[0])


class Memory(unittest.TestCase):
    def measure(self, history, samples):
        """Appends (step, {program: KiB}) while the run goes on."""

        def watch(process):
            mark = None
            while mark is None and process.poll() is None:  # at first the process still has this one's environment
                mark = next((v.decode() for v in Path(f"/proc/{process.pid}/environ").read_bytes().split(b"\0")
                             if v.startswith(b"HEARTBUS_TEST_MARK=")), None)
            step = 0
            while process.poll() is None and step < LAST:
                step = history.read_text().count("\n") - 2 if history.exists() else 0
                if step > 0:
                    try:
                        samples.append((step, dict(resident(p) for p in Path("/proc").glob("[0-9]*/environ") if has_mark(p, mark))))
                    except (OSError, KeyError):  # one of them has ended
                        pass
                time.sleep(0.05)

        return watch

    @unless_sanitized
    def test_resident_memory_does_not_drift(self):
        samples = []
        with tempfile.TemporaryDirectory() as folder:
            launch = run_scene(PISTON, folder, "--out", "out", "--set", f"time.end={STEPS * 0.2:g} ms", "--set", "output.every=8 ms",
                               during=self.measure(Path(folder) / "out/history.csv", samples))
        self.assertEqual(launch.code, 0, launch.output)
        programs = ["mech_solver", "ale_solver", "fluid_solver", "coupler"]
        samples = [(step, sizes) for step, sizes in samples if step >= FIRST and all(p in sizes for p in programs)]
        self.assertGreater(samples[-1][0] - samples[0][0], 0.6 * STEPS)
        for program in programs:
            first, last = samples[0][1][program], samples[-1][1][program]
            drift = last - first
            print(f"{program}: {first / 1024:.1f} MiB at step {samples[0][0]}, {drift:+d} KiB until step {samples[-1][0]}")
            if program == "coupler":  # keeps the history: some 40 numbers a step
                drift -= (samples[-1][0] - samples[0][0]) * 40 * 8 / 1024
            self.assertLess(drift, MOST * first, program)


if __name__ == "__main__":
    unittest.main(verbosity=2)
