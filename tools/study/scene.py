"""Scenes as trees: bases laid under, keys shortened as for --set, what is written into the folder of a run."""
import copy
import difflib

import yaml


class StudyError(Exception):
    """A mistake in a study: what is wrong, where, what would be right."""


def load(file):
    """A YAML file as a tree."""
    try:
        tree = yaml.safe_load(file.read_text())
    except OSError as error:
        raise StudyError(f"{file}: cannot be read: {error.strerror}") from error
    except yaml.YAMLError as error:
        raise StudyError(f"{file}: {error}") from error
    if not isinstance(tree, dict):
        raise StudyError(f"{file}: no keys in it")
    return tree


def check_keys(tree, allowed, where):
    for key in tree:
        if key not in allowed:
            near = difflib.get_close_matches(str(key), allowed, 1)
            hint = f"; '{near[0]}' is meant?" if near else ""
            raise StudyError(f"{where}: key '{key}' is unknown{hint} Allowed here: {', '.join(allowed)}")


def lay_over(tree, other):
    """`tree` with `other` laid over it; an empty value takes a key away."""
    result = copy.deepcopy(tree)
    for key, value in other.items():
        if value is None:
            result.pop(key, None)
        elif isinstance(value, dict):
            below = result.get(key)
            result[key] = lay_over(below if isinstance(below, dict) else {}, value)
        else:
            result[key] = copy.deepcopy(value)
    return result


def join(first, second):
    """Two overlays as one: unlike `lay_over`, empty values stay, since they are still to take something away."""
    result = dict(first)
    for key, value in second.items():
        both = isinstance(value, dict) and isinstance(result.get(key), dict)
        result[key] = join(result[key], value) if both else value
    return result


def mesh_file(tree):
    """What a tree says of a mesh file; None where its mesh is made by the programs."""
    mesh = (tree.get("geometry") or {}).get("mesh")
    return mesh if isinstance(mesh, str) and mesh.endswith(".h5") else None


def anchored(tree, folder):
    """The tree with the absolute path of its mesh file, which it names relative to `folder`."""
    mesh = mesh_file(tree)
    return join(tree, {"geometry": {"mesh": str((folder / mesh).resolve())}}) if mesh else tree


def with_bases(file):
    """The tree of a scene file with all its bases."""
    tree = anchored(load(file), file.parent)
    base = tree.pop("base", None)
    return lay_over(with_bases((file.parent / base).resolve()), tree) if base else tree


class Keys:
    """All keys of a scene; a key may be shortened as long as its end is unique. Names of loads and of regions are the
    scene's own."""

    def __init__(self, defaults, scene=None):
        self.defaults, self.paths = defaults, []
        self.collect(join(defaults, scene or {}), "")

    def collect(self, tree, prefix):
        for key, value in tree.items():
            self.paths.append(prefix + key)
            if isinstance(value, dict):
                self.collect(value, prefix + key + ".")

    def full(self, key, where, others=()):
        if key in self.paths or key.startswith("participants."):
            return key
        found = [path for path in self.paths if path.endswith("." + key)]
        if len(found) == 1:
            return found[0]
        if found:
            raise StudyError(f"{where}: key '{key}' is not unique: {', '.join(found)}")
        ends = [path.rsplit(".", 1)[-1] for path in self.paths]
        near = difflib.get_close_matches(key.rsplit(".", 1)[-1], [*ends, *others], 1)
        raise StudyError(f"{where}: key '{key}' is unknown" + (f"; '{near[0]}' is meant?" if near else ""))

    def overlay(self, settings, where, others=()):
        """{"alpha": "1 kg/(m^2 s)", "participants": {...}} as a tree with full keys."""
        tree = {}
        for key, value in (settings or {}).items():
            below = yaml.safe_load(value) if isinstance(value, str) and value.startswith("[") else value
            for part in reversed(self.full(key, where, others).split(".")):
                below = {part: below}
            tree = join(tree, below)
        return tree


def number(text):
    """The number in "0.2 ms", in the unit of the text."""
    try:
        return float(str(text).split()[0])
    except (ValueError, IndexError):
        return None


UNITS = {"": 1, "s": 1, "ms": 1e-3, "us": 1e-6, "m": 1, "mm": 1e-3, "cm": 1e-2, "Pa": 1, "kPa": 1e3, "MPa": 1e6,
         "kPa/m": 1e3, "Pa/m": 1, "kPa s/m": 1e3, "Pa s/m": 1, "kg/m^3": 1, "g/cm^3": 1e3}


def with_end(tree, overlay=None):
    """A scene, something laid over it, with the time at which it ends: that of its last beat, where it counts beats."""
    overlay = overlay or {}
    tree, time = lay_over(tree, overlay), (overlay.get("time") or {})
    if "beats" in time and "end" not in time:
        tree["time"].pop("end", None)
    if "end" not in tree.get("time", {}):
        beats = tree.get("time", {}).get("beats", 1)
        period = tree.get("electrophysiology", {}).get("stimulus", {}).get("period", "0.8 s")
        tree = lay_over(tree, {"time": {"end": f"{int(beats) * quantity(period):.10g} s"}})
    if "until_periodic" not in tree["time"]:
        tree["time"].pop("beats", None)  # a run may end earlier by its steps
    return tree


def quantity(text):
    """A number with its unit in SI units."""
    value, _, unit = str(text).partition(" ")
    try:
        return float(value) * UNITS[unit.strip()]
    except (ValueError, KeyError) as error:
        raise StudyError(f"'{text}': a number with one of the units {', '.join(UNITS)} is wanted") from error
