#!/usr/bin/python3
"""Runs a scene, and sees to it that it ends. `./run` calls this when all is built.

    tools/launch.py [SCENE] [options of the coupler] [--hosts FILE] [--oversubscribe] [--placement shared|spread]
                    [--print mpirun|slurm]
"""
import argparse
import contextlib
import os
import re
import subprocess
import sys
import threading
from pathlib import Path

from launching import leftovers, mpirun, nodes as hosts, script
from launching.plan import ask_coupler, quoted
from launching.programs import ROOT, command, programs
from launching.watch import FILE, Watch

SCENE = 2   # exit code
LOADED = 2  # [s] after which all programs have been loaded
TYPED = "HEARTBUS_TYPED"  # the command by which this one is called, when it is not typed itself
HELP = """Usage: {0} [SCENE] [options]

Runs a scene: without one, a heartbeat of the idealised left ventricle.

    {0}
    {0} my.yaml --set mesh=M1 --set alpha=auto    # results in results/NAME-alpha=auto-mesh=M1
    {0} my.yaml --restart latest                  # on from the last checkpoint

Options of the run:
{1}

Options of the launch:
{2}"""


def typed():
    """What a user has typed to come here."""
    return os.environ.get(TYPED) or ("heartbus-run" if Path(sys.argv[0]).name == "heartbus-run" else sys.argv[0])


def told(parser):
    """The help: options of the coupler, but for those that are for launchers, then of the launch."""
    coupler = subprocess.run([programs() / "coupler", "--help"], check=False, stdout=subprocess.PIPE, text=True).stdout
    of_the_run = [each for each in re.findall(r"^  -.*(?:\n   .*)*", coupler, re.M)
                  if not each.startswith(("  -h", "  --launch-line"))]
    return HELP.format(typed(), "\n".join(of_the_run), parser.format_help().split("options:\n", 1)[1])


def parse(words):
    """(options of the launch, all others: they are the coupler's)."""
    parser = argparse.ArgumentParser(prog=typed(), add_help=False, allow_abbrev=False)
    parser.add_argument("--hosts", metavar="FILE", help="nodes to run on, a line each: 'node7 slots=16'")
    parser.add_argument("--force", action="store_true", help="replaces the results that are there")
    parser.add_argument("--oversubscribe", action="store_true", help="more ranks than cores are meant")
    parser.add_argument("--placement", choices=["shared", "spread"], default="shared",
                        help="on several nodes: each participant on all of them, or on nodes of its own")
    parser.add_argument("--print", dest="printed", choices=["mpirun", "slurm"],
                        help="prints the launch line, or a job script, and does not run")
    parser.add_argument("--nodes", type=int, help="of the job script; default: as many as the ranks need")
    parser.add_argument("--cores", type=int, help="of each node of the job script; default: of this machine")
    parser.add_argument("-h", "--help", action="store_true", help=argparse.SUPPRESS)
    options, others = parser.parse_known_args(words)
    if options.help:
        print(told(parser), end="")
        sys.exit(0)
    return options, others


def environment(plan, nodes, folders):
    return {**mpirun.variables(plan, nodes), **(folders.variables() if folders else {}), **os.environ}


def use_library():
    """Participants in Python find heartbus of the programs that run, after what is on their path anyway."""
    path = filter(None, (os.environ.get("PYTHONPATH"), str(programs().parent / "share/heartbus/python")))
    os.environ["PYTHONPATH"] = ":".join(path)


def launch(plan, nodes, placed):
    """On this machine alone the launch has folders of its own for what Open MPI leaves."""
    cleared = leftovers.clear_dead()
    if cleared:
        print(f"Cleared {cleared / 2**20:.1f} MiB that a run which died has left")
    folders = None if nodes else leftovers.Folders()
    use_library()
    try:
        words = mpirun.arguments(plan, nodes, placed)
        print("mpirun", quoted(words), flush=True)
        load_later = threading.Timer(LOADED, load_reports)
        load_later.daemon = True
        load_later.start()
        code = Watch(plan, ["mpirun", *words], environment(plan, nodes, folders)).run()
        load_later.cancel()
        load_later.join()
        return code
    except OSError as error:
        print(f"error: {error.filename or plan.folder}: {error.strerror}", file=sys.stderr)
        return FILE
    finally:
        if folders:
            folders.remove()


def load_reports():
    """While participants wait for each other a core is idle: what draws the report takes most of a second to load."""
    with contextlib.suppress(ImportError, SystemExit):  # told when the report is made
        import report  # noqa: F401


def is_finished(folder):
    return (Path(folder) / "indicators.json").exists()


def goes_on(words):
    return any(word == "--restart" or word.startswith("--restart=") for word in words)


def leave_state(folder):
    """Of ParaView, which opens all fields."""
    if any((Path(folder) / "fields").glob("*.xdmf")):
        text = (ROOT / "tools/reporting/paraview_state.py").read_text()
        (Path(folder) / "paraview_state.py").write_text(text.replace('else "."', f"else {str(Path(folder).resolve())!r}"))


def tell(folder):
    """The indicators, what is implausible, where the report is."""
    from reporting import plausibility, tables
    from results import Run
    run = Run(folder)
    print("\n" + tables.for_terminal(*tables.indicators([run])))
    found = plausibility.findings(run)
    print("\nImplausible:" * bool(found) + "".join(f"\n- {finding}" for finding in found) + "\n" * bool(found))
    try:
        import report
        report.make([run], run.folder / "report", quick=True)
    except (Exception, SystemExit) as error:  # the run's results are there all the same
        print(f"Results in {folder}", flush=True)
        print(f"No report: {error}; {command()} report {quoted([folder])} makes it anew", file=sys.stderr)
        return
    print(f"Results in {folder}, report in {folder}/report/report.html\n"
          f"{command()} report {quoted([folder])} adds pictures and films of the fields")


def run(words):
    """(exit code, plan if something has been run)."""
    options, others = parse(words)
    plan = ask_coupler(programs() / "coupler", others, ROOT / "configs/ideal_lv/efs1.yaml")
    if isinstance(plan, int):
        return plan, None
    if options.printed == "slurm":
        print(script.slurm(plan, options.placement, options.nodes, options.cores or hosts.own_cores()), end="")
        return 0, None
    try:
        nodes = hosts.find_nodes(options.hosts)
        hosts.check_room(plan, nodes, options.oversubscribe)
    except hosts.Refusal as refusal:
        print(f"error: {refusal}", file=sys.stderr)
        return SCENE, None
    placed = hosts.place(plan, nodes, options.placement) if nodes else None
    if options.printed == "mpirun":
        print(script.line(plan, nodes, placed))
        return 0, None
    if is_finished(plan.folder) and not (options.force or goes_on(others)):
        goes_on_from = ", --restart goes on from them" if any(Path(plan.folder, "checkpoints").glob("[0-9]*")) else ""
        print(f"error: {plan.folder}: holds the results of a run; --force replaces them, --out FOLDER puts these elsewhere"
              f"{goes_on_from}", file=sys.stderr)
        return FILE, None
    return launch(plan, nodes, placed), plan


def main():
    code, plan = run(sys.argv[1:])
    if plan:
        leave_state(plan.folder)
    if code == 0 and plan:
        tell(plan.folder)
    return code


if __name__ == "__main__":
    sys.exit(main())
