"""The names that the programs know for parts of the boundary, and what other programs call them."""
import re

from .model import Refusal

WANTED = {"solid": ["interface", "epicardium", "base"], "fluid": ["interface", "base", "mitral", "aortic"]}
# The first that fits counts. Words of a name end at what is no letter, and at digits.
GUESSES = [("interface", ("endo*", "interface", "lumen", "inner", "fsi")), ("epicardium", ("epi*", "outer", "pericard*")),
           ("mitral", ("mitral", "mv", "inlet", "inflow")), ("aortic", ("aortic", "aorta", "av", "outlet", "outflow", "lvot")),
           ("base", ("base", "basal", "top", "lid"))]


def words(name):
    return [word for word in re.split(r"[^a-z]+", name.lower()) if word]


def fits(word, pattern):
    return word.startswith(pattern[:-1]) if pattern.endswith("*") else word == pattern


def guess(name):
    """The program's name for it, or the name itself."""
    for label, patterns in GUESSES:
        if any(fits(word, pattern) for word in words(name) for pattern in patterns):
            return label
    return name


def parse(words_given):
    """{foreign name: label} of the words of --label; an empty label drops the surface."""
    mapping = {}
    for word in words_given:
        name, sign, label = word.partition("=")
        if not sign or not name:
            raise Refusal(f"--label {word}: write FOREIGN=LABEL, for instance endo_wall=interface")
        if label and not re.fullmatch(r"[\w.-]{1,60}", label):
            raise Refusal(f"--label {word}: a label is letters, digits, '_', '-' and '.'")
        mapping[name] = label
    return mapping


def rename(surfaces, mapping, notes):
    """[(label, faces)]: by the mapping, else by a guess, which is said."""
    renamed, said = [], set()
    for surface in surfaces:
        label = mapping.get(surface.name)
        if label is None:
            label = guess(surface.name)
            if label != surface.name and surface.name not in said:
                notes.append(f"label '{surface.name}' is taken for {label} (--label {surface.name}=... says otherwise)")
                said.add(surface.name)
        if label:
            renamed.append((label, surface.faces))
    return renamed


def missing(part_name, labels):
    return [label for label in WANTED[part_name] if label not in labels]
