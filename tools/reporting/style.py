"""How all figures look: colours that the colour-blind can tell apart, one for each scheme; sizes; the formats of files."""
import re
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.colors import to_hex, to_rgb

INK, GRID = "#222222", "#d9dee4"
# Okabe and Ito, "Color Universal Design", jfly.uni-koeln.de/color.
PALETTE = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7a5195", "#6b6b6b"]
SCHEMES = {"EFS1": 0, "E1FSinf": 1, "EFS1-corrected": 2, "E1FS2": 3, "E1FS": 3, "adaptive": 4, "by_phase": 5, "E1FS3": 6,
           "one_way": 7, "corrected": 2}
# Name, short name, colour of each phase of the heartbeat, in every picture.
PHASES = {
    "isovolumetric contraction": ("IC", "#f6d9cd"),
    "ejection": ("ejection", "#fbeed0"),
    "isovolumetric relaxation": ("IR", "#d3e5f4"),
    "filling": ("filling", "#e3f1e3"),
    "diastasis": ("diastasis", "#eeeeee"),
}
LINES = ["-", (0, (7, 2)), (0, (4, 2)), (0, (2, 2))]  # of runs in one chart: where they coincide all are seen
FORMATS = ("png", "pdf", "svg")
POWERS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")

plt.rcParams.update({
    "figure.dpi": 100, "savefig.dpi": 200, "font.size": 9, "axes.titlesize": 9, "legend.fontsize": 8, "axes.grid": True,
    "axes.axisbelow": True, "axes.formatter.useoffset": False, "axes.spines.top": False, "axes.spines.right": False, "lines.linewidth": 1.5,
    "legend.frameon": False, "figure.subplot.left": 0.14, "figure.subplot.right": 0.98, "figure.subplot.top": 0.97,
    "axes.prop_cycle": plt.cycler(color=PALETTE), "svg.fonttype": "none", "pdf.fonttype": 42,
    "text.color": INK, "axes.labelcolor": INK, "axes.edgecolor": INK, "xtick.color": INK, "ytick.color": INK,
    "grid.color": GRID, "grid.alpha": 1.0, "svg.hashsalt": "heartbus", "font.family": "sans-serif"})


def colour(i):
    return PALETTE[i % len(PALETTE)]


def tint(shade, n):
    """The n-th lighter tint."""
    rest = 0.55**n
    return to_hex([1 - rest * (1 - part) for part in to_rgb(shade)])


def colours(names):
    """One for each of these names: that of the scheme with which it begins, in lighter tints for others of the same scheme. No
    scheme takes another's colour; where there is but one, all names take what is free."""
    own = [max((each for each in SCHEMES if name.startswith(each)), key=len, default=None) for name in names]
    numbers = [SCHEMES.get(scheme) for scheme in own]
    several = len(set(numbers) - {None}) > 1
    free = [k for k in range(len(PALETTE)) if k not in numbers] or list(range(len(PALETTE)))
    chosen = []
    for i, k in enumerate(numbers):
        before = numbers[:i].count(k)
        if k is None or (before and not several):
            chosen.append(PALETTE[free[0]])
            free = free[1:] or list(range(len(PALETTE)))
        else:
            chosen.append(tint(PALETTE[k], before))
    return chosen


def pretty(unit):
    """A unit as it is printed: kg/(m² s) of 'kg/(m^2 s)'."""
    unit = re.sub(r"\^\((\d+/\d+)\)", r"$^{\1}$", unit)
    return re.sub(r"\^(-?\d+)", lambda found: found[1].translate(POWERS), unit)


def metadata(ending, origin):
    """Of what the picture is, under the name that a file of this kind has for it."""
    return {"png": {"Source": origin}, "pdf": {"Subject": origin}, "svg": {"Source": origin, "Date": None}}[ending]


def save(figure, stem, formats=FORMATS, origin=""):
    """In these formats, with all that lies around the axes; returns the text of the SVG."""
    box = figure.get_tightbbox().padded(0.05)  # once, not for each format; "tight" draws all to find it
    for ending in formats:
        figure.savefig(Path(f"{stem}.{ending}"), bbox_inches=box, transparent=ending == "svg", metadata=metadata(ending, origin))
    return Path(f"{stem}.svg").read_text()


def inline(svg, title):
    """As part of a page that gives the colours: of text the page's own, the others by variables of its style."""
    svg = svg[svg.index("<svg"):]
    names = {INK: "currentColor", GRID: "var(--line)", **{value: f"var(--c{i})" for i, value in enumerate(PALETTE)},
             **{value: f"var(--{short.lower()})" for short, value in PHASES.values()}}
    svg = re.sub("#[0-9a-f]{6}", lambda found: names.get(found[0], found[0]), svg)
    prefix = re.sub(r"\W", "", title)  # names of parts are unique in the page
    svg = re.sub(r'(id="|url\(#|href="#)', rf"\g<1>{prefix}-", svg)
    width, height = re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', svg).groups()
    svg = re.sub(r"<svg [^>]*>", f'<svg viewBox="0 0 {width} {height}" role="img" aria-label="{title}" '
                 'xmlns:xlink="http://www.w3.org/1999/xlink">', svg, count=1)
    return re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.S)
