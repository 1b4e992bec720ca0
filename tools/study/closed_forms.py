"""Limits of alpha [kg/(m^2 s)] in closed form, from a scene alone; None where there is none."""
import numpy as np

from .scene import lay_over, quantity

NAMES = {"impedance": "limit by the wall's impedance", "piston": "closed form", "tube": "closed form (thin wall, ideal fluid)"}


def piston(tree, defaults):
    """The piston's column in uniaxial strain, against a closed box of blood: 2 Z(dt/2) of the loosely coupled scheme, whose
    unstable mode alternates, and 2 Z(dt) of iterations as well; Z(dt) is the column's impedance within a step of dt. The
    corrected scheme keeps the volume, so uniform motion sets no limit."""
    scene = lay_over(defaults, tree)
    coupling, step = scene["coupling"], quantity(scene["time"]["step"])
    if coupling["scheme"] == "EFS1":
        return 2 * column_impedance(scene, step / 2)
    if coupling["scheme"] == "E1FS" and int(coupling["iterations"]) > 1:
        return 2 * min(column_impedance(scene, step), column_impedance(scene, step / 2))
    return None


def column_impedance(scene, step):
    """Traction per velocity at the interface within one implicit step: linear elements with consistent mass."""
    shape, mechanics = scene["geometry"]["piston"], scene["mechanics"]
    n, h = int(shape["cells_column"]) + 1, quantity(shape["column"]) / int(shape["cells_column"])
    law, far = mechanics["neo_hookean"], mechanics["pericardium"]
    modulus = quantity(law["kappa"]) + 4 / 3 * quantity(law["mu"])
    mass, stiffness, damping = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    for e in range(n - 1):
        mass[e:e + 2, e:e + 2] += quantity(mechanics["density"]) * h / 6 * np.array([[2, 1], [1, 2]])
        stiffness[e:e + 2, e:e + 2] += modulus / h * np.array([[1, -1], [-1, 1]])
    stiffness[-1, -1] += quantity(far["K_perp"])
    damping[-1, -1] += quantity(far["C_perp"])
    return step / np.linalg.inv(mass / step**2 + damping / step + stiffness)[0, 0]


def tube(tree, defaults):
    """EFS1 on an elastic tube with open ends, thin wall and ideal fluid. The model problem of Causin, Gerbeau and Nobile
    (2005, doi:10.1016/j.cma.2004.12.005) has, for the motion of amplification -1, with the wall's mass m_s and stiffness
    beta per area, the blood's added mass m_a, r = m_a/m_s and b = beta dt^2/m_s, the limit

        m_a/dt 4 (4 + b) / (4 (r - 1) - b);        none when the denominator is not positive: then every alpha is stable.

    The longest wave has the largest m_a = rho I0(k R) / (k I1(k R)), k = pi/L, and the lowest limit."""
    scene = lay_over(defaults, tree)
    if scene["coupling"]["scheme"] != "EFS1":
        return None
    shape, step = scene["geometry"]["tube"], quantity(scene["time"]["step"])
    length, radius, wall = (quantity(shape[key]) for key in ("length", "radius", "wall"))
    modulus, ratio = young_and_poisson(scene["mechanics"])
    mass, stiffness = quantity(scene["mechanics"]["density"]) * wall, modulus * wall / (1 - ratio**2) / radius**2
    k = np.pi / length
    added = quantity(scene["fluid"]["density"]) * np.i0(k * radius) / (k * bessel_i1(k * radius))
    b = stiffness * step**2 / mass
    denominator = 4 * (added / mass - 1) - b
    return added / step * 4 * (4 + b) / denominator if denominator > 0 else None


def bessel_i1(x):
    """I1 = (1/pi) int_0^pi exp(x cos t) cos t dt, by the midpoint rule, which is exact to round-off here."""
    t = np.pi * (np.arange(64) + 0.5) / 64
    return np.mean(np.exp(x * np.cos(t)) * np.cos(t))


def young_and_poisson(mechanics):
    """Of the neo-Hookean law for small strains."""
    mu, kappa = quantity(mechanics["neo_hookean"]["mu"]), quantity(mechanics["neo_hookean"]["kappa"])
    return 9 * kappa * mu / (3 * kappa + mu), (3 * kappa - 2 * mu) / (2 * (3 * kappa + mu))


FORMS = {"piston": piston, "tube": tube}
