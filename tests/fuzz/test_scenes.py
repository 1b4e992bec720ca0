"""Thousands of wrong scenes: no crash, no hang, no nonsense accepted; each refusal is one line that names file and line.

Another seed or number: HEARTBUS_FUZZ_SEED, HEARTBUS_FUZZ_COUNT. What went wrong is kept in HEARTBUS_FUZZ_KEEP."""
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from mutants import Mutant, Scene, mutants  # noqa: E402

BIN, SOURCE = Path(os.environ["HEARTBUS_BIN"]), Path(os.environ["HEARTBUS_SOURCE"])
SEED = int(os.environ.get("HEARTBUS_FUZZ_SEED", 1))
COUNT = int(os.environ.get("HEARTBUS_FUZZ_COUNT", 6000))
ENDS = {"0": "accepted", "2": "refused", "8": "refused"}
PLACE = re.compile(r"error: (--set .*|\S*m\d+\.yaml:\d+: )")


def shipped_scenes():
    """All scenes of configs, as one text with every key, each with few ranks."""
    for path in sorted((SOURCE / "configs").rglob("*.yaml")):
        if "studies" in path.parts:
            continue
        text = subprocess.run([BIN / "fuzz_validate", "--print", path], stdout=subprocess.PIPE, text=True, check=True).stdout
        yield Scene(text)


class Scenes(unittest.TestCase):
    maxDiff = None

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def answers(self, cases):
        """(what it ended with, what was said) for each."""
        (self.folder / "list").write_text("\n".join(cases) + "\n", encoding="utf-8")
        done = subprocess.run([BIN / "fuzz_validate", "list"], cwd=self.folder, stdout=subprocess.PIPE, check=True, timeout=300)
        lines = done.stdout.decode("utf-8", "replace").split("\n")[:-1]
        self.assertEqual(len(lines), len(cases))
        return [line.split("\t", 1) for line in lines]

    def write(self, number, mutant):
        name = f"m{number}.yaml"
        (self.folder / name).write_bytes(mutant.text.encode("utf-8", "surrogateescape"))
        words = [name]
        for setting in mutant.settings:
            words += ["--set", setting]
        return "\t".join(words)

    def fault(self, mutant, end, said):
        if end not in ENDS:
            return f"ended with {end}"
        if "doubt:" in said:
            return "accepted, but " + said.split("doubt:")[1]
        if ENDS[end] == "accepted":
            return "accepted" if mutant.must_fail else ""
        if "\v" in said or re.search(r"[\x00-\x08\x0e-\x1f\x7f]", said):
            return "several lines, or control characters"
        return "" if PLACE.match(said) else "no place"

    def test_the_scenes_themselves_are_good(self):
        scenes = [Mutant("\n".join(scene.lines), "", False) for scene in shipped_scenes()]
        for end, said in self.answers([self.write(i, scene) for i, scene in enumerate(scenes)]):
            self.assertEqual(end, "0", said)

    def test_no_mutant_crashes_hangs_or_passes(self):
        made = list(mutants(list(shipped_scenes()), COUNT, SEED))
        answers = self.answers([self.write(i, mutant) for i, mutant in enumerate(made)])
        faults = []
        for number, (mutant, (end, said)) in enumerate(zip(made, answers)):
            if fault := self.fault(mutant, end, said):
                faults.append(f"m{number} ({mutant.what}): {fault}: {said[:200]}")
                if keep := os.environ.get("HEARTBUS_FUZZ_KEEP"):
                    shutil.copy(self.folder / f"m{number}.yaml", keep)
        ends = [ENDS.get(end, "fault") for end, _ in answers]
        print(f"seed {SEED}: {len(made)} mutants, {ends.count('refused')} refused, {ends.count('accepted')} accepted")
        self.assertGreater(len(made), 0.9 * COUNT)
        self.assertEqual(faults, [], f"seed {SEED}: {len(faults)} faults")
        self.assertFalse(list(self.folder.rglob("pwned")) + list(Path(".").glob("pwned")))

    def test_the_coupler_itself_answers_as_the_test_does(self):
        made = random.Random(SEED).sample(list(mutants(list(shipped_scenes()), 400, SEED + 1)), 30)
        answers = self.answers([self.write(i, mutant) for i, mutant in enumerate(made)])
        for number, (mutant, (end, said)) in enumerate(zip(made, answers)):
            words = [word for setting in mutant.settings for word in ("--set", setting)]
            if any(len(word) > 100000 for word in words):
                continue
            run = subprocess.run([BIN / "coupler", f"m{number}.yaml", *words, "--validate"], cwd=self.folder,
                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            self.assertEqual(str(run.returncode), end, mutant.what)
            self.assertEqual(run.stdout.decode("utf-8", "replace").strip(), said.strip(), mutant.what)

    def test_the_smallest_faults_that_were_seen(self):
        for text in ["scene: &a [*a]", "mechanics: &a {b: *a}", "time: {end: 1 " + "(" * 100000 + "s}",
                     "scene: " + "x" * 100000, "base: " + "x" * 100000, "a: " * 5000, "[" * 100000, "{" * 100000, "- " * 100000,
                     "a: &a [1,1]\nb: &b [*a,*a,*a,*a,*a,*a,*a,*a,*a]\nc: &c [*b,*b,*b,*b,*b,*b,*b,*b,*b]\n"
                     "d: &d [*c,*c,*c,*c,*c,*c,*c,*c,*c]\ne: &e [*d,*d,*d,*d,*d,*d,*d,*d]\nf: [*e,*e,*e,*e,*e,*e]",
                     "".join(f"k{i}: 1\n" for i in range(100000)), "\0" * 100, "x" * (1 << 21)]:
            with self.subTest(text[:40]):
                (self.folder / "m0.yaml").write_text(text)
                (end, said), = self.answers(["m0.yaml"])
                self.assertEqual(ENDS.get(end), "refused", said[:200])
                self.assertRegex(said, PLACE)


if __name__ == "__main__":
    unittest.main(verbosity=2)
