"""Exact solutions that runs are compared with. SI units."""
from math import factorial

import numpy as np


def shell_pressure(inner_stretch, mu, a, b):
    """Pressure that inflates an incompressible neo-Hookean shell, radii a < b at rest, to r(a) = inner_stretch a: of
    W = mu/2 (I1 - 3), p = mu/2 [4/l + 1/l^4] from l = r(a)/a to r(b)/b (A. E. Green, W. Zerna, Theoretical Elasticity, 1954)."""
    def work(stretch):
        return 4 / stretch + 1 / stretch**4
    return mu / 2 * (work(shell_outer_stretch(inner_stretch, a, b)) - work(inner_stretch))


def shell_outer_stretch(inner_stretch, a, b):
    return (1 + (inner_stretch**3 - 1) * (a / b) ** 3) ** (1 / 3)


def shell_displacements(pressure, mu, a, b):
    """How far the inner and the outer surface move [m], on the branch that begins at rest."""
    low, inner = 1, 1.5
    for _ in range(60):
        middle = (low + inner) / 2
        low, inner = (middle, inner) if shell_pressure(middle, mu, a, b) < pressure else (low, middle)
    return (inner - 1) * a, (shell_outer_stretch(inner, a, b) - 1) * b


def bar_tip(time, length, speed, modulus, traction):
    """Displacement of the pulled end of a bar whose other end is held: with traction(t) = 0 before 0, by d'Alembert,
    u(L, t) = c/E int_0^t (s(q) + 2 sum_n (-1)^n s(q - 2 n L/c)) dq. Small strains."""
    fine = np.linspace(0, time[-1], 20001)
    stress = traction(fine)
    n = 1
    while 2 * n * length / speed < time[-1]:
        stress = stress + 2 * (-1) ** n * traction(fine - 2 * n * length / speed)
        n += 1
    integral = np.concatenate(([0], np.cumsum((stress[1:] + stress[:-1]) / 2 * np.diff(fine))))
    return speed / modulus * np.interp(time, fine, integral)


def bessel(n, z):
    """J_n(z) of a complex z of moderate size, by its power series."""
    return sum((-1) ** k * (z / 2) ** (2 * k + n) / (factorial(k) * factorial(k + n)) for k in range(60))


def womersley_gain(omega, amplitude, length, radius, density, viscosity):
    """The complex amplitude Q of the flow Im[Q e^(i omega t)] through a rigid tube whose inlet is amplitude sin(omega t)
    above its outlet: Q = pi R^2 P / (i rho omega L) (1 - 2 J1(b)/(b J0(b))), b = i^(3/2) R sqrt(rho omega / mu)
    (Womersley 1955, doi 10.1113/jphysiol.1955.sp005276)."""
    b = 1j**1.5 * radius * np.sqrt(density * omega / viscosity)
    return amplitude * np.pi * radius**2 / (1j * density * omega * length) * (1 - 2 * bessel(1, b) / (b * bessel(0, b)))


def phasor(time, values, omega):
    """The complex amplitude Q of values = Im[Q e^(i omega t)] over whole periods."""
    table = np.column_stack([np.sin(omega * time), np.cos(omega * time)])
    real, imaginary = np.linalg.lstsq(table, values, rcond=None)[0]
    return real + 1j * imaginary
