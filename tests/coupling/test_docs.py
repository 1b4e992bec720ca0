"""What the documents say is there: files, links, keys, references; their commands are accepted; they stay readable."""
import argparse
import contextlib
import functools
import io
import os
import re
import runpy
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np
import yaml
from PIL import Image

from documents import SOURCE, Document, files

BIN = Path(os.environ["HEARTBUS_BIN"])
DOCUMENTS = [Document(file) for file in files("*.md")]
CODE = files("*.h", "*.cpp", "*.py", "*.yaml", "*.sh", "CMakeLists.txt")
TABLED = ["ep_solver", "mech_solver", "ale_solver", "fluid_solver", "fsi_solver", "coupler", "common/bus", "common/interface"]
MADE = ("results/", "report/", "fields/", "checkpoints/", "logs/", "build/", "bin/", "lib/", "include/", "share/",
        "paraview_state.py")
DOI = re.compile(r"\b10\.\d{4,5}/[\w.()/-]*\w")
sys.path[:0] = [str(SOURCE / "tools")]
from reporting import style  # noqa: E402


class Parsed(Exception):
    """Instead of what a script would do, once it has accepted its arguments."""


def arguments(script, words):
    """What the argument parser of a script makes of these words."""
    plain = argparse.ArgumentParser.parse_known_args

    def stop(parser, *given):
        raise Parsed(*plain(parser, *given))
    argv, sys.argv, argparse.ArgumentParser.parse_known_args = sys.argv, [script, *words], stop
    try:
        runpy.run_path(str(SOURCE / script), run_name="__main__")
    except Parsed as parsed:
        return parsed.args
    finally:
        sys.argv, argparse.ArgumentParser.parse_known_args = argv, plain
    raise AssertionError(f"{script} looks at no arguments")


@functools.lru_cache
def coupler(*words):
    return subprocess.run([BIN / "coupler", *words], cwd=SOURCE, text=True, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)


def check_scene(words):
    result = coupler("--default-scene", "configs/ideal_lv/efs1.yaml", *words,
                     *([] if {"--print-defaults", "--launch-line", "--validate"} & set(words) else ["--validate"]))
    if result.returncode != 0:
        raise AssertionError(result.stdout.strip())


def check_study(options, examples):
    from study.launch import defaults
    from study.plan import Study
    file = examples.get(options.study.name, SOURCE / options.study)
    if options.command == "budget":
        return check_scene([str(file)])
    runs = {run.name for run in Study(file, defaults(), options.base, options.settings, options.ranks).runs}
    if unknown := [name for name in options.only if not set("*?") & set(name) and name not in runs]:
        raise AssertionError(f"no such runs: {unknown}")


def check_heartbus(words, examples):
    """By the program behind the command."""
    known = runpy.run_path(str(SOURCE / "tools/heartbus"), run_name="read")
    if words[0] == "example":
        return [known["shipped"]()[name] for name in words[1:] if not name.startswith("-")]
    behind = {"run": "./run", "check": "build/release/bin/coupler", "study": "tools/study.py", "report": "tools/report.py",
              "pictures": "tools/pictures.py", "trace": "tools/gaps", "cost": "tools/cost", "mesh": "tools/mesh"}
    return check_command([behind[words[0]], *words[1:]], examples)


def check_command(words, examples):
    """Raises where a command would be refused."""
    script, rest = words[0], words[1:]
    if script == "mpirun":
        programs = [Path(word).name for word in rest if re.fullmatch(r"\w+_solver|coupler|replay", Path(word).name)]
        return [(BIN / name).resolve(strict=True) for name in programs]
    if script in ("cmake", "ctest"):
        known = (SOURCE / "CMakePresets.json").read_text() + (SOURCE / "tests/CMakeLists.txt").read_text()
        for option, value in zip(rest, rest[1:]):
            if option in ("--preset", "-L") and value not in known:
                raise AssertionError(f"there is no {value}")
        return None
    if script.startswith("build/release/bin/"):
        return check_scene(rest) if script.endswith("/coupler") else None
    (SOURCE / script).resolve(strict=True)
    if script == "tools/heartbus":
        return check_heartbus(rest, examples)
    if script == "./run":
        return check_scene(arguments("tools/launch.py", rest)[1])
    first = (SOURCE / script).read_text().split("\n")[0]
    if "python" not in first or not rest:
        return None
    options, unknown = arguments(script, rest)
    if unknown:
        raise AssertionError(f"unknown: {unknown}")
    if script == "tools/study.py":
        return check_study(options, examples)
    for scene in getattr(options, "scenes", []) or [getattr(options, "scene", None)]:
        if scene:
            check_scene([scene])
    return None


