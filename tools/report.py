#!/usr/bin/python3
"""The report of a run, or of several to compare them: report.html, one file with all in it, and its charts as PNG, PDF and SVG.

    tools/report.py results/ideal_lv_efs1                              # in results/ideal_lv_efs1/report/
    tools/report.py results/efs1 results/e1fs2 --out comparison
    tools/report.py results/ideal_lv_efs1 --charts                     # quickly: charts in the page only
"""
import argparse
import subprocess
import sys
from pathlib import Path

import yaml

from launching.programs import command, programs
from results import LOADER, load, origin

try:
    from reporting import charts, style
    from reporting.page import page
except ImportError as error:
    sys.exit(f"a report needs matplotlib and Pillow for Python, and one is missing ({error}); in Debian: python3-matplotlib, "
             "python3-pil")

PICTURES = Path(__file__).parent / "pictures.py"


def draw(runs, folder, formats):
    """The charts that these runs allow: {title: SVG}."""
    drawn = {}
    for name, title, chart in charts.ALL:
        figure = chart(runs)
        if figure:
            drawn[title] = style.save(figure, folder / name, formats, origin([run.folder for run in runs]))
            style.plt.close(figure)
    return drawn


def make(runs, out, quick):
    """The page in this folder; `quick`: its charts as SVG only, without pictures. What is missing then, as a sentence."""
    out.mkdir(parents=True, exist_ok=True)
    drawn = draw(runs, out, ("svg",) if quick else style.FORMATS)
    missing = f"Pictures, films, charts as PNG and PDF: {command()} report, without --charts." if quick else render(runs)
    (out / "report.html").write_text(page(runs, drawn, defaults(), missing))
    return missing


def render(runs):
    """Pictures and films of the fields, by a program of its own, which needs VTK and a display; what is missing, as a
    sentence."""
    for run in runs:
        if not any((run.folder / "fields").glob("*.h5")):
            continue
        if run.indicators and is_newer(run.folder / "report/films.json", run.folder / "indicators.json"):
            continue
        words = [sys.executable, PICTURES, run.folder, "--films"]
        result = subprocess.run(words, check=False, stderr=subprocess.PIPE, text=True)
        if result.returncode != 0:
            return "No pictures: " + (result.stderr.strip().splitlines() or ["tools/pictures.py failed"])[-1]
    return ""


def is_newer(file, other):
    return file.exists() and file.stat().st_mtime > other.stat().st_mtime


def defaults():
    """Of all keys of a scene, as the programs print them; nothing when they are not there."""
    coupler = programs() / "coupler"
    if not coupler.exists():
        return {}
    printed = subprocess.run([coupler, "--print-defaults"], stdout=subprocess.PIPE, text=True, check=False).stdout
    return yaml.load(printed, LOADER) or {}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", metavar="RUN", help="results folder of a run")
    parser.add_argument("--charts", action="store_true", help="as SVG only, without pictures and films of the fields, which take a minute")
    parser.add_argument("--out", type=Path, help="default: RUN/report; of several runs: comparison")
    options = parser.parse_args()
    try:
        runs = load(options.folders)
    except OSError as error:
        sys.exit(f"error: {error.filename}: {error.strerror}: is this the folder of a finished run?")
    out = options.out or (runs[0].folder / "report" if len(runs) == 1 else Path("comparison"))
    missing = make(runs, out, options.charts)
    print(out / "report.html")
    if missing and not options.charts:
        print(missing, file=sys.stderr)


if __name__ == "__main__":
    main()
