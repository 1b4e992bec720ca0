"""Exact solutions that runs are compared with. SI units."""
from math import factorial

import numpy as np


def shell_stresses(radial, hoop, mu, kappa):
    """First Piola-Kirchhoff stresses dW/d(stretch), radial and in each of the two hoop directions, of
    W = mu/2 (J^(-2/3) I1 - 3) + kappa/4 ((J - 1)^2 + ln^2 J)."""
    volume = radial * hoop**2
    square = radial**2 + 2 * hoop**2
    pressure = kappa / 2 * (volume - 1 + np.log(volume) / volume) * volume
    return [(mu * volume ** (-2 / 3) * (stretch**2 - square / 3) + pressure) / stretch for stretch in (radial, hoop)]


def shell_end(inner, pressure, mu, kappa, a, b, steps=100):
    """(radial stress at b, r(b)) of a shell at rest from a to b whose inner surface is at r(a) = inner under pressure:
    P' = -2 (P - P_hoop)/R, r' = the radial stretch that has the stress P, by the midpoint rule."""
    def slopes(radius, r, stress):
        radial, hoop = (radius / r) ** 2, r / radius
        for _ in range(6):
            value = shell_stresses(radial, hoop, mu, kappa)[0]
            rate = (shell_stresses(radial + 1e-7, hoop, mu, kappa)[0] - value) / 1e-7
            radial -= (value - stress) / rate
        return radial, -2 / radius * (stress - shell_stresses(radial, hoop, mu, kappa)[1])

    h, r, stress = (b - a) / steps, inner, -pressure * (inner / a) ** 2
    for k in range(steps):
        dr, ds = slopes(a + k * h, r, stress)
        dr, ds = slopes(a + (k + 0.5) * h, r + h / 2 * dr, stress + h / 2 * ds)
        r, stress = r + h * dr, stress + h * ds
    return stress, r


def shell_displacements(pressure, mu, kappa, a, b):
    """How far the inner and the outer surface of a compressible neo-Hookean shell move [m], on the branch that begins at
    rest: the ordinary differential equation of its spherical symmetry, by shooting."""
    low, high = a, 1.5 * a
    for _ in range(40):
        inner = (low + high) / 2
        low, high = (inner, high) if shell_end(inner, pressure, mu, kappa, a, b)[0] < 0 else (low, inner)
    return low - a, shell_end(low, pressure, mu, kappa, a, b)[1] - b


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
