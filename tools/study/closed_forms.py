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


FORMS = {"piston": piston}
