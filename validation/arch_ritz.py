#!/usr/bin/env python3
"""Where a clamped sine arch stops to harden, by Ritz's method: what `docs/verification.md` compares with.

usage: arch_ritz.py [--functions N]

A shallow beam of length 1, clamped at both ends, of the shape a sin(pi x) with a in thicknesses, which stretches: with the lateral
displacement w its energy is (1/2) (1/12) int w''^2 + (1/2) (int a pi cos(pi x) w' + w'^2 / 2)^2, and the axial force has no inertia.
w consists of (1 - x^2)^2 times N Legendre polynomials. Printed is the rise a at which the coefficient c of the normal form
z' = i (omega + c |z|^2) z of the first mode is zero, of that mode alone and with all modes, which follow it at twice its frequency and
at none. Each of them softens by a square, so none can put that rise above that of one mode.

SPDX-License-Identifier: Apache-2.0
"""
import argparse

import numpy as np
from numpy.polynomial import legendre, polynomial
from scipy.linalg import eigh
from scipy.optimize import brentq

PLACES, WEIGHTS = legendre.leggauss(80)


def coefficient(rise, functions, alone):
    """c times 2 omega of the first mode."""
    shapes = [polynomial.polymul([1, 0, -2, 0, 1], legendre.leg2poly([0] * k + [1])) for k in range(functions)]
    value, slope, bend = (np.array([2**n * polynomial.polyval(PLACES, polynomial.polyder(c, n)) for c in shapes]) for n in range(3))
    weights = WEIGHTS / 2
    along = slope @ (weights * rise * np.pi * np.cos(np.pi * (PLACES + 1) / 2))
    square, modes = eigh(bend * weights @ bend.T / 12 + np.outer(along, along), value * weights @ value.T)
    along, stretch = modes.T @ along, modes.T @ (slope * weights @ slope.T) @ modes

    def force(p, q):
        """The quadratic force, as a symmetric bilinear form."""
        return (along * (p @ stretch @ q) + (along @ p) * (stretch @ q) + (along @ q) * (stretch @ p)) / 2

    first = np.eye(functions)[0]
    shown = first if alone else np.ones(functions)
    quadratic = force(first, first)
    at_twice, at_none = -shown * quadratic / (square - 4 * square[0]), -2 * shown * quadratic / square
    return 1.5 * stretch[0, 0]**2 + 2 * force(first, at_none)[0] + 2 * force(first, at_twice)[0]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--functions", type=int, default=14)
    functions = parser.parse_args().functions
    for name, alone in (("first mode alone", True), ("all modes", False)):
        print(f"{name:17s} {brentq(coefficient, 0.3, 0.6, args=(functions, alone)):.6f}")


if __name__ == "__main__":
    main()
