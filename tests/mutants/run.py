"""Tries the one-line faults of mutants.yaml, one at a time, in a copy of the sources."""
import filecmp
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import yaml

SOURCE = Path(__file__).resolve().parents[2]
COPY = SOURCE / "build/mutants"
BUILD = COPY / "build/release"


def copy_sources():
    """Only what changed is copied, so that a second call builds little."""
    files = subprocess.run(["git", "ls-files", "-z"], cwd=SOURCE, check=True, capture_output=True, text=True).stdout
    for name in filter(None, files.split("\0")):
        source, target = SOURCE / name, COPY / name
        if source.is_file() and not (target.is_file() and filecmp.cmp(source, target, shallow=False)):
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, target)
    if not (BUILD / "build.ninja").exists():
        subprocess.run(["cmake", "--preset", "release"], cwd=COPY, check=True, stdout=subprocess.DEVNULL)


def change(mutant):
    """Writes the fault; returns the file and its text before."""
    path = COPY / mutant["file"]
    text = path.read_text()
    if text.count(mutant["old"]) != 1:
        sys.exit(f"mutants.yaml, {mutant['name']}: {mutant['file']} has {text.count(mutant['old'])} times "
                 f"'{mutant['old']}'; it must stand there once")
    path.write_text(text.replace(mutant["old"], mutant["new"]))
    return path, text


def targets(pattern):
    """What the tests of the pattern run: their own executable, or all programs."""
    names = [name.split("/")[1] for name in pattern.split("|") if name.startswith(("unit/", "mms/"))]
    kinds = [name.split("/")[0] for name in pattern.split("|") if name.startswith(("unit/", "mms/"))]
    whole_programs = re.search("regression|coupling", pattern)
    return [f"{kind}_{name}" for kind, name in zip(kinds, names)] + (["programs"] if whole_programs else [])


def red_tests(mutant):
    build = subprocess.run(["ninja", "-C", str(BUILD), *targets(mutant["tests"])], capture_output=True, text=True)
    if build.returncode:
        sys.exit(f"{mutant['name']} does not compile:\n{build.stdout[-2000:]}")
    run = subprocess.run(["ctest", "--test-dir", str(BUILD), "-R", mutant["tests"]], capture_output=True, text=True,
                         env={**os.environ, "CTEST_OUTPUT_ON_FAILURE": "0"})
    if "No tests were found" in run.stdout + run.stderr:
        sys.exit(f"mutants.yaml, {mutant['name']}: no test matches '{mutant['tests']}'")
    return sorted(set(re.findall(r"\d+ - (\S+) \((?:Failed|Timeout|SEGFAULT|Subprocess aborted)", run.stdout)))


def main(names):
    mutants = yaml.safe_load((SOURCE / "tests/mutants/mutants.yaml").read_text())
    unknown = set(names) - {mutant["name"] for mutant in mutants}
    if unknown:
        sys.exit(f"mutants.yaml has no {', '.join(sorted(unknown))}")
    copy_sources()
    survivors = []
    print("| fault | what it breaks | red tests | s |\n|---|---|---|---|")
    for mutant in mutants:
        if names and mutant["name"] not in names:
            continue
        begin = time.time()
        path, text = change(mutant)
        try:
            red = red_tests(mutant)
        finally:
            path.write_text(text)
        survivors += [] if red else [mutant["name"]]
        print(f"| {mutant['name']} | {mutant['breaks']} | {', '.join(red) or '**none**'} | {time.time() - begin:.0f} |",
              flush=True)
    if survivors:
        sys.exit(f"{len(survivors)} of the faults survive: {', '.join(survivors)}")


if __name__ == "__main__":
    main(sys.argv[1:])
