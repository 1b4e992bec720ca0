"""Scenes with something wrong in them, made from good ones. Each mutation says whether what it makes must be refused."""
import random
import re

NUMBER = r"[-+]?\d+(?:\.\d*)?(?:e[-+]?\d+)?"
UNKNOWN = "nowhere"
OWN_NAMES = re.compile(r"(participants|mechanics\.(loads|regions|probes))\.[^.]+$")  # any name will do
OWN_SETTINGS = re.compile(r"participants\.[^.]+\.settings\.")  # for the program to judge, when it starts
SHELL = ["$(touch pwned)", "`touch pwned`", "a;touch pwned", "a|b", "a&b", "..", ".", "-n", ":", "a/b", "/tmp", "a b", "~",
         "a\\nb", "\\e[31mred", "\\0", "a\\tb", "*", "a'b", 'a\\"b', "x" * 5000, "", "--out", "\\u0085"]
NOT_FINITE = ["nan", "-nan", "inf", "-inf", "1e999", "-1e999", ".nan", ".inf", "NaN", "Infinity"]
BEYOND = ["1e300", "-1e300", "1e30", "-1e30", "1e-300", "1e308", "4.9e-324"]
SUSPECT = ["0", "-0", "-1", "1e9", "-1e9", "2147483648", "4294967297", "-2147483649", "9223372036854775808", "0.1", "1e-9", "1e-14",
           "0x10", "1_000", "1,5", "1e", "+1", "١", "010", "1e15", "1e-15"]
TRICKS = ["&a [*a]", "&a {b: *a}", "*nowhere", "!!binary x", "!!python/object:os.system x", "!<tag:x> y", "[" * 600, "{a: " * 200,
          "(" * 3000, "- - - -", "? x", "|", ">\n", "'", '"', '"\\', "%", "@", "`", "---", "...", "{a: 1, a: 2}", "[1, [2, [3]]]",
          "<<: *x", "\t", "\x00", "\x07", "\u2028", "null", "~", "yes", "no", "on", "2001-12-14", "1:30", "0o7", "[]", "{}", "''",
          "&x 1 m", "1 " + "(" * 5000 + "m", "1 " + "m " * 5000, "1 m^99999999999", "1 m^2147483647", "1 m^-2147483648",
          "1 (m^9)", "1 /m", "1 m/", "1 ^", "x" * 100000, "1 " + "(" * 9 + "m" + ")" * 9]


class Mutant:
    def __init__(self, text, what, must_fail, settings=()):
        self.text, self.what, self.must_fail, self.settings = text, what, must_fail, settings


class Scene:
    """A resolved scene, `key: value  # meaning` a line, every key written."""

    def __init__(self, text):
        self.lines = text.split("\n")
        self.paths = self.find_paths()

    def find_paths(self):
        paths, path = [], []
        for line in self.lines:
            found = re.match(r"( *)(?:- )?([^\s:#]+):", line)
            if found:
                depth = (len(found[1]) + (2 if line.lstrip().startswith("- ") else 0)) // 2
                path = path[:depth] + [found[2]]
            paths.append(".".join(path) if found else "")
        return paths

    def values(self, pattern):
        """Where values match: (line, match)."""
        for number, line in enumerate(self.lines):
            found = re.match(r"(?P<before> *(?:- )?[^\s:#]+: )(?P<value>" + pattern + r")(?P<after> *(?:#.*)?)$", line)
            if found and not OWN_SETTINGS.match(self.paths[number]):
                yield number, found

    def replaced(self, number, line):
        return "\n".join(self.lines[:number] + [line] + self.lines[number + 1 :])

    def with_value(self, number, found, value):
        return self.replaced(number, found["before"] + value + found["after"])


