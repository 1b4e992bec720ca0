"""What people see and type at a terminal: a line that tells how far a run is, one command for all."""
import json
import os
import pty
import re
import select
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from launch import BIN, SOURCE, Forked, Launch

sys.path.insert(0, str(SOURCE / "tools"))
from launching.terminal import fitted  # noqa: E402
from results import Run  # noqa: E402

PISTON = SOURCE / "configs/benchmarks/piston/efs1.yaml"


class Temporary(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)


class Terminals(Temporary):
    def test_the_line_fits_the_terminal_and_tells_the_time_left_first(self):
        parts = ["left 0:01:00", "300.0 ms", "ejection", "V  80.000 mL  p  120.00 mmHg", "5.0 ms/step", "ep 3  fluid 2"]
        for width in (40, 80, 200):
            self.assertLess(len(fitted(0.375, parts, width)), width)
        self.assertIn("left 0:01:00", fitted(0.375, parts, 60))
        self.assertIn("ep 3  fluid 2", fitted(0.375, parts, 200))

    def test_a_terminal_gets_one_line_that_is_renewed(self):
        main, terminal = pty.openpty()
        command = [sys.executable, SOURCE / "tools/check.py", "--launch", PISTON, "--ranks", "1", "--out", "out", "--set", "time.end=100 ms",
                   "--oversubscribe"]
        process = subprocess.Popen(list(map(str, command)), cwd=self.folder, stdout=terminal, stderr=terminal, stdin=terminal,
                                   env={**os.environ, "COLUMNS": "100"})
        os.close(terminal)
        said = b""
        while True:
            try:
                more = os.read(main, 65536)
            except OSError:  # the other side is closed
                break
            if not more:
                break
            said += more
        os.close(main)
        self.assertEqual(process.wait(), 0, said)
        text = said.decode()
        lines = re.findall(r"\r\033\[K(\[[= ]{20}\] [^\r\n]*)", text)
        self.assertGreater(len(lines), 1, text)
        self.assertIn("100 %", lines[-1])
        self.assertIn("left 0:00:00", lines[-1])
        self.assertTrue(all(len(line) < 100 for line in lines))
        self.assertNotIn("ms/step", re.sub(r"\[[= ]{20}\] [^\r\n]*", "", text), "plain lines on a terminal")
        self.assertEqual(len(re.findall("ms/step", (self.folder / "out/logs/coupler.log").read_text())), 10)


