"""openCARP's NAME.pts, NAME.elem, NAME.lon and NAME*.surf, in micrometres."""
import itertools

import numpy as np

from .model import Foreign, Refusal, Surface

# word: (kind, vertices)
CELLS = {"Tt": ("tetrahedra", 4), "Hx": ("hexahedra", 8), "Pr": ("wedges", 6), "Py": ("pyramids", 5)}
FACES = {"Tr": ("triangles", 3), "Qd": ("quadrilaterals", 4)}


def rows(path):
    """The words of each line after the first, which says how many there are."""
    try:
        lines = path.read_text().split("\n")
        wanted = int(lines[0].split()[0])
    except (OSError, UnicodeDecodeError, ValueError, IndexError) as error:
        raise Refusal(f"{path}:1: must be the number of lines that follow: {error}") from None
    found = [line.split() for line in lines[1:] if line.strip()]
    if len(found) < wanted:
        raise Refusal(f"{path}:{len(found) + 1}: ends after {len(found)} of {wanted} lines; is it truncated?")
    return found[:wanted]


def table(path, lines, width, kind=float):
    for number, words in enumerate(lines, 2):
        if len(words) < width:
            raise Refusal(f"{path}:{number}: {len(words)} numbers, where {width} must be")
    try:
        return np.array([words[:width] for words in lines], dtype=kind).reshape(-1, width)
    except (ValueError, OverflowError) as error:
        raise Refusal(f"{path}: {error}") from None


def elements(path, known, n_points):
    """{kind: (corners, tags)} of a file of elements, and where each stood."""
    found, where = {}, {}
    lines = rows(path)
    for word, block in itertools.groupby(sorted(range(len(lines)), key=lambda i: lines[i][0]), lambda i: lines[i][0]):
        if word not in known:
            raise Refusal(f"{path}: elements '{word}' are not read; {', '.join(known)} are")
        kind, width = known[word]
        block = list(block)
        corners = table(path, [lines[i][1:] for i in block], width, np.int64)
        if corners.min(initial=0) < 0 or corners.max(initial=0) >= n_points:
            raise Refusal(f"{path}: an element has node {corners.max()} of {n_points}")
        tags = [int(lines[i][1 + width]) if len(lines[i]) > 1 + width else 0 for i in block]
        found[kind], where[kind] = (corners, np.array(tags)), np.array(block)
    return found, where


def read(path):
    stem = path.with_suffix("")
    points = table(stem.with_suffix(".pts"), rows(stem.with_suffix(".pts")), 3)
    found, where = elements(stem.with_suffix(".elem"), CELLS, len(points))
    ids = np.unique(np.concatenate([tags for _, tags in found.values()]))
    mesh = Foreign(str(stem.with_suffix(".elem")), points, {kind: corners for kind, (corners, _) in found.items()},
                   {kind: np.searchsorted(ids, tags) for kind, (_, tags) in found.items()},
                   [f"region_{i}" for i in ids], unit="um")
    for file in sorted(path.parent.glob(stem.name + "*.surf")):
        name = file.stem[len(stem.name):].strip("._-") or file.stem
        for corners, _ in elements(file, FACES, len(points))[0].values():
            mesh.surfaces.append(Surface(name, corners))
    if stem.with_suffix(".lon").is_file() and len(found) == 1:
        read_fibres(mesh, stem.with_suffix(".lon"), next(iter(where.values())))
    return mesh


def read_fibres(mesh, path, order):
    """The first line says whether there are fibres (1), or fibres and sheets (2); a line for each element follows."""
    lines = [line.split() for line in path.read_text().split("\n") if line.strip()]
    if not lines or lines[0] not in (["1"], ["2"]):
        raise Refusal(f"{path}:1: must be 1 (fibres) or 2 (fibres and sheets)")
    width = 3 * int(lines[0][0])
    values = table(path, lines[1:], width)
    if len(values) != len(order):
        raise Refusal(f"{path}: {len(values)} lines of fibres for {len(order)} elements")
    mesh.cell_fields["fibre"] = values[order, :3]
    if width == 6:
        mesh.cell_fields["sheet"] = values[order, 3:]
