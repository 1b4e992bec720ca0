"""The whole matrix: see the script `run` beside this."""
import argparse
import csv
import importlib.util
import itertools
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

import matrix

LEAST_RISE = 100  # Pa: the wall has begun to contract


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="docs/results/swap_matrix.csv")
    parser.add_argument("--only", default="", help="of combinations that contain this, e.g. eikonal")
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    chosen = [parts for parts in itertools.product(matrix.ELECTROPHYSIOLOGIES, matrix.BLOODS, matrix.WALLS)
              if arguments.only in " ".join(parts)]
    if not chosen:
        parser.error(f"no combination contains '{arguments.only}'; electrophysiologies: {', '.join(matrix.ELECTROPHYSIOLOGIES)}; "
                     f"bloods: {', '.join(matrix.BLOODS)}; walls: {', '.join(matrix.WALLS)}")
    if not importlib.util.find_spec("dolfinx"):
        print("without the combinations of DOLFINx, which is not installed (python3-dolfinx)")
        chosen = [parts for parts in chosen if "DOLFINx" not in " ".join(parts)]
    with tempfile.TemporaryDirectory() as folder:
        computed = matrix.prepare(folder)
        with ThreadPoolExecutor(arguments.jobs) as pool:
            runs = list(pool.map(lambda parts: matrix.Combination(folder, *parts), chosen))
    bad, rows = 0, []
    for run in runs:
        first = next((other for other in [computed, *runs] if other.code == 0 and matrix.limit(run, other)), run)
        share = first.differs(run) if run.code == 0 else float("nan")
        good = run.code == 0 and share <= matrix.limit(run, first) and run.pressure[-1] > run.pressure[0] + LEAST_RISE
        bad += not good
        rows.append([*run.parts, f"{run.pressure[-1]:.4f}" if run.pressure else "", f"{share:.1e}", f"{run.seconds:.1f}",
                     "yes" if good else "NO"])
        print("  ".join(f"{value:20}" for value in rows[-1]), flush=True)
        if run.code:
            print(run.output[-1500:])
    if arguments.write:
        with open(matrix.SOURCE / "docs/results/swap_matrix.csv", "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["electrophysiology", "blood", "wall", "pressure at 20 ms, Pa",
                             "largest difference from the first code, share of range", "CPU s", "as it must be"])
            writer.writerows(rows)
    sys.exit(1 if bad else 0)


main()
