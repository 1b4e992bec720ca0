"""What documents contain: prose, code blocks, spans, links, commands."""
import os
import re
import shlex
from pathlib import Path

SOURCE = Path(os.environ["HEARTBUS_SOURCE"])
NOT_OURS = ("build", "results", "shared")  # at the top: what is made, or lies beside the sources
# What stands for anything in a command that is shown.
PLACEHOLDERS = {"configs/ideal_lv/SCENE.yaml": "configs/ideal_lv/efs1.yaml", "SCENE": "configs/ideal_lv/efs1.yaml",
                "mesh=MESH": "mesh=M0", "N": "2", "C": "4", "RESULTS": "results/scene"}
SCRIPTS = re.compile(r"(\./(run|test)|tools/[\w./]+|tests/[\w/]+/run|build/release/bin/\w+|mpirun|cmake|ctest)( |$)")


def files(*patterns):
    found = [file for pattern in patterns for file in SOURCE.rglob(pattern)]
    return sorted(file for file in found if (parts := file.relative_to(SOURCE).parts)[0] not in NOT_OURS
                  and not any(part.startswith(".") and part != ".ci" for part in parts))


class Document:
    """A Markdown file: numbered lines of prose, outside tables and blocks; blocks; what is in backticks."""

    def __init__(self, file):
        self.file, self.name = file, str(file.relative_to(SOURCE))
        self.text = file.read_text(encoding="utf-8")
        self.prose, self.blocks, block = [], [], None
        for number, line in enumerate(self.text.split("\n"), 1):
            if line.lstrip().startswith("```"):
                block = None if block else (line.strip("` "), [])
                if block:
                    self.blocks.append(block)
            elif block:
                block[1].append(line)
            elif not line.startswith("|"):
                self.prose.append((number, line))
        outside = re.sub(r"^```.*?^```", "", self.text, flags=re.S | re.M)
        self.spans = [" ".join(span.split()) for span in re.findall(r"`([^`]+)`", outside)]
        self.links = re.findall(r"\]\(([^)\s]+)\)", outside)
        self.anchors = {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-")
                        for title in re.findall(r"^#+ (.*)$", outside, flags=re.M)}

    def target(self, link):
        """The file that a relative link leads to, and the heading in it."""
        path, _, anchor = link.partition("#")
        file = (self.file.parent / path).resolve() if path else self.file
        return (file / "README.md" if file.is_dir() else file), anchor

    def commands(self):
        """Each command as words, without comments, redirections and what follows a pipe."""
        lines = [line for kind, block in self.blocks if kind in ("", "sh", "bash")
                 for line in "\n".join(block).replace("\\\n", " ").split("\n")]
        for line in [*lines, *(span for span in self.spans if " " in span)]:
            for part in re.split(r" && | \|\|? | > |; ", re.sub(r"\s#.*", "", line)):
                part = re.sub(r"^(\w+=\S+|taskset -c \d) ", "", part.strip())
                if SCRIPTS.match(part):
                    yield words_of(part)


def words_of(command):
    """Optional parts are given, placeholders filled."""
    words = shlex.split(re.sub(r"\[(--[^\]]*)\]", r"\1", command))
    return [re.sub(r"^RESULTS/", "results/scene/", PLACEHOLDERS.get(word, word)) for word in words]
