#!/usr/bin/env python3
"""empty_libraries.py COMPILER LIBRARY FOLDER PREFIX...: for each library that LIBRARY is linked with and whose name begins with a
PREFIX, an empty one of the same name in FOLDER; their paths go to the standard output, joined by commas.

A program that is linked with the empty ones loads LIBRARY without the real ones and all that these need in turn. The empty
ones hold the data that the loader asks for (addresses of virtual tables and the like), but no function: a call of one ends
the program with its name. Nothing is made, and it is said why on the standard error, if LIBRARY takes anything else from
what would then not be loaded.
"""
import os
import re
import subprocess
import sys
from pathlib import Path


def said(*command, **environment):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
                          env={**os.environ, "LC_ALL": "C", **environment}).stdout


def compile_library(compiler, file, symbols):
    text = "".join(f"char {symbol}[64];\n" for symbol in sorted(symbols))  # of 64 bytes: only their addresses are asked for
    subprocess.run([compiler, "-shared", "-fPIC", "-nostdlib", "-x", "c", "-", "-o", file, f"-Wl,-soname,{file.name}"],
                   input=text, text=True, check=True)


def undefined(library, folder, option):
    """What the loader does not find when those of the folder stand for the real ones: data (option -d), functions, too (-r)."""
    return set(re.findall(r"undefined symbol: ([^\s,@]+)", said("ldd", option, library, LD_LIBRARY_PATH=str(folder))))


def defined(files):
    return {line.split()[-1].split("@")[0] for file in files for line in said("nm", "-D", "--defined-only", file).splitlines()}


def main():
    compiler, library, folder, *prefixes = sys.argv[1:]
    needed = re.findall(r"^\s*(lib\S+) => (/\S+)", said("ldd", library), re.M)
    direct = set(re.findall(r"NEEDED.*\[(.+)\]", said("readelf", "-dW", library)))
    real = {name: path for name, path in needed if name in direct and name.startswith(tuple(prefixes))}
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    files = [folder / name for name in sorted(real)]
    for old in set(folder.iterdir()) - set(files):
        old.unlink()
    if not files:
        return
    for file in files:
        compile_library(compiler, file, ())
    compile_library(compiler, files[0], undefined(library, folder, "-d"))
    if others := undefined(library, folder, "-r") - defined(real.values()):
        print(f"{library} takes {', '.join(sorted(others)[:3])} from a library that only {', '.join(sorted(real))} need",
              file=sys.stderr)
        return
    print(*files, sep=",", end="")


main()
