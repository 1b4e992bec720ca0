"""Tables of runs as rows of text: for the terminal and for the page."""
import re

import yaml

from results import SHOWN, flat, provenance


def whole(beat):
    """Heading of a beat's column; a wall that is only loaded has no beats."""
    if "beat" not in beat:
        return "run"
    return f"beat {beat['beat']}" + ("" if beat.get("complete", True) else " (incomplete)")


def indicators(runs):
    """Heading and rows (label, unit, value...): a column for each beat of a run, or for each of several runs its last
    complete beat."""
    if len(runs) == 1:
        beats = [beat for beat, _ in runs[0].beats()]
        heading = [whole(beat) for beat in beats]
    else:
        beats, heading = [run.indicators for run in runs], [run.name for run in runs]
    rows = [[label, unit, *(f"{beat[key]:.{digits}f}" if isinstance(beat.get(key), (int, float)) else "" for beat in beats)]
            for key, label, digits, unit in SHOWN if any(key in beat for beat in beats)]
    changes = {name for beat in beats for name in beat.get("change_percent", {})}
    rows += [[f"{name} changed since the beat before", "%",
              *(f"{beat['change_percent'][name]:.2f}" if name in beat.get("change_percent", {}) else "" for beat in beats)]
             for name in ("EDV", "ESV", "p_max") if name in changes]
    return ["", "unit", *heading], rows


def for_terminal(heading, rows):
    """Aligned columns."""
    table = [heading, *rows]
    widths = [max(len(row[c]) for row in table) for c in range(len(heading))]
    return "\n".join("  ".join(word.ljust(width) if c < 2 else word.rjust(width)
                               for c, (word, width) in enumerate(zip(row, widths))).rstrip() for row in table)


def cost(run):
    """Heading and rows of each participant."""
    about = run.indicators
    ranks = {key.split(".")[1]: str(value) for key, value in run.scene.items()
             if key.startswith("participants.") and key.endswith(".ranks")}
    steps = about.get("steps_timed") or 1
    rows = [[name, ranks.get(name, ""), f"{seconds:.1f}", f"{1e3 * seconds / steps:.2f}",
             f"{about.get('wall_s_by_work', {}).get(name, {}).get('waiting', 0):.1f}",
             f"{about.get('cpu_s_by_part', {}).get(name, 0):.1f}", f"{about.get('start_cpu_s_by_part', {}).get(name, 0):.1f}",
             f"{about.get('peak_memory_MiB_by_part', {}).get(name, 0):.0f}"]
            for name, seconds in about.get("wall_s_by_part", {}).items()]
    if rows:
        rows.append(["all", "", f"{about.get('wall_s', 0):.1f}", f"{1e3 * about.get('wall_s', 0) / steps:.2f}", "",
                     f"{about.get('cpu_s', 0):.1f}", "", f"{about.get('peak_memory_MiB', 0):.0f}"])
    return ["participant", "ranks", "wall time, s", "ms a step", "waiting, s", "CPU, s", "CPU of the start, s",
            "memory, MiB"], rows


def as_written(value):
    """A value as a scene has it, without what binary numbers leave behind the twelfth digit."""
    text = yaml.safe_dump(value, default_flow_style=True, width=10000, sort_keys=False).removesuffix("\n...\n").strip("\n'")
    return re.sub(r"\d+\.\d{12,}(e-?\d+)?", lambda number: f"{float(number[0]):.12g}", text)


def default_of(key, usual):
    """A region of the wall has the keys of the wall."""
    return usual.get(key, usual.get(re.sub(r"\.regions\.[^.]+", "", key), ""))


def scene_differences(runs, defaults):
    """Heading and rows of the keys in which a run differs from the defaults, or the runs from each other."""
    usual = flat(defaults)
    rows = []
    for key in dict.fromkeys(key for run in runs for key in run.scene):
        values = [run.scene.get(key, "") for run in runs]
        differ = any(value != values[0] for value in values) if len(runs) > 1 else values[0] != default_of(key, usual)
        if differ:
            rows.append([key, *map(as_written, values), as_written(default_of(key, usual))])
    return ["key", *(run.name for run in runs), "default"], rows


def origin(runs):
    """Heading and rows of versions and machine, a column for each run."""
    abouts = [provenance(run.folder) for run in runs]
    keys = [key for key in dict.fromkeys(key for about in abouts for key in about) if key != "command"]
    return (["", *(run.name if len(runs) > 1 else "" for run in runs)],
            [[key.replace("_", " "), *(str(about.get(key, "")) for about in abouts)] for key in keys])
