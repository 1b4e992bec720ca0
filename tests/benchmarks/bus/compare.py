"""What an exchange costs through the bus's own C++, the interface of C, and Python: launches in turn, medians over them.

    ninja -C build/release benchmarks && python3 tests/benchmarks/bus/compare.py [--launches N] [--csv FILE]
"""
import argparse
import csv
import os
import statistics
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tools"))
from launching.mpirun import VARIABLES  # noqa: E402: as a launch of a scene has them

BIN = Path(os.environ.get("HEARTBUS_BIN", ROOT / "build/release/bin"))
BENCHMARK = BIN / "benchmark_bus"
# Our programs keep to cores, which the library leaves to others: here they do as ours.
KEPT = ["sh", "-c", 'exec taskset -c $(((PMIX_RANK - 1) % 2)) "$@"', "sh"]
WAYS = {"C++": [BENCHMARK, "--name"], "C": [*KEPT, BIN / "benchmark_echo"],
        "Python": [*KEPT, sys.executable, Path(__file__).with_name("echo.py")]}


def launch(words):
    """{vectors: us of a round trip}, and of bare MPI where it is measured."""
    command = ["mpirun", "--oversubscribe", "-n", "1", BENCHMARK, ":", "-n", "2", *words, "a", ":", "-n", "2", *words, "b"]
    environment = {**os.environ, **VARIABLES, "PYTHONPATH": str(BIN.parent / "share/heartbus/python")}
    output = subprocess.run([str(word) for word in command], env=environment, check=True, stdout=subprocess.PIPE, text=True).stdout
    rows = [line.split() for line in output.splitlines()]
    rows = [[float(word) for word in row] for row in rows if row and row[0].isdigit()]
    return {int(size): us for size, us, *_ in rows}, {int(row[0]): row[2] for row in rows if len(row) > 2}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--launches", type=int, default=7, help="of each")
    parser.add_argument("--csv", type=Path, help="every launch's figures")
    options = parser.parse_args()
    found = []  # (launch, way, vectors, us)
    for number in range(1, options.launches + 1):
        for way, words in WAYS.items():
            by_bus, bare = launch(words)
            found += [(number, way, size, us) for size, us in by_bus.items()]
            found += [(number, "bare MPI", size, us) for size, us in bare.items()]
    if options.csv:
        with open(options.csv, "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([("launch", "through", "vectors", "us"), *found])
    ways = ["bare MPI", *WAYS]
    print(f"us a round trip of vectors with three components, 2 + 2 ranks, {options.launches} launches in turn: median, least")
    print(f"{'vectors':>8}" + "".join(f"{way:>14}" for way in ways) + "".join(f"{way + '/C++':>16}" for way in ways[2:]))
    for size in sorted({size for _, _, size, _ in found}):
        times = {way: [us for _, w, s, us in found if (w, s) == (way, size)] for way in ways}
        shown = {way: (statistics.median(times[way]), min(times[way])) for way in ways}
        ratios = {way: tuple(x / y for x, y in zip(shown[way], shown["C++"])) for way in ways[2:]}
        print(f"{size:8}" + "".join(f"{median:8.0f}{least:6.0f}" for median, least in shown.values())
              + "".join(f"{median:10.2f}{least:6.2f}" for median, least in ratios.values()))


if __name__ == "__main__":
    main()
