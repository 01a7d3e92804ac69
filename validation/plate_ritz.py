#!/usr/bin/env python3
"""Backbone of a clamped square plate by Ritz's method: what `docs/verification.md` compares with.

usage: plate_ritz.py [--bending M] [--stretching P] [--modes K]

Von Karman's plate of side 1 with immovable edges, nu 0.3. The deflection consists of (1 - x^2)^2 (1 - y^2)^2 times M x M even Legendre
polynomials, the displacements in the plane of (1 - x^2) (1 - y^2) times P x P. What stretches has no inertia and follows, which leaves
a quartic of the first K modes of bending. Its free motion is found by harmonic balance with harmonics 1, 3 and 5. Printed are the
frequency parameter omega a^2 sqrt(rho h / D) at rest, 35.985, and the frequency over that at rest where the middle swings by w.

SPDX-License-Identifier: Apache-2.0
"""
import argparse
import itertools

import numpy as np
from numpy.polynomial import legendre, polynomial
from scipy.linalg import eigh
from scipy.optimize import fsolve

NU, THICKNESS = 0.3, 0.01
HARMONICS, SAMPLES, POINTS = (1, 3, 5), 24, 40
STRETCHING = THICKNESS / (1 - NU**2)
BENDING = THICKNESS**3 / 12 / (1 - NU**2)
PLACES, WEIGHTS = legendre.leggauss(POINTS)


def shape(clamped, degree):
    """A polynomial on (-1, 1) that is held at both ends, and there level where it is clamped."""
    return polynomial.polymul([1, 0, -2, 0, 1] if clamped else [1, 0, -1], legendre.leg2poly([0] * degree + [1]))


def fields(along, across, along_order=0, across_order=0):
    """Products of two lists of polynomials at the points, with so many derivatives by x and y on the unit square."""
    rows = [[2**order * polynomial.polyval(PLACES, polynomial.polyder(c, order)) for c in given]
            for given, order in ((along, along_order), (across, across_order))]
    return np.array([np.outer(a, b) for a in rows[0] for b in rows[1]])


def product(first, second):
    """Integrals over the plate of all products of two lists of fields."""
    return np.einsum("axy,bxy,xy->ab", first, second, np.outer(WEIGHTS, WEIGHTS) / 4, optimize=True)


def stretch(first, second):
    """The energy product of two lists of strains in the plane, x, y and shear."""
    (ax, ay, ag), (bx, by, bg) = first, second
    return STRETCHING * (product(ax, bx) + product(ay, by) + NU * (product(ax, by) + product(ay, bx)) + (1 - NU) / 2 * product(ag, bg))


def reduce(bending, stretching, modes):
    """Frequencies of the first modes, the symmetric quartic of their energy, and what the middle moves in each."""
    w = [shape(True, 2 * m) for m in range(bending)]
    xx, yy, xy = fields(w, w, 2, 0), fields(w, w, 0, 2), fields(w, w, 1, 1)
    stiffness = BENDING * (product(xx, xx) + product(yy, yy) + NU * (product(xx, yy) + product(yy, xx)) + 2 * (1 - NU) * product(xy, xy))
    square, vectors = eigh(stiffness, THICKNESS * product(fields(w, w), fields(w, w)))
    vectors = vectors[:, :modes]

    # displacements in the plane, odd along their own axis
    odd = [shape(False, 2 * m + 1) for m in range(stretching)]
    even = [shape(False, 2 * m) for m in range(stretching)]
    none = np.zeros_like(fields(odd, even))
    linear = (np.concatenate([fields(odd, even, 1, 0), none]), np.concatenate([none, fields(even, odd, 0, 1)]),
              np.concatenate([fields(odd, even, 0, 1), fields(even, odd, 1, 0)]))

    # the strains of bending, quadratic in the modes, and what of them is left when the plane follows
    slope_x = np.einsum("axy,ak->kxy", fields(w, w, 1, 0), vectors)
    slope_y = np.einsum("axy,ak->kxy", fields(w, w, 0, 1), vectors)
    pairs = list(itertools.product(range(modes), repeat=2))
    squares = (np.array([slope_x[i] * slope_x[j] / 2 for i, j in pairs]), np.array([slope_y[i] * slope_y[j] / 2 for i, j in pairs]),
               np.array([(slope_x[i] * slope_y[j] + slope_y[i] * slope_x[j]) / 2 for i, j in pairs]))
    mixed = stretch(linear, squares)
    left = stretch(squares, squares) - mixed.T @ np.linalg.solve(stretch(linear, linear), mixed)
    tensor = left.reshape((modes,) * 4)
    tensor = sum(np.transpose(tensor, order) for order in itertools.permutations(range(4))) / 24
    at_middle = np.array([polynomial.polyval(0.0, a) * polynomial.polyval(0.0, b) for a in w for b in w]) @ vectors
    return np.sqrt(square[:modes]), tensor, at_middle


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--bending", type=int, default=5)
    parser.add_argument("--stretching", type=int, default=8)
    parser.add_argument("--modes", type=int, default=9)
    asked = parser.parse_args()
    omega, tensor, at_middle = reduce(asked.bending, asked.stretching, asked.modes)
    print(f"omega a^2 sqrt(rho h / D) = {omega[0] * np.sqrt(THICKNESS / BENDING):.4f}")
    waves = np.cos(2 * np.pi / SAMPLES * np.outer(HARMONICS, np.arange(SAMPLES)))

    def misses(unknowns, width):
        amplitudes = unknowns[:-1].reshape(len(HARMONICS), -1)
        q = waves.T @ amplitudes
        force = omega**2 * q + 2 * np.einsum("ijkl,sj,sk,sl->si", tensor, q, q, q, optimize=True)
        inertia = np.array([(k * unknowns[-1] * omega[0])**2 * a for k, a in zip(HARMONICS, amplitudes)])
        balance = (2 / SAMPLES * waves @ force - inertia) / omega**2
        return np.append(balance.ravel(), amplitudes.sum(0) @ at_middle - width) / THICKNESS

    # in small steps from rest
    unknowns = np.zeros(len(HARMONICS) * asked.modes + 1)
    unknowns[0], unknowns[-1] = 0.01 * THICKNESS / at_middle[0], 1.001
    for step in range(1, 51):
        unknowns = fsolve(misses, unknowns, args=(step / 50 * THICKNESS,), xtol=1e-11)
        if step % 10 == 0:
            print(f"w/h = {step / 50:.1f}  omega/omega_1 = {unknowns[-1]:.5f}")


if __name__ == "__main__":
    main()
