"""Computes cases side by side, what they need before them; tells how it goes; keeps what is finished, whatever happens."""
import shutil
import signal
import sys
import time

from .launch import LASTING, Launch
from .scene import StudyError

DISK_MIN = 200e6  # bytes that must be free to begin a run


def shortened(text, length=110):
    """The table has all of it."""
    return text if len(text) <= length else text[:length - 3] + "..."


class Schedule:
    def __init__(self, store, jobs):
        self.store, self.jobs = store, jobs
        self.waiting = []  # (case, name), in order
        self.running = {}  # fingerprint -> (name, Launch)
        self.then = {}  # fingerprint -> functions to call with its state
        self.obstacle = ""  # why nothing more is begun
        self.begun, self.steps, self.n_done, self.shown = time.monotonic(), 0, 0, 0.0

    def add(self, case, name, then=None):
        """Queues a case with all that it needs; `then(state)` when it is done, failed or cannot be."""
        key = case.fingerprint
        if self.store.state(case) != "missing":
            if then:
                then(self.store.state(case))
            return
        if then:
            self.then.setdefault(key, []).append(then)
        if key in self.running or any(other.fingerprint == key for other, _ in self.waiting):
            return
        for needed in case.needs:
            self.add(needed, f"{'calcium' if needed.records else 'start'} of {name}")
        self.waiting.append((case, name))

    def work(self):
        """Until all is done or there is an obstacle."""
        old = {number: signal.signal(number, self.interrupt) for number in (signal.SIGINT, signal.SIGTERM)}
        try:
            while self.running or (self.waiting and not self.obstacle):
                self.begin_some()
                self.look()
                self.show()
                time.sleep(0.05)
        finally:
            for _, launch in self.running.values():
                launch.stop()
            for number, handler in old.items():
                signal.signal(number, handler)
        return not self.obstacle

    def interrupt(self, number, _):
        self.obstacle = f"interrupted by {signal.Signals(number).name}"
        for _, launch in self.running.values():
            launch.stop()
        self.running.clear()

    def begin_some(self):
        for case, name in list(self.waiting):
            if len(self.running) >= self.jobs or self.obstacle:
                return
            states = [self.store.state(needed) for needed in case.needs]
            if "failed" in states:
                self.waiting.remove((case, name))
                self.finish(case, name, "failed", "what it starts from or replays has failed")
            elif all(state == "done" for state in states):
                self.waiting.remove((case, name))
                self.begin(case, name)

    def begin(self, case, name):
        try:
            free = shutil.disk_usage(self.store.folder.parent).free
            if free < DISK_MIN:
                raise OSError(28, f"the disk is full: {free / 1e6:.0f} MB are left")
            self.running[case.fingerprint] = (name, Launch(case, self.store))
        except StudyError as error:
            self.finish(case, name, "failed", str(error))
        except OSError as error:
            self.obstacle = error.strerror or str(error)

    def look(self):
        for key, (name, launch) in list(self.running.items()):
            outcome = launch.outcome()
            if outcome is None:
                continue
            code, reason = outcome
            self.running.pop(key, None)
            self.steps += launch.steps_done()
            if code == 0:
                self.finish(launch.case, name, "done", "", start=launch.start)
            elif code in LASTING:
                self.finish(launch.case, name, "failed", f"exit code {code}: {reason}")
            else:  # killed, disk full: no property of the run
                print(f"{name}: not finished, exit code {code}: {reason}", flush=True)
                self.drop(launch.case)

    def finish(self, case, name, state, reason, **more):
        try:
            if self.store.of(case).exists() or state == "failed":
                self.store.of(case).mkdir(parents=True, exist_ok=True)
                self.store.end(case, state, name=name, reason=reason, **more)
        except OSError as error:
            self.obstacle = error.strerror or str(error)
        self.n_done += 1
        self.say(f"[{self.n_done}/{self.n_done + len(self.running) + len(self.waiting)}] {name}: {state}"
                 f"{': ' + shortened(reason) if reason else ''}{self.time_left()}")
        for then in self.then.pop(case.fingerprint, []):
            then(state)

    def drop(self, case):
        """Whatever waits for it cannot be computed now."""
        for other, name in list(self.waiting):
            if any(needed.fingerprint == case.fingerprint for needed in other.needs):
                self.waiting.remove((other, name))
                self.drop(other)
        for then in self.then.pop(case.fingerprint, []):
            then("missing")

    def time_left(self):
        running = [(launch.case.n_steps, launch.steps_done()) for _, launch in self.running.values()]
        done = self.steps + sum(steps for _, steps in running)
        left = sum(max(0, all_steps - steps) for all_steps, steps in running)
        left += sum(case.n_steps for case, _ in self.waiting)
        if not (done and left):
            return ""
        seconds = round((time.monotonic() - self.begun) / done * left)
        return f"  left {seconds // 3600}:{seconds // 60 % 60:02}:{seconds % 60:02}"

    def say(self, text):
        print(("\r\033[K" if sys.stdout.isatty() else "") + text, flush=True)

    def show(self):
        """What runs, on a terminal, twice a second."""
        if not sys.stdout.isatty() or time.monotonic() - self.shown < 0.5:
            return
        self.shown = time.monotonic()
        now = ", ".join(f"{name} {100 * launch.steps_done() / launch.case.n_steps:.0f} %"
                        for name, launch in self.running.values())
        print(f"\r\033[K{now}; {len(self.waiting)} wait{self.time_left()}"[:150], end="", flush=True)
