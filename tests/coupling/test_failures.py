"""docs/failures.md: each command fails as the page says, with the page's words and numbers; the pictures are of what they
leave."""
import re
import tempfile
import unittest
from pathlib import Path

from documents import Document
from launch import SOURCE, Forked, Launch

PAGE = Document(SOURCE / "docs/failures.md")
NEAR = 0.05  # share by which numbers may differ: what grows depends on round-off
NUMBER = re.compile(r"(?<![\w^.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w^])")


def flat(text):
    return " ".join(text.split())


def statements(lines):
    """(exit code, what is said): a message of failure goes on over all lines, others over those that are indented."""
    code = int(re.fullmatch(r"exit code (\d+)", lines[0])[1])
    said = "\n".join(lines[1:])
    return code, [flat(each) for each in ([said] if said.startswith("heartbus:") else re.split(r"\n(?! )", said))]


def cases():
    """[(title, commands, exit code, statements)] of the page: a block `sh` and the block `text` after it."""
    titles = iter(re.findall(r"^## .*?(?=^## |\Z)", PAGE.text, re.M | re.S))
    found = []
    for section in titles:
        for commands, said in re.findall(r"^```sh\n(.*?)^```\n\s*^```text\n(.*?)\n```$", section, re.M | re.S):
            found.append((section.split("\n")[0][3:], commands, *statements(said.split("\n"))))
    return found


def pattern(statement):
    """Words as they are, numbers as groups, '…' for anything."""
    parts, end = [], 0
    for number in NUMBER.finditer(statement):
        parts += [re.escape(statement[end:number.start()]), r"(-?\d[\d.]*(?:e[+-]?\d+)?)"]
        end = number.end()
    return "".join([*parts, re.escape(statement[end:])]).replace("…", r"\S+?")


class Failures(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = Path(temporary.name)
        for name in ("tools", "configs", "examples"):
            (cls.folder / name).symlink_to(SOURCE / name)
        cls.launches = [Launch(["bash", "-c", commands], cls.folder) for _, commands, _, _ in cases()]

    def assert_said(self, statement, output):
        """Returns what follows it in the output."""
        found = re.search(pattern(statement), output)
        self.assertTrue(found, f"not said: {statement}\nbut: {output[-1500:]}")
        for shown, number in zip(NUMBER.findall(statement), found.groups()):
            self.assertLessEqual(abs(float(number) - float(shown)), NEAR * abs(float(shown)), f"{number} in: {found[0]}")
        return output[found.end():]

    def test_each_command_fails_as_the_page_says(self):
        self.assertEqual(len(cases()), len(re.findall(r"^```sh$", PAGE.text, re.M)), "a command without what it says")
        self.assertGreaterEqual(len(cases()), 8)
        for (title, _, code, said), launch in zip(cases(), self.launches):
            with self.subTest(title):
                self.assertEqual(launch.code, code, launch.output[-1500:])
                rest = flat(launch.output)
                for statement in said:
                    rest = self.assert_said(statement, rest)
                self.assertEqual(launch.orphans, [])

    def test_pictures_are_of_what_the_commands_leave(self):
        drawing = Forked(SOURCE / "docs/pictures/failures.py", ["results", "--out", "drawn"], self.folder)
        self.assertEqual(drawing.code, 0, drawing.output)
        drawn = {f"pictures/{file.name}" for file in (self.folder / "drawn").glob("*.png")}
        self.assertEqual(drawn, {link for link in re.findall(r"\]\((.*?\.png)\)", PAGE.text)})


if __name__ == "__main__":
    unittest.main(verbosity=2)