def is_there(name, document):
    """A file or folder that a document names: from the top, from the folder of the document, or a test."""
    if any(letter in name for letter in "*<>()"):
        return True
    if braces := re.search(r"\{([^}]*)\}", name):
        return all(is_there(name.replace(braces[0], each), document) for each in braces[1].split(","))
    folders = [SOURCE, document.file.parent, SOURCE / "tests", SOURCE / "common", SOURCE / "tests/coupling"]
    return any((folder / (name + end)).exists() for folder in folders for end in ("", ".h", ".cpp", ".py"))


class Docs(unittest.TestCase):
    def test_files_named_exist(self):
        tops = {path.name for path in SOURCE.iterdir()}
        for document in DOCUMENTS:
            local = tops | {path.name for path in document.file.parent.iterdir()}
            for name in document.spans:
                if not re.fullmatch(r"[\w./{},*<>+-]+", name) or name.startswith((*MADE, "/", ".")):
                    continue
                of_ours = "/" in name and name.split("/")[0] in local
                if of_ours or re.search(r"\.(h|cpp|py|md|sh|txt|\{h,cpp\})$", name):
                    with self.subTest(document=document.name, name=name):
                        self.assertTrue(is_there(name, document), "there is no such file")

    def test_links_resolve(self):
        for document in DOCUMENTS:
            for link in document.links:
                if not re.match(r"\w+:", link):
                    with self.subTest(document=document.name, link=link):
                        file, anchor = document.target(link)
                        self.assertTrue(file.exists(), "there is no such file")
                        if anchor:
                            self.assertIn(anchor, Document(file).anchors)

    def test_readme_leads_to_every_page(self):
        known, found, to_do = {document.file: document for document in DOCUMENTS}, set(), [SOURCE / "README.md"]
        while to_do:
            file = to_do.pop()
            if file in known and file not in found:
                found.add(file)
                to_do += [known[file].target(link)[0] for link in known[file].links if not re.match(r"\w+:", link)]
        self.assertEqual(sorted(known[file].name for file in set(known) - found), [], "no page links to these")

    def test_tables_of_files_are_complete(self):
        for folder in TABLED:
            text = (SOURCE / folder / "README.md").read_text()
            table = re.search(r"^\| file \|.*?(?=\n[^|]|\Z)", text, flags=re.S | re.M)[0]
            named = {re.sub(r"\.(h|cpp)$", "", name)
                     for row in table.split("\n") for name in re.findall(r"`([^`]+)`", row.split("|")[1])}
            there = {str(file.relative_to(SOURCE / folder).with_suffix(""))
                     for end in ("*.h", "*.cpp") for file in (SOURCE / folder).rglob(end)}
            of_folders = {name for name in there if str(Path(name).parent) + "/" in named}
            gone = {name for name in named - there if not (SOURCE / folder / name).is_dir()}
            self.assertEqual(sorted(there - named - of_folders), [], f"{folder}/README.md does not name these")
            self.assertEqual(sorted(gone), [], f"{folder}/README.md names these")

    def test_lines_are_short(self):
        for document in DOCUMENTS:
            long = [number for number, line in document.prose if len(line) > 110]
            self.assertEqual(long, [], f"{document.name}: lines beyond 110 characters")

    def test_documents_tell_no_history(self):
        pattern = re.compile(r"(decisions?,? \d+|decisions\.md)", flags=re.I)
        for file in files("*.md", "*.h", "*.cpp", "*.py", "*.yaml"):
            if file.name != Path(__file__).name:
                with self.subTest(file=str(file.relative_to(SOURCE))):
                    self.assertEqual([match[0] for match in pattern.finditer(file.read_text(encoding="utf-8"))], [])

    def test_keys_of_scenes_exist(self):
        defaults = yaml.safe_load(coupler("--print-defaults").stdout)
        blocks = set(defaults) - {"participants"}  # whose keys are names
        for document in DOCUMENTS:
            for span in document.spans:
                key = re.match(r"([a-z]\w*(\.\w+)+)(: .*|=.*)?$", span)
                path = key[1].split(".") if key else [""]
                if path[0] in blocks and path[-1] not in ("yaml", "h5", "xdmf", "csv", "json", "py"):
                    with self.subTest(document=document.name, key=key[1]):
                        value = functools.reduce(lambda tree, name: (tree or {}).get(name), path, defaults)
                        self.assertIsNotNone(value, "there is no such key")

    def test_commands_are_accepted(self):
        with tempfile.TemporaryDirectory() as folder:
            examples = self.examples(Path(folder))
            shown = {}
            for document in DOCUMENTS:
                for words in document.commands():
                    shown.setdefault(tuple(words), document.name)
            self.assertGreater(len(shown), 30)
            for words, name in shown.items():
                with self.subTest(document=name, command=" ".join(words)):
                    errors = io.StringIO()
                    try:
                        with contextlib.redirect_stderr(errors):
                            check_command(list(words), examples)
                    except (SystemExit, Exception) as error:
                        self.fail(f"{errors.getvalue().strip()} {error}")

    def examples(self, folder):
        """Studies that a document shows whole, by the names under which it runs them."""
        found = {}
        for document in DOCUMENTS:
            for kind, lines in document.blocks:
                if kind == "yaml" and any(line.startswith("base: ") for line in lines):
                    name = re.search(r"[Ss]aved as `([\w.]+)`", document.text)[1]
                    found[name] = folder / name
                    found[name].write_text("\n".join(lines).replace("base: configs", f"base: {SOURCE}/configs"))
        return found

    def test_pictures_of_reports_have_all_colours_and_the_whole_page(self):
        """Which ends with its margin; a palette would make one colour of those of two schemes."""
        for name, n_schemes in (("report", 1), ("report_real_lv", 1), ("report_comparison", 4)):
            with self.subTest(name), Image.open(SOURCE / f"docs/pictures/{name}.png") as picture:
                self.assertEqual(picture.mode, "RGB")
                pixels = np.asarray(picture).astype(int)
                self.assertEqual(pixels[-40:].min(), 255)
                self.assertLess(pixels[-120:].min(), 150, "text ends there")
                for shade in style.colours(["EFS1", "E1FS2", "EFS1-corrected", "E1FSinf"])[:n_schemes]:
                    self.assertGreater((abs(pixels - 255 * np.array(style.to_rgb(shade))).max(axis=2) < 3).sum(), 500, shade)

    def test_published_pictures_of_a_beat_are_of_m1_or_finer(self):
        """They say themselves of what they are."""
        for name in ("activation", "potential", "fibres", "ejection", "pv_loop", "volume_pressure"):
            with self.subTest(name), Image.open(SOURCE / f"docs/pictures/{name}.png") as picture:
                self.assertRegex(picture.text.get("Source", "no source"), r"^ideal_lv_efs1, EFS1, mesh M[123], heartbus \d")

    def test_references_are_listed(self):
        entries = re.findall(r"^@\w+\{(.*?)^\}", (SOURCE / "docs/references.bib").read_text(), flags=re.S | re.M)
        for entry in entries:
            for part in "author", "title", "year", "doi":
                self.assertIn(f"  {part} = {{", entry)
        listed = {re.search(r"doi = \{(.*?)\}", entry)[1] for entry in entries}
        self.assertEqual(len(listed), len(entries), "a DOI twice")
        cited = {}
        for file in [*CODE, *(document.file for document in DOCUMENTS)]:
            for doi in DOI.findall(file.read_text(encoding="utf-8")):
                while doi.count(")") > doi.count("("):  # those around it
                    doi = doi[:doi.rindex(")")]
                cited.setdefault(doi, str(file.relative_to(SOURCE)))
        unlisted = {doi: file for doi, file in cited.items() if doi not in listed}
        self.assertEqual(unlisted, {}, "not in docs/references.bib")
        self.assertEqual(sorted(listed - set(cited)), [], "cited nowhere")


if __name__ == "__main__":
    unittest.main(verbosity=2)
