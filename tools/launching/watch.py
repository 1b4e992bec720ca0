"""Starts mpirun and watches it from outside: passes signals on, misses who is silent, and says why a run has ended."""
import ctypes
import glob
import os
import signal
import socket
import subprocess
import threading
import time
from pathlib import Path

from .leftovers import is_alive
from .messages import Messages, show
from .processes import Ranks
from .terminal import TERMINAL

PAUSE = 0.25       # [s] between looks
TIME_TO_JOIN = 10  # [s] at most for a program to be there, of those that mpirun has started on this machine
TIME_TO_END = 10   # [s] for mpirun to end, once it has been told to
PR_SET_PDEATHSIG = 1
DEADLINE, FILE = 7, 8


def with_launcher_only():
    """Runs in mpirun before it is that. It ends with the launcher, however that ends; SIGTERM and SIGHUP to it wait where
    the launcher finds them, because mpirun would kill all ranks at once."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGINT)
    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGTERM, signal.SIGHUP])


class Pulse:
    """The file in which the coupler tells where it is: see common/bus/pulse.h."""

    def __init__(self, folder):
        self.file = Path(folder).resolve() / f".run-{socket.gethostname()}-{os.getpid()}"
        self.text, self.since = "", time.monotonic()  # when it last changed
        self.stage, self.step = "starting", 0
        self.file.parent.mkdir(parents=True, exist_ok=True)
        for file in self.file.parent.glob(f".run-{glob.escape(socket.gethostname())}-*"):
            if not is_alive(int(file.name.rsplit("-", 1)[1])):
                file.unlink(missing_ok=True)
        self.file.write_text("")

    def look(self):
        try:
            text = self.file.read_text()
        except OSError:
            return
        words = text.split()
        if text != self.text and len(words) == 3:
            self.text, self.since = text, time.monotonic()
            self.stage, self.step = words[1], int(words[2])

    def silence(self):
        return time.monotonic() - self.since

    def remove(self):
        self.file.unlink(missing_ok=True)


class Watch:
    def __init__(self, plan, command, environment):
        self.plan, self.command, self.environment = plan, command, environment
        self.pulse = Pulse(plan.folder)
        self.messages = Messages()
        self.cause = None          # (exit code, line): why the launcher itself ends the run
        self.n_requests = 0        # to stop
        self.at_once = False       # a request ended the run before it could save
        self.seen_pending = False  # a signal that waits at mpirun
        self.stopped = []          # when last somebody was

    def run(self):
        """The exit code of the run; whatever has happened has been said."""
        previous = {number: signal.signal(number, self.request)
                    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
                    if signal.getsignal(number) != signal.SIG_IGN}
        try:
            return self._run()
        finally:
            self.pulse.remove()
            for number, handler in previous.items():
                signal.signal(number, handler)

    def _run(self):
        live = {"HEARTBUS_LIVE": "1"} if TERMINAL.is_live else {}
        self.process = subprocess.Popen(self.command, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                                        errors="replace", start_new_session=True, preexec_fn=with_launcher_only,
                                        stdout=subprocess.PIPE if live else None,
                                        env={**self.environment, **live, "HEARTBUS_PULSE": str(self.pulse.file)})
        if self.n_requests:  # came meanwhile
            self.at_once = True
            self.end()
        self.begin = time.monotonic()
        self.ranks = Ranks(self.process.pid)
        readers = [threading.Thread(target=self.messages.read, args=[self.process.stderr], daemon=True)]
        if live:
            readers.append(threading.Thread(target=TERMINAL.read, args=[self.process.stdout], daemon=True))
        for reader in readers:
            reader.start()
        while self.process.poll() is None:
            self.look()
            try:
                self.process.wait(PAUSE)
            except subprocess.TimeoutExpired:
                pass
        for reader in readers:
            reader.join(TIME_TO_END)
        return self.explain(self.process.returncode)

    def request(self, number=0, _frame=None):
        """Somebody wants the run to stop: the first time with its results, the second time at once."""
        self.n_requests += 1
        self.number = number
        if not hasattr(self, "process"):
            return
        self.pulse.look()
        if self.n_requests > 1 or self.pulse.stage == "starting":
            if self.n_requests == 1:
                show("Stopped before the first step\n")
            self.at_once = True
            self.end()
        elif self.pulse.stage != "ending":
            show("Stopping within 20 steps, with a checkpoint; once more: at once\n")
            self.process.send_signal(signal.SIGUSR1)

    def end(self):
        """At once: mpirun ends all ranks; if it does not, it is ended as well, and its ranks find that it has gone."""
        def insist():
            if self.process.poll() is None:
                self.process.kill()
                for pid in self.ranks.pids.values():
                    try:
                        os.kill(pid, signal.SIGKILL)
                    except ProcessLookupError:
                        pass
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            timer = threading.Timer(TIME_TO_END, insist)
            timer.daemon = True
            timer.start()

    def end_because(self, code, line):
        self.cause = (code, line)
        self.look_at_stopped()
        self.end()

    def look(self):
        self.pulse.look()
        self.ranks.look()
        self.look_at_stopped()
        if not self.seen_pending and self.has_pending():
            self.seen_pending = True
            self.request()
        if self.cause or self.n_requests > 1:
            return
        self.look_for_missing()
        self.look_for_silence()

    def look_at_stopped(self):
        found = self.ranks.stopped()
        if found:
            self.stopped = found

    def has_pending(self):
        """SIGTERM or SIGHUP to mpirun itself."""
        wanted = sum(1 << number - 1 for number in (signal.SIGTERM, signal.SIGHUP))
        try:
            lines = Path(f"/proc/{self.process.pid}/status").read_text().splitlines()
        except OSError:
            return False
        return any(int(line.split()[1], 16) & wanted for line in lines if line.startswith(("ShdPnd:", "SigPnd:")))

    def look_for_missing(self):
        """Programs that end without a word to the others, who would wait for them for ever."""
        patience = min(TIME_TO_JOIN, self.plan.deadline)
        if self.pulse.stage != "starting" or time.monotonic() - self.begin < patience:
            return
        missing = self.ranks.missing(self.plan.n_ranks)
        if missing and not self.spans_nodes():
            program = self.plan.member(missing[0])[0]
            names = ", ".join(self.plan.who(rank) for rank in missing[:5]) + (", ..." if len(missing) > 5 else "")
            self.end_because(3, f"{names} ended without joining the others: is {program.shown} a participant?")

    def spans_nodes(self):
        return "--host" in self.command

    def other_nodes(self):
        """Those but this one."""
        lists = [self.command[k + 1] for k, word in enumerate(self.command) if word == "--host"]
        names = {entry.split(":")[0] for entry in ",".join(lists).split(",") if entry}
        return sorted(names - {socket.gethostname()})

    def look_for_silence(self):
        """Those who have met look after each other; the coupler, who leads them, is looked after here, and all before they
        have met and after they have parted."""
        if self.pulse.silence() < self.plan.deadline + 2:
            return
        waited = f"waited {self.plan.deadline:g} s (the deadline) for "
        if self.pulse.stage == "starting":
            awaited = "all programs to meet"
        elif self.pulse.stage == "ending":
            awaited = "all programs to end"
        else:
            awaited = f"a sign of life of the coupler, step {self.pulse.step}"
        self.end_because(DEADLINE, waited + awaited)

    def explain(self, code):
        """One line, unless a program has told the cause, and who was stopped then."""
        messages, step = self.messages, f"step {self.pulse.step}" if self.pulse.step else f"it was {self.pulse.stage}"
        if self.cause:
            code, line = self.cause
            show(f"heartbus: {line}\n")
        elif self.at_once or (self.n_requests and self.pulse.stage == "starting"):
            code = 128 + (self.number or signal.SIGTERM)
        elif code and not messages.has_cause:
            show(f"heartbus: {self.silent_end(code)}; {step}\n")
        if code == DEADLINE:
            for rank, pid, since in self.stopped:
                when = time.strftime("%H:%M:%S", time.localtime(since))
                show(f"heartbus: {self.plan.who(rank)}, process {pid}, has been stopped since {when} by a signal or a "
                     "debugger\n")
        return code if code >= 0 else 128 - code

    def silent_end(self, code):
        messages = self.messages
        if messages.killed:
            rank, node, number = messages.killed
            try:
                name = signal.Signals(number).name
            except ValueError:
                name = "unknown"
            line = f"{self.plan.who(rank)} on {node}, process {self.ranks.pids.get(rank, '?')}, was ended by signal {number} ({name})"
            if number == signal.SIGKILL:
                line += f"; {self.ranks.use_of_memory()}"
            return line
        if messages.lost:
            return f"node {messages.lost} does not answer any more"
        if messages.no_daemon:
            if self.pulse.stage == "starting":
                show(messages.no_daemon)
            return f"a node cannot be reached, or mpirun's daemon there has ended: {', '.join(self.other_nodes())}"
        if messages.exited:
            rank, code = messages.exited
            return f"{self.plan.who(rank)} ended with exit code {code} and without a word"
        return f"mpirun ended with exit code {code}"
