"""Tries the small faults of the YAML files beside this one, one at a time, in a copy of the sources."""
import filecmp
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import yaml

SOURCE = Path(__file__).resolve().parents[2]
COPY = SOURCE / "build/mutants"
BUILD = COPY / "build/release"
SAID = SOURCE / "build/mutants.said"  # what the tests of each fault have said
LONGEST = 120                         # [s] of single cases: some faults make a run hang


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
        sys.exit(f"{mutant['name']}: {mutant['file']} has {text.count(mutant['old'])} times '{mutant['old']}'; "
                 "it must stand there once")
    path.write_text(text.replace(mutant["old"], mutant["new"]))
    return path, text


def targets(pattern):
    """What the tests of the pattern run: their own executable, or all programs."""
    own = [name.split("/") for name in pattern.split("|") if name.startswith(("unit/", "mms/"))]
    programs = ["programs"] if re.search("regression|coupling|fuzz", pattern) else []
    return [f"{kind}_{name}" for kind, name in own] + programs + ["fuzz_validate"] * ("fuzz" in pattern)


def tests_of(mutant):
    """As ctest knows them."""
    shown = subprocess.run(["ctest", "--test-dir", str(BUILD), "-R", mutant["tests"], "--show-only=json-v1"],
                           check=True, capture_output=True, text=True).stdout
    tests = json.loads(shown)["tests"]
    if not tests:
        sys.exit(f"{mutant['name']}: no test matches '{mutant['tests']}'")
    return tests


def end_all(mark):
    """Whomever a test has left behind."""
    for environ in Path("/proc").glob("[0-9]*/environ"):
        try:
            if mark.encode() in environ.read_bytes():
                os.kill(int(environ.parent.name), signal.SIGKILL)
        except OSError:  # ended meanwhile, or somebody else's
            pass


def is_red(test, mutant, said):
    properties = {each["name"]: each["value"] for each in test["properties"]}
    mark = f"HEARTBUS_MUTANT={mutant['name']}.{os.getpid()}."
    environment = dict(word.split("=", 1) for word in [*properties["ENVIRONMENT"], mark])
    cases = mutant.get("case", "").split()
    try:
        return subprocess.run([*test["command"], *cases], cwd=properties["WORKING_DIRECTORY"], stdin=subprocess.DEVNULL,
                              stdout=said, stderr=subprocess.STDOUT, env={**os.environ, **environment}, check=False,
                              timeout=LONGEST if cases else properties["TIMEOUT"]).returncode != 0
    except subprocess.TimeoutExpired:
        print("\nnot at its end in time", file=said, flush=True)
        return True
    finally:
        end_all(mark)


def red_tests(mutant):
    build = subprocess.run(["ninja", "-C", str(BUILD), *targets(mutant["tests"])], capture_output=True, text=True)
    if build.returncode:
        sys.exit(f"{mutant['name']} does not compile:\n{build.stdout[-2000:]}")
    SAID.mkdir(exist_ok=True)
    with open(SAID / mutant["name"], "w", encoding="utf-8") as said:
        return [test["name"] for test in tests_of(mutant) if is_red(test, mutant, said)]


def chosen(names):
    """Those of these names, items or files; without any, all."""
    mutants = []
    for file in sorted((SOURCE / "tests/mutants").glob("*.yaml")):
        mutants += [{"file_name": file.stem, "item": "", **mutant} for mutant in yaml.safe_load(file.read_text())]
    keys = ("name", "item", "file_name")
    if unknown := set(names) - {mutant[key] for mutant in mutants for key in keys}:
        sys.exit(f"there is no fault {', '.join(sorted(unknown))}")
    return [mutant for mutant in mutants if not names or any(mutant[key] in names for key in keys)]


def main(names):
    mutants = chosen(names)
    copy_sources()
    survivors = []
    print("| fault | what it breaks | red tests | s |\n|---|---|---|---|")
    for mutant in mutants:
        begin = time.time()
        path, text = change(mutant)
        try:
            red = red_tests(mutant)
        finally:
            path.write_text(text)
        survivors += [] if red else [mutant["name"]]
        name = f"{mutant['item']}: {mutant['name']}" if mutant["item"] else mutant["name"]
        shown = ", ".join(filter(None, [*red, mutant.get("case", "")])) if red else "**none**"
        print(f"| {name} | {mutant['breaks']} | {shown} | {time.time() - begin:.0f} |", flush=True)
    if survivors:
        sys.exit(f"{len(survivors)} of the faults survive: {', '.join(survivors)}")


if __name__ == "__main__":
    main(sys.argv[1:])
