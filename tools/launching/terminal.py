"""What the run says on a terminal: its last line tells where it is, and is renewed in place; all else stands above it."""
import shutil
import sys
import threading

BAR = 20  # characters


def fitted(share, parts, width):
    """A bar and as many of the parts as there is room for."""
    done = round(BAR * share)
    line = f"[{'=' * done}{' ' * (BAR - done)}] {100 * share:3.0f} %"
    for part in parts:
        if part and len(line) + 2 + len(part) < width:
            line += f"  {part}"
    return line[:max(width - 1, 0)]


class Terminal:
    """Only what has a terminal is renewed; elsewhere lines are passed on as they come."""

    def __init__(self, stream=sys.stdout):
        self.stream, self.live, self.lock = stream, "", threading.Lock()

    @property
    def is_live(self):
        return self.stream.isatty()

    def feed(self, line):
        """One of the run's lines: one that begins with a tab is where it is (coupler/step_log.h)."""
        if not line.startswith("\t"):
            self.put(line)
            return
        share, *parts = line[1:].rstrip("\n").split("\t")
        with self.lock:
            self.live = fitted(float(share), parts, shutil.get_terminal_size().columns)
            self.write(self.stream, "\r\033[K" + self.live)

    def put(self, text, stream=None):
        with self.lock:
            hidden, shown_again = ("\r\033[K", self.live) if self.live else ("", "")
            if hidden:
                self.write(self.stream, hidden)
            self.write(stream or self.stream, text)
            if shown_again:
                self.write(self.stream, shown_again)

    def end(self):
        """The last line stays as it is."""
        with self.lock:
            if self.live:
                self.write(self.stream, "\n")
            self.live = ""

    def read(self, stream):
        for line in stream:
            self.feed(line)
        self.end()

    @staticmethod
    def write(stream, text):
        try:
            stream.write(text)
            stream.flush()
        except OSError:  # the terminal has gone
            pass


TERMINAL = Terminal()


def show(text):
    """On standard error, above the line that is renewed."""
    TERMINAL.put(text, sys.stderr)
