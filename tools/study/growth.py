"""Whether a signal of the coupling grows from step to step: a rate with its uncertainty, and numbers with their digits.

Behind a decaying transient a slowly growing mode is small for long: the fit is over the last half of the signal, and over
its last quarter alone where that is steeper by more than chance. What is steady to within the fit's uncertainty is called
undecided, unless it has fallen to a small share of what it was: such a floor is solver tolerance or slow motion, not growth.
"""
import math
from dataclasses import dataclass

import numpy as np

SIGNIFICANT = 3.  # standard deviations of a slope
FALLEN = 0.1  # share of its first quarter at which a steady signal is a floor
BLOCK = 5  # steps, the largest of which counts, since signals oscillate
BLOCKS_MIN = 6


@dataclass
class Growth:
    """State of a mode: "stable", "growing" or "undecided"; logarithmic rate per step and its standard deviation, NaN for a
    floor, which has none."""
    state: str
    rate: float = np.nan
    deviation: float = np.nan


def growth(signal):
    """Of a signal, one value a step. A signed one is split into the part that alternates from step to step and the rest, and
    the faster one counts."""
    signal = np.asarray(signal, float)
    signal = signal[np.isfinite(signal)]
    if len(signal) < 4 * BLOCK * BLOCKS_MIN / 2:
        return Growth("undecided")
    if (signal >= 0).all():
        return of_part(signal)
    alternating = np.abs(np.diff(signal, 8)) / 256  # each difference doubles what alternates, and shrinks what is smooth
    parts = [of_part(alternating), of_part(np.abs(signal[1:] + signal[:-1]) / 2)]
    for state in "growing", "undecided":
        found = [part for part in parts if part.state == state]
        if found:
            return max(found, key=lambda part: part.rate)
    return max(parts, key=lambda part: -np.inf if np.isnan(part.rate) else part.rate)


def of_part(part):
    """Growth of the largest values of blocks of steps."""
    n = len(part) // BLOCK
    largest = part[len(part) - n * BLOCK:].reshape(n, BLOCK).max(axis=1)
    logarithm = np.log(np.maximum(largest, 1e-300))
    rate, deviation = slope(logarithm[n // 2:])
    last, its_deviation = slope(logarithm[-max(BLOCKS_MIN, n // 4):])
    before, other_deviation = slope(logarithm[n // 2:-max(1, n // 4)])
    if last - before > SIGNIFICANT * math.hypot(its_deviation, other_deviation):
        rate, deviation = last, its_deviation
    if rate > SIGNIFICANT * deviation:
        return Growth("growing", rate, deviation)
    if rate < -SIGNIFICANT * deviation:
        return Growth("stable", rate, deviation)
    if largest[-1] <= FALLEN * largest[:max(1, n // 4)].max():
        return Growth("stable")
    return Growth("undecided", rate, deviation)


def slope(logarithm):
    """(slope per step, standard deviation) of a line through block values; residuals that hang together count as fewer."""
    n = len(logarithm)
    if n < 3:
        return 0., np.inf
    x = np.arange(n) - (n - 1) / 2
    rate = x @ logarithm / (x @ x)
    rest = logarithm - logarithm.mean() - rate * x
    variance = rest @ rest / (n - 2)
    correlation = np.clip(rest[1:] @ rest[:-1] / max(rest @ rest, 1e-300), 0, 0.9)
    deviation = math.sqrt(variance / (x @ x) * (1 + correlation) / (1 - correlation))
    return float(rate / BLOCK), deviation / BLOCK + 1e-12


def digits(value, uncertainty):
    """"25.1e3 ± 0.4e3": as many digits as the uncertainty leaves, which has one, or two below 2."""
    if not (np.isfinite(value) and np.isfinite(uncertainty)) or uncertainty <= 0:
        return f"{value:.3g}"
    last = math.floor(math.log10(uncertainty))
    last -= uncertainty / 10**last < 1.95
    power = 3 * math.floor(math.log10(max(abs(value), uncertainty)) / 3)
    decimals = max(0, power - last)
    ending = f"e{power}" if power else ""
    rounded = 10.**max(last, power - decimals) if last > power else 1.
    unit = 10.**power
    shown = [round(number / rounded) * rounded / unit if last > power else number / unit for number in (value, uncertainty)]
    return f"{shown[0]:.{decimals}f}{ending} ± {shown[1]:.{decimals}f}{ending}"
