"""What is implausible in a finished run, each with the key of the scene that would change it. Only from what a run leaves:
history.csv, indicators.json, the scene."""
from dataclasses import dataclass

import numpy as np

from results import ML, quantity

# Limits, and where they come from.
J_MIN = 0.7              # a cell squeezed to less has left the range of the constitutive laws, which are of nearly
                         # incompressible tissue
WALL_CHANGE = 0.03       # share; blood squeezed out of the coronary vessels is 2 to 4 % of the wall in a beat
                         # (Yin, Chan, Judd, Am. J. Physiol. 271 (1996) H1864)
CLAMPED = 0.05           # share of the nodes
NEAR_LIMIT = 0.9         # of what the coupling bears
MESH_J = 0.2             # a cell of the fluid's mesh squeezed to a fifth is near to being inverted
LOSS = 5.0               # percent of the volume; the paper's EFS1 loses 3.5 and 3.7
DISAGREEMENT = 0.02      # of the largest pressure, or of 1 kPa where that is less, in
STEPS_IN_A_ROW = 6       # as many as the fluid solver's watch looks at
PERIODIC = 2.0           # percent
STALLED = 0.1            # s without another node activated: a front passes even a coarse cell in a tenth of that


@dataclass
class Finding:
    what: str
    key: str   # of the scene
    hint: str  # what about it

    def __str__(self):
        return f"{self.what}; {self.key}: {self.hint}"


def complete_beats(run):
    return [beat for beat in run.indicators.get("beats", []) if beat.get("complete")]


def which(run, beat):
    """Names a beat where there are several."""
    return f" in beat {beat['beat']}" if len(run.indicators.get("beats", [])) > 1 else ""


def has_stalled(run, rows):
    """Whether activation has come to rest in a beat that has not ended: since the beginning, or since the last node."""
    time, share = run.history.time[rows], run.history["activated_share"][rows]
    grown = np.flatnonzero(np.diff(share) > 0)
    return time[-1] - time[grown[-1] + 1 if len(grown) else 0] >= STALLED


def activation(run):
    if "activated_share" not in run.history:
        return
    for beat, rows in run.beats():
        share = beat.get("activated_percent")
        if share is None or not (beat.get("complete") or has_stalled(run, rows)):
            continue
        if share == 0:
            yield Finding(f"no point of the wall is activated{which(run, beat)}", "electrophysiology.stimulus",
                          "does a site reach tissue, is it two cells wide, is the amplitude large enough?")
        else:
            yield Finding(f"only {share:.1f} % of the wall is activated{which(run, beat)}",
                          "electrophysiology.refinements",
                          "on coarse tissue the front is blocked; or more conductivity, more stimulus.sites")


def valves(run):
    if "phase" not in run.history:
        return
    for beat in complete_beats(run):
        if "aortic_opens_ms" not in beat:
            yield Finding(f"the aortic valve never opens{which(run, beat)}: largest mean pressure "
                          f"{beat.get('p_max_mmHg', 0):.1f} mmHg", "mechanics.active.tension_max",
                          f"the wall does not reach fluid.aortic_pressure ({run.scene.get('fluid.aortic_pressure', '?')})")
        elif "mitral_opens_ms" not in beat:
            yield Finding(f"the mitral valve never opens{which(run, beat)}", "fluid.mitral_pressure",
                          "the pressure does not fall below it: does the wall relax, is the beat long enough?")


def law(run):
    return run.scene.get("mechanics.law", "guccione")


def crushed_cells(run):
    if "min_J" in run.history and (least := run.history["min_J"].min()) < J_MIN:
        at = run.milliseconds[np.argmin(run.history["min_J"])]
        kappa = run.scene.get(f"mechanics.{law(run)}.kappa", "?")
        yield Finding(f"a cell of the wall is squeezed to {100 * least:.0f} % of its volume (J {least:.3f}, at {at:.0f} ms)",
                      f"mechanics.{law(run)}.kappa", f"{kappa} resists too little; or less mechanics.active.tension_max")


