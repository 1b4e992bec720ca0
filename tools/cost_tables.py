"""Text tables of what steps cost; see tools/cost."""
import statistics

LAST = ["other", "bus", "waiting"]


def table(case, cost, limits=None):
    """Participants side by side; below each the parts of its work, the dearest first, each beside its limit."""
    lines = [f"\n{case}: {cost['step_ms']:.2f} ms a step, {cost['memory_MiB']:.0f} MiB"]
    if "us_per_unknown" in cost:
        lines[0] += (f", {cost['unknowns']:.0f} unknowns of fluid and solid: {cost['us_per_unknown']:.2f} us each a step, "
                     f"{cost['fsi_us_per_unknown']:.2f} without electrophysiology")
    for name, part in cost["parts"].items():
        lines.append(f"  {name:18} {part['busy_ms']:9.3f} ms busy {part['cpu_ms']:9.3f} ms cpu {part['memory_MiB']:7.0f} MiB")
        work = part["ms"]
        order = sorted(set(work) - set(LAST), key=work.get, reverse=True) + [last for last in LAST if last in work]
        for piece in order:
            lines.append(f"    {piece:17} {work[piece]:8.3f} ms")
            if limit := (limits or {}).get(name, {}).get(piece):
                lines[-1] += f", limit {limit:7.3f} ms, {work[piece] / limit:6.1f} times"
    lines.append("  iterations: " + ", ".join(f"{name.removesuffix('_iterations')} {value:.1f}"
                                              for name, value in cost["iterations"].items()))
    return "\n".join(lines)


def ratios(cases):
    """Of each case to the first one, turn by turn, so that what else the machine did divides out."""
    first = cases[0].runs
    width = max(len(case.name()) for case in cases)
    lines = [f"\n{'':{width}}  ms a step  ratio (range)          cpu ms  ratio (range)"]
    for case in cases:
        line = f"{case.name():{width}}"
        for key in ("step_ms", "cpu_ms"):
            values = [run[key] for run in case.runs]
            ratio = [run[key] / before[key] for run, before in zip(case.runs, first)]
            line += f"  {statistics.median(values):9.3f}  {statistics.median(ratio):.3f} ({min(ratio):.3f} to {max(ratio):.3f})"
        lines.append(line)
    return "\n".join(lines)
