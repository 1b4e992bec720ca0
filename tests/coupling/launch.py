"""Runs commands as a user would, and finds whoever they leave behind."""
import os
import runpy
import shlex
import subprocess
import sys
import tempfile
import time
import traceback
import unittest
import uuid
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

BIN = Path(os.environ["HEARTBUS_BIN"])
SOURCE = Path(os.environ["HEARTBUS_SOURCE"])
SANITIZED = "ASAN_OPTIONS" in os.environ  # by the preset asan
unless_sanitized = unittest.skipIf(SANITIZED, "sanitizers change times, memory and what a library is linked to")


class Launch:
    """A finished command: exit code, output, duration, processes still alive. `during(process)` runs meanwhile."""

    def __init__(self, command, folder, during=None):
        mark = "HEARTBUS_TEST_MARK=" + uuid.uuid4().hex
        name, value = mark.split("=")
        begin = time.monotonic()
        process = subprocess.Popen([str(word) for word in command], cwd=folder, env={**os.environ, name: value},
                                   stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                   text=True)
        try:
            if during:
                during(process)
            self.output, _ = process.communicate(timeout=600)
        finally:
            process.kill()
        self.seconds = time.monotonic() - begin
        self.code = process.returncode
        self.orphans = [p for p in Path("/proc").glob("[0-9]*/environ") if has_mark(p, mark)]


class Forked:
    """A Python program of ours, finished, in a fork of this process, so that what both import is loaded once: exit code and
    output as of a Launch."""

    def __init__(self, script, words, folder):
        sys.stdout.flush()
        sys.stderr.flush()
        with tempfile.TemporaryFile("w+") as said, open(os.devnull) as nothing:
            pid = os.fork()
            if pid == 0:
                for number, file in ((0, nothing), (1, said), (2, said)):
                    os.dup2(file.fileno(), number)
                os._exit(self.perform(Path(script), [str(word) for word in words], folder))
            self.code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
            said.seek(0)
            self.output = said.read()

    @staticmethod
    def perform(script, words, folder):
        code = 1
        try:
            os.chdir(folder)
            sys.argv, sys.stdout, sys.stderr = [str(script), *words], os.fdopen(1, "w"), os.fdopen(2, "w", buffering=1)
            sys.path.insert(0, str(script.parent))
            runpy.run_path(str(script), run_name="__main__")
            code = 0
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
            if isinstance(end.code, str):
                print(end.code, file=sys.stderr)
        except BaseException:
            traceback.print_exc()
        sys.stdout.flush()
        sys.stderr.flush()
        return code


def main_side_by_side(n):
    """unittest.main of a file whose tests mostly wait: n of them at once, each in a process of its own."""
    if len(sys.argv) > 1:
        return unittest.main(verbosity=2)
    suites = unittest.defaultTestLoader.loadTestsFromModule(sys.modules["__main__"])
    names = [test.id().removeprefix("__main__.") for suite in suites for test in suite]
    with ThreadPoolExecutor(n) as pool:
        runs = list(pool.map(lambda name: subprocess.run([sys.executable, sys.argv[0], "-v", name], stdout=subprocess.PIPE,
                                                         stderr=subprocess.STDOUT, text=True, check=False), names))
    print("".join(run.stdout for run in runs))
    failed = [name for name, run in zip(names, runs) if run.returncode]
    sys.exit("failed: " + ", ".join(failed) if failed or not names else 0)


def use_library():
    """For participants in Python that are launched from here."""
    os.environ["PYTHONPATH"] = str(BIN.parent / "share/heartbus/python")


def has_mark(environ, mark):
    try:
        return mark.encode() in environ.read_bytes()
    except OSError:  # ended meanwhile
        return False


def children(launcher):
    """{rank: pid} of the ranks of a launch."""
    found = {}
    for environ in Path("/proc").glob("[0-9]*/environ"):
        try:
            words = dict(word.split(b"=", 1) for word in environ.read_bytes().split(b"\0") if b"=" in word)
        except OSError:
            continue
        if b"PMIX_RANK" in words and words.get(b"HEARTBUS_PULSE", b"").endswith(b"-%d" % launcher.pid):
            found[int(words[b"PMIX_RANK"])] = int(environ.parent.name)
    return found


def wait_for(condition, seconds=60, pause=0.05):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError("this has not come about")
        time.sleep(pause)


def launch_words(scene, folder, *coupler_arguments):
    line = subprocess.run([BIN / "coupler", scene, "--launch-line", *coupler_arguments], cwd=folder, check=True,
                          stdout=subprocess.PIPE, text=True).stdout
    return ["mpirun", "--oversubscribe", *shlex.split(line)]


def run_scene(scene, folder, *coupler_arguments, during=None):
    """Starts a scene with mpirun, as ./run does."""
    return Launch(launch_words(scene, folder, *coupler_arguments), folder, during)


def run_crowded(scene, folder, ranks, *coupler_arguments):
    """The same with more ranks a participant than this machine may have cores, which ./run refuses."""
    words = launch_words(scene, folder, *coupler_arguments, "--ranks", "1")
    for k in range(words.index(":"), len(words)):
        if words[k - 1] == "-n":
            words[k] = str(ranks)
    words[words.index("--ranks") + 1] = str(ranks)
    return Launch(words, folder)