def wall_volume(run):
    if "wall_volume" not in run.history:
        return
    volume = run.history["wall_volume"]
    worst = volume[np.argmax(abs(volume - 1))]
    if abs(worst - 1) > WALL_CHANGE:
        kappa = run.scene.get(f"mechanics.{law(run)}.kappa", "?")
        yield Finding(f"the wall's volume changes by {100 * (worst - 1):+.1f} %; muscle keeps its own within 3 %",
                      f"mechanics.{law(run)}.kappa", f"{kappa} is a soft bulk")


def sarcomeres(run):
    if "clamped_share" in run.history and (most := run.history["clamped_share"].max()) > CLAMPED:
        at = run.milliseconds[np.argmax(run.history["clamped_share"])]
        yield Finding(f"{100 * most:.0f} % of the wall's sarcomeres are out of the force model's range (1.7 to 2.3 um, at "
                      f"{at:.0f} ms)", "mechanics.active.sarcomere_length",
                      f"{run.scene.get('mechanics.active.sarcomere_length', '?')} at rest; or less shortening by tension_max")


def alpha(run):
    if not ("alpha" in run.history and "alpha_limit" in run.history):
        return
    used, limit = run.history["alpha"], run.history["alpha_limit"]
    known = limit > 0
    if known.any() and (used[known] > NEAR_LIMIT * limit[known]).any():
        k = np.argmax(np.where(known, used / np.where(known, limit, 1), 0))
        yield Finding(f"alpha is {used[k]:.0f} kg/(m^2 s) where the coupling bears {limit[k]:.0f}, at "
                      f"{run.milliseconds[k]:.0f} ms", "coupling.alpha", "'auto' keeps to four fifths of the limit")


def mesh_quality(run):
    if "mesh_min_J" in run.history and (least := run.history["mesh_min_J"].min()) < MESH_J:
        at = run.milliseconds[np.argmin(run.history["mesh_min_J"])]
        yield Finding(f"a cell of the fluid's mesh is squeezed to {100 * least:.0f} % of its volume, at {at:.0f} ms",
                      "geometry", "another mesh, or a smaller motion: the lifting is near to inverting cells")


def disagreement(run):
    for beat in complete_beats(run):
        for key, name in (("ILI_C_percent", "contraction"), ("ILI_R_percent", "relaxation")):
            if beat.get(key, 0) > LOSS:
                yield Finding(f"{beat[key]:.1f} % of the blood's volume is lost in isovolumetric {name}{which(run, beat)}",
                              "coupling.alpha", "the larger the less is lost; or coupling.scheme: EFS1-corrected, E1FS")
    if "disagreement" in run.history and "mean_pressure" in run.history:
        largest = abs(run.history["mean_pressure"]).max()
        large = run.history["disagreement"] > DISAGREEMENT * max(largest, 1e3)
        if longest_stretch(large) >= STEPS_IN_A_ROW:
            k = np.argmax(run.history["disagreement"])
            yield Finding(f"blood and wall disagree by up to {run.history['disagreement'][k]:.0f} Pa, at "
                          f"{run.milliseconds[k]:.1f} ms; the largest mean pressure is {largest:.0f} Pa", "time.step",
                          "a smaller one; or more coupling.iterations of the scheme E1FS")


def longest_stretch(flags):
    longest = current = 0
    for flag in flags:
        current = current + 1 if flag else 0
        longest = max(longest, current)
    return longest


def periodicity(run):
    beats = complete_beats(run)
    if not beats or "phase" not in run.history:
        return
    wanted = max(PERIODIC, 100 * (quantity(run.scene.get("time.until_periodic", 0)) or 0))
    if changes := beats[-1].get("change_percent"):
        name, change = max(changes.items(), key=lambda entry: entry[1])
        if change > wanted:
            yield Finding(f"the last complete beat is not periodic: {name} changes by {change:.1f} %", "time.beats",
                          "more beats, or until_periodic")
        return
    rows = next(rows for beat, rows in run.beats() if beat.get("complete"))
    volume = run.history["volume"][rows] / ML
    change = 100 * abs(volume[-1] / volume[0] - 1)
    if change > wanted:
        yield Finding(f"the beat begins with {volume[0]:.1f} mL and ends with {volume[-1]:.1f} mL", "time.beats",
                      "one beat is not periodic; more of them are")


RULES = (activation, valves, crushed_cells, wall_volume, sarcomeres, alpha, mesh_quality, disagreement, periodicity)


def findings(run):
    return [finding for rule in RULES for finding in rule(run)]
