"""What mpirun itself writes between lines of dashes: the causes are taken from it, the rest is passed on."""
import re

from .terminal import show

LINE = re.compile(r"-{50,}\s*$")
KILLED = re.compile(r"process rank (\d+) with PID \d+ on node (\S+) exited on\s+signal (\d+)")
EXITED = re.compile(r"Process name: \[\[\d+,\d+\],(\d+)\]\s+Exit code:\s+(\d+)")
IMPROPER = re.compile(r"process rank (\d+) with PID \d+ on\s+node (\S+) exiting\s+improperly")
LOST = re.compile(r"Remote daemon:\s+\[\[\d+,\d+\],\d+\] on node (\S+)")
HUNG_UP = re.compile(r"peer process has unexpectedly disconnected.*Peer host:\s+(\S+)", re.S)
NO_DAEMON = re.compile(r"unable to reliably start one or more daemons")
AGGREGATED = re.compile(r"\[\S+:\d+\] (\d+ more process|Set MCA parameter)")
NOISE = re.compile(r"Primary job|MPI_ABORT was invoked|has lost communication|Terminated|forcibly terminate|mpirun: "
                   r"killing|ORTE does not know how to route")


class Messages:
    """Reads the error output of a launch."""

    def __init__(self):
        self.killed = None        # (rank, node, signal)
        self.exited = None        # (rank, code)
        self.lost = None          # node
        self.no_daemon = ""       # what mpirun says when it cannot start its part on a node, or that has ended
        self.has_cause = False    # a program has said why
        self._block = None

    def read(self, stream):
        for line in stream:
            self.feed(line)
        if self._block:
            show("".join(self._block))

    def feed(self, line):
        if LINE.match(line):
            if self._block is not None:
                self._judge("".join(self._block))
            self._block = [] if self._block is None else None
        elif self._block is not None:
            self._block.append(line)
        elif not AGGREGATED.match(line):
            self.has_cause |= line.startswith("heartbus: ")
            show(line)

    def _judge(self, text):
        if found := KILLED.search(text):
            self.killed = self.killed or (int(found[1]), found[2], int(found[3]))
        elif found := EXITED.search(text):
            self.exited = self.exited or (int(found[1]), int(found[2]))
        elif found := IMPROPER.search(text):
            self.exited = self.exited or (int(found[1]), 0)
        elif found := LOST.search(text):
            self.lost = self.lost or found[1]
        elif found := HUNG_UP.search(text):
            self.lost = self.lost or found[1]
        elif NO_DAEMON.search(text):
            self.no_daemon = text
        elif not NOISE.search(text):
            show(f"mpirun: {text}" if text.strip() else "")