class OneCommand(Temporary):
    def heartbus(self, *words):
        script = SOURCE / "tools/heartbus"
        is_run = words[0] == "run"
        return Launch([sys.executable, script, *words], self.folder) if is_run else Forked(script, words, self.folder)

    def succeed(self, *words):
        launch = self.heartbus(*words)
        self.assertEqual(launch.code, 0, launch.output)
        return launch.output

    def test_every_command_tells_how_it_is_used(self):
        listed = re.findall(r"^  (\w+)  ", self.succeed("--help"), re.M)
        self.assertEqual(listed, ["run", "check", "mesh", "study", "report", "pictures", "trace", "cost", "example"])
        for command in listed:
            if command == "mesh" and not (SOURCE / "tools/mesh").exists():
                continue
            with self.subTest(command):
                said = self.succeed(command, "--help")
                self.assertIn("--", said)
                self.assertRegex(said, r"(?m)^    (\S*tools/)?(heartbus |\w)[^\n]*(yaml|results|SCENE|tube|msh)", "an example")
        self.assertTrue(self.succeed("run", "--help").startswith(f"Usage: {SOURCE / 'tools/heartbus'} run "))
        self.assertIn("did you mean 'report'?", self.heartbus("reprot").output)

    def test_the_shell_completes_commands_examples_and_options(self):
        def completed(*words):
            script = (f"source {SOURCE}/tools/completion.sh; COMP_WORDS=({SOURCE}/tools/heartbus {' '.join(words)}); "
                      f"COMP_CWORD={len(words)}; _heartbus; echo ${{COMPREPLY[@]}}")
            return subprocess.run(["bash", "-c", script], cwd=self.folder, stdout=subprocess.PIPE, text=True).stdout.split()
        self.assertEqual(completed("re"), ["report"])
        self.assertEqual(completed("example", "pis"), ["piston"])
        self.assertIn("--charts", completed("report", "--"))
        self.assertEqual(set(completed("''")), set(re.findall(r"^  (\w+)  ", self.succeed("--help"), re.M)))

    @unittest.skipUnless(shutil.which("zsh"), "there is no zsh here")
    def test_so_does_zsh(self):
        for typed, completed in (("heartbus re", "heartbus report "), ("heartbus example pis", "heartbus example piston "),
                                 ("heartbus report --ch", "heartbus report --charts ")):
            with self.subTest(typed):
                pid, terminal = pty.fork()
                if pid == 0:
                    os.execvpe("zsh", ["zsh", "-f", "-i"], {**os.environ, "TERM": "dumb", "PATH": f"{SOURCE}/tools:{os.environ['PATH']}"})
                typing = f"autoload -Uz compinit; compinit -u -D; source {SOURCE}/tools/completion.sh; echo re''ady\n"
                os.write(terminal, typing.encode())
                self.read_until(terminal, "ready")
                os.write(terminal, f"{typed}\t".encode())
                self.read_until(terminal, completed)
                os.write(terminal, b"\x15exit\n")
                self.read_until(terminal, None)
                os.waitpid(pid, 0)
                os.close(terminal)

    def read_until(self, terminal, text):
        """None: until the other side is closed."""
        said = ""
        while text is None or text not in said:
            if not select.select([terminal], [], [], 30)[0]:
                self.fail(f"{said!r} and nothing more; expected: {text}")
            try:
                said += os.read(terminal, 65536).decode(errors="replace")
            except OSError:
                return self.assertIsNone(text, said)

    def test_a_first_build_says_how_long_it_takes(self):
        tools = self.folder / "tools"
        tools.mkdir()
        shutil.copy(SOURCE / "tools/setup.sh", tools)
        for name in ("cmake", "ninja"):
            (tools / name).write_text("#!/bin/sh\n")
            (tools / name).chmod(0o755)
        build = ["env", f"PATH={tools}:{os.environ['PATH']}", "bash", "-c", f"source {tools}/setup.sh; build programs"]
        self.assertIn("First build, 5 to 10 minutes", Launch(build, self.folder).output)
        coupler = self.folder / "build/release/bin/coupler"
        coupler.parent.mkdir(parents=True)
        coupler.write_text("")
        coupler.chmod(0o755)
        again = Launch(build, self.folder)
        self.assertEqual((again.code, again.output), (0, ""))

    def test_no_report_is_promised_where_there_is_none(self):
        (self.folder / "missing").mkdir()
        (self.folder / "missing/PIL.py").write_text("raise ImportError('no Pillow here')\n")
        launch = Launch(["env", f"PYTHONPATH={self.folder / 'missing'}", sys.executable, SOURCE / "tools/launch.py", PISTON, "--ranks",
                         "1", "--oversubscribe", "--set", "time.end=1 ms", "--set", "output.every=0 ms", "--out", "out"], self.folder)
        self.assertEqual(launch.code, 0, launch.output)
        self.assertIn("Results in out\n", launch.output)
        self.assertIn("python3-pil", launch.output)
        self.assertNotIn("report in", launch.output)

    def test_every_example_is_valid_where_it_is_written(self):
        listed = [line.split()[0] for line in self.succeed("example").splitlines()]
        self.assertGreater(len(listed), 20)
        for name in listed:
            self.succeed("example", name)
            check = Launch([BIN / "coupler", f"{name}.yaml", "--validate"], self.folder)
            self.assertEqual(check.code, 0, check.output)

    def test_from_an_example_to_a_report_and_no_result_is_lost(self):
        """The second run has almost the alpha that the piston's wall bears, as the first one has found it."""
        self.assertIn("piston", self.succeed("example"))
        self.succeed("example", "piston")
        self.assertIn("# ", (self.folder / "piston.yaml").read_text())
        self.assertIn("valid", self.succeed("check", "piston.yaml"))
        words = ["run", "piston.yaml", "--ranks", "1", "--oversubscribe", "--set", "time.end=8 ms", "--set", "output.every=0 ms",
                 "--out", "out"]
        said = self.succeed(*words)
        self.assertIn("largest volume", said)
        self.assertNotIn("Implausible", said)
        before = (self.folder / "out/history.csv").read_bytes()
        alpha = f"alpha={0.95 * Run(self.folder / 'out').history['alpha_limit'][-1]:.0f} kg/(m^2 s)"
        again = self.heartbus(*words, "--set", alpha)
        self.assertEqual(again.code, 8, again.output)
        self.assertIn("--force", again.output)
        self.assertEqual((self.folder / "out/history.csv").read_bytes(), before)
        said = self.succeed(*words, "--set", alpha, "--force")
        self.assertIn("Implausible:", said)
        self.assertIn("coupling.alpha: 'auto'", said)
        about = json.loads((self.folder / "out/provenance.json").read_text())
        self.assertIn(alpha, about["command"])
        self.assertIn(alpha, (self.folder / "out/report/report.html").read_text())


if __name__ == "__main__":
    unittest.main(verbosity=2)
