"""What a trace of a run says (output.trace: true): who works when, and when nobody does.

Nobody works while no rank of any participant solves, prepares, commits or performs a task: they pack, send, receive, report
or wait. Such a gap is a handover within a step, or it belongs to the turn to the next one. After every 20th step all drop what
is not in their states and a checkpoint may be written; before that the next step is not ordered, and these turns are told
apart. Means by step, without the first one, which makes what is kept.
"""
import functools
import json
from dataclasses import dataclass

COMMANDS = ("prepare", "solve", "commit", "task")  # of the solver; its own sections lie within them
REFRESH = 20  # steps: TimeControl::refresh_interval


@dataclass
class Slice:
    who: str    # participant
    rank: int
    what: str
    step: int
    begin: float  # [us]
    end: float


@functools.lru_cache(maxsize=2)
def slices(file):
    """Of all participants; ValueError, KeyError when it is no trace."""
    with open(file) as opened:
        events = json.load(opened)["traceEvents"]
    names = {event["pid"]: event["args"]["name"] for event in events if event["ph"] == "M" and event["name"] == "process_name"}
    return [Slice(names[event["pid"]], event["tid"], event["name"], event["args"]["step"], event["ts"], event["ts"] + event["dur"])
            for event in events if event["ph"] == "X" and not names[event["pid"]].startswith("coupler")]


def usual_step(commands):
    """The first of two steps that take as long together as half of all such pairs at most; None of fewer than two."""
    begin, end = {}, {}
    for each in commands:
        begin[each.step] = min(begin.get(each.step, each.begin), each.begin)
        end[each.step] = max(end.get(each.step, each.end), each.end)
    pairs = sorted((end[step + 1] - begin[step], step) for step in begin if step > 0 and step + 1 in begin)
    return pairs[len(pairs) // 2][1] if pairs else None


def is_work(each):
    return each.what.split(":")[0] in COMMANDS


def spans_of_work(found):
    """Merged [begin, end, step of the first, step of the last] in microseconds of all participants' work."""
    spans = []
    for each in sorted((each for each in found if is_work(each) and each.step > 1), key=lambda each: (each.begin, each.end)):
        if spans and each.begin <= spans[-1][1]:
            if each.end > spans[-1][1]:
                spans[-1][1], spans[-1][3] = each.end, each.step
        else:
            spans.append([each.begin, each.end, each.step, each.step])
    return spans


def gaps(found):
    """(number of steps, microseconds a step, {kind of gap: microseconds a step}); ValueError of fewer than three steps."""
    spans = spans_of_work(found)
    if not spans or spans[0][2] == spans[-1][3]:
        raise ValueError("the trace holds fewer than three steps")
    n_steps = spans[-1][3] - spans[0][2] + 1
    sums = {"handovers within a step": 0.0, "turns of steps": 0.0, f"turns after each {REFRESH}th": 0.0}
    for (_, end, _, before), (begin, _, after, _) in zip(spans, spans[1:]):
        kind = 0 if before == after else 2 if before % REFRESH == 0 else 1
        sums[list(sums)[kind]] += (begin - end) / n_steps
    return n_steps, (spans[-1][1] - spans[0][0]) / n_steps, {**sums, "all": sum(sums.values())}


def rows_of_gaps(found):
    """Heading and rows of a table."""
    n_steps, per_step, sums = gaps(found)
    rows = [[kind, f"{microseconds:.1f}", f"{100 * microseconds / per_step:.2f}"] for kind, microseconds in sums.items()]
    return [f"nobody works ({n_steps} steps of {1e-3 * per_step:.2f} ms)", "µs a step", "%"], rows