class Mutator:
    def __init__(self, scene, numbers):
        self.scene, self.random = scene, numbers
        self.quantities = list(scene.values(rf"(?P<number>{NUMBER}) (?P<unit>[^\s#\[\],][^#\[\],]*?)"))
        self.numbers = list(scene.values(rf"(?P<number>{NUMBER})(?P<unit>)"))
        self.scalars = list(scene.values(r"[^#\[{\s][^#]*?"))
        self.lists = list(scene.values(r"\[[^#]*\]"))
        self.keys = [i for i, path in enumerate(scene.paths) if path]

    def made(self, kinds=("not_finite", "beyond", "suspect", "unit", "no_unit", "key", "kind", "trick", "name", "label", "size",
                          "bytes", "lines", "setting")):
        kind = self.random.choice(kinds)
        return getattr(self, kind)()

    def number_replaced(self, by, must_fail, what):
        number, found = self.random.choice(self.quantities + self.numbers)
        value = self.random.choice(by) + (" " + found["unit"] if found["unit"] else "")
        return Mutant(self.scene.with_value(number, found, value), f"{what}: {self.scene.paths[number]} = {value}", must_fail)

    def not_finite(self):
        return self.number_replaced(NOT_FINITE, True, "not finite")

    def beyond(self):
        return self.number_replaced(BEYOND, True, "beyond all sizes")

    def suspect(self):
        return self.number_replaced(SUSPECT, False, "suspect number")

    def unit(self):
        number, found = self.random.choice(self.quantities)
        unit = self.random.choice([u for u in ("kg", "mV", "furlong", "m^7", "K", "GGm", "mm mm mm mm", "μ") if u != found["unit"]])
        return Mutant(self.scene.with_value(number, found, f"{found['number']} {unit}"), f"unit: {self.scene.paths[number]} {unit}",
                      True)

    def no_unit(self):
        number, found = self.random.choice(self.quantities)
        return Mutant(self.scene.with_value(number, found, found["number"]), f"no unit: {self.scene.paths[number]}", True)

    def key(self):
        number = self.random.choice([i for i in self.keys if not OWN_NAMES.match(self.scene.paths[i])
                                     and not OWN_SETTINGS.match(self.scene.paths[i])])
        line, name = self.scene.lines[number], self.scene.paths[number].split(".")[-1]
        new = self.random.choice([name + "x", name[1:] + "q", name.upper() + "_", name + " " + name, "é" + name, name * 50])
        return Mutant(self.scene.replaced(number, line.replace(name, new, 1)), f"key: {self.scene.paths[number]} -> {new}", True)

    def kind(self):
        number, found = self.random.choice(self.scalars)
        value = self.random.choice(["{a: 1}", "[1, 2]", "", "[[]]", "{}", "[]"])
        return Mutant(self.scene.with_value(number, found, value), f"kind: {self.scene.paths[number]} = {value or 'nothing'}", True)

    def trick(self):
        number, found = self.random.choice(self.scalars + self.lists)
        value = self.random.choice(TRICKS)
        return Mutant(self.scene.with_value(number, found, value), f"trick: {self.scene.paths[number]} = {value[:40]}", False)

    def name(self):
        name = self.random.choice(SHELL)
        if self.random.random() < 0.5:
            return Mutant(self.scene.replaced(self.scene.paths.index("scene"), f'scene: "{name}"'), f"name of the scene: {name[:40]}", True)
        number = self.random.choice([i for i in self.keys if re.fullmatch(r"participants\.[^.]+", self.scene.paths[i])])
        return Mutant(self.scene.replaced(number, f'  "{name}":'), f"name of a participant: {name[:40]}", True)

    def label(self):
        labels = [(i, f) for i, f in self.lists if re.search(r"labels|fixed|rollers|slip", self.scene.paths[i])
                  and not self.scene.paths[i].startswith("mechanics.passive")]
        number, found = self.random.choice(labels)
        return Mutant(self.scene.with_value(number, found, f"[{UNKNOWN}]"), f"label: {self.scene.paths[number]}", self.uses(number))

    def uses(self, number):
        """Whether somebody takes part whom the block of this line is for."""
        block = self.scene.paths[number].split(".")[0]
        users = {"mechanics": ("mech", "fsi"), "fluid": ("fluid", "fsi"), "lifting": ("ale",)}[block]
        return any(f"participants.{user}" in self.scene.paths for user in users)

    def size(self):
        """Metres for millimetres."""
        number, found = self.random.choice([(i, f) for i, f in self.quantities if f["unit"] == "m" and ".ventricle." in self.scene.paths[i]
                                            and not self.scene.paths[i].endswith(("base_height", "wall"))])
        value = f"{1000 * float(found['number']):g} m"
        return Mutant(self.scene.with_value(number, found, value), f"size: {self.scene.paths[number]} = {value}", True)

    def bytes(self):
        text = list("\n".join(self.scene.lines))
        for _ in range(self.random.randint(1, 8)):
            at = self.random.randrange(len(text))
            text[at] = self.random.choice([chr(self.random.randrange(256)), "", text[at] * 2, ":", "\n", " ", "*", "&", "{", "}", "[", "]"])
        return Mutant("".join(text), "bytes", False)

    def lines(self):
        lines = list(self.scene.lines)
        for _ in range(self.random.randint(1, 4)):
            at, other = self.random.randrange(len(lines)), self.random.randrange(len(lines))
            action = self.random.choice(["drop", "double", "move", "indent", "cut"])
            if action == "drop":
                lines[at] = ""
            elif action == "double":
                lines.insert(other, lines[at])
            elif action == "move":
                lines[at], lines[other] = lines[other], lines[at]
            elif action == "indent":
                lines[at] = " " * self.random.randint(1, 4) + lines[at]
            else:
                lines[at] = lines[at][: len(lines[at]) // 2]
        return Mutant("\n".join(lines), "lines", False)

    def setting(self):
        """On the command line, where there are no tabs and newlines."""
        path = self.random.choice([self.scene.paths[i] for i in self.keys])
        value = re.sub(r"[\t\n\0]", " ", self.random.choice(NOT_FINITE + BEYOND + SUSPECT + TRICKS + SHELL))
        path = self.random.choice([path, path + ".x", "." + path, path * 300, path.split(".")[-1], "a." * 20000, ""])
        return Mutant("\n".join(self.scene.lines), f"--set {path[:60]}={value[:40]}", False, [f"{path}={value}"])


def mutants(scenes, count, seed):
    numbers = random.Random(seed)
    mutators = [Mutator(scene, numbers) for scene in scenes]
    for _ in range(count):
        mutator = numbers.choice(mutators)
        try:
            mutant = mutator.made()
            if numbers.random() < 0.2:  # a second mutation, of what the first made
                second = Mutator(Scene(mutant.text), numbers).made(("beyond", "suspect", "bytes", "lines", "trick"))
                mutant = Mutant(second.text, mutant.what + "; " + second.what, False, mutant.settings)
        except IndexError:  # this scene has nothing of the kind
            continue
        yield mutant
