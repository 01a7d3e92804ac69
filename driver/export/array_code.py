# A reduced body in plain array code, written by `thrum export --@BACKEND@`; its coefficients are in @NPZ@ beside it.
#
#   V(q) = 1/2 sum omega_i^2 q_i^2 + cubic + quartic terms, exact for a St. Venant-Kirchhoff material
#   q'' + D q' + R(q) = f,   R the gradient of V,   u = U q the displacement of the vertices
#
# q [m kg^1/2], p = dq/dt, f [N kg^-1/2]; the basis is mass-orthonormal. All functions take any leading axes: q of shape
# (..., r) is a batch of bodies. SI units. Nothing here is specific to one body but the arrays of the file.
@IMPORT@
import os as _os

import numpy as _np

with _np.load(_os.path.join(_os.path.dirname(_os.path.abspath(__file__)), "@NPZ@")) as _archive:
    _file = dict(_archive)
_omega2 = _file["omega2"]
RANK = len(_omega2)

# --- the coefficients as two matrices ----------------------------------------------------------------------------------
# The second derivative of V is linear in q and in the products m of pairs of coordinates:
#   T_ab = omega_a^2 delta_ab + (S3' q + S4' m)_ab,   m = (q_k q_l for k <= l),   one column for each pair a <= b
# and as its terms are homogeneous, R = omega^2 q + (S3' q)/2 q + (S4' m)/3 q, and V likewise with 1/6 and 1/12.
_first, _second = _np.triu_indices(RANK)
_square = _np.zeros((RANK, RANK), int)
_square[_first, _second] = _square[_second, _first] = _np.arange(len(_first))


def _second_derivatives():
    # the indices of the coefficients in the order of the file: blocks over j, rows i <= j, columns (k) or (k, l) from j on
    cubic, quartic = [], []
    for j in range(RANK):
        i = _np.arange(j + 1)
        k, l = _np.triu_indices(RANK - j)
        cubic.append(_np.stack(_np.broadcast_arrays(i[:, None], j, _np.arange(j, RANK)), -1).reshape(-1, 3))
        quartic.append(_np.stack(_np.broadcast_arrays(i[:, None], j, k + j, l + j), -1).reshape(-1, 4))
    cubic, quartic = _np.concatenate(cubic), _np.concatenate(quartic)

    # deriving by two of the factors leaves the others; a square gives its factor of two
    s3, s4 = _np.zeros((RANK, len(_first))), _np.zeros((len(_first), len(_first)))
    for x, y, rest in ((0, 1, 2), (0, 2, 1), (1, 2, 0)):
        a, b = cubic[:, x], cubic[:, y]
        _np.add.at(s3, (cubic[:, rest], _square[a, b]), _file["c3"] * _np.where(a == b, 2, 1))
    for x, y, u, v in ((0, 1, 2, 3), (0, 2, 1, 3), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 0, 2), (2, 3, 0, 1)):
        a, b = quartic[:, x], quartic[:, y]
        _np.add.at(s4, (_square[quartic[:, u], quartic[:, v]], _square[a, b]), _file["c4"] * _np.where(a == b, 2, 1))
    return s3, s4


_S3, _S4 = (xp.asarray(s) for s in _second_derivatives())
OMEGA2 = xp.asarray(_omega2)
_K, _L, _SQUARE, _EYE = xp.asarray(_first), xp.asarray(_second), xp.asarray(_square), xp.asarray(_np.eye(RANK))


def _parts(q):
    """The linear and the quadratic part of the second derivative, (..., r, r)."""
    return (q @ _S3)[..., _SQUARE], ((q[..., _K] * q[..., _L]) @ _S4)[..., _SQUARE]


def _times(matrix, q):
    return (matrix * q[..., None, :]).sum(-1)


def energy(q):
    """Strain energy V [J], shape (...)."""
    linear, quadratic = _parts(q)
    return (q * (0.5 * OMEGA2 * q + _times(linear / 6 + quadratic / 12, q))).sum(-1)


def force(q):
    """Internal force R, the gradient of V, (..., r)."""
    linear, quadratic = _parts(q)
    return OMEGA2 * q + _times(linear / 2 + quadratic / 3, q)


def tangent(q):
    """Tangent stiffness T, the second derivative of V, (..., r, r)."""
    linear, quadratic = _parts(q)
    return OMEGA2 * _EYE + linear + quadratic


def total_energy(q, p):
    """Kinetic and strain energy [J]."""
    return 0.5 * (p * p).sum(-1) + energy(q)


# --- the mesh ----------------------------------------------------------------------------------------------------------
_ends = _file["group_ends"] if "group_ends" in _file else _np.zeros(0, int)
_names = bytes(_file["group_names"]).decode().split("\0")[:-1] if "group_names" in _file else []
GROUPS = {name: _file["group_vertices"][start:end] for name, start, end in zip(_names, [0, *_ends[:-1]], _ends)}
VERTICES = _file["vertices"] if "vertices" in _file else _np.zeros((0, 3))
_basis = _file["basis"].reshape(-1, 3, RANK) if "basis" in _file else _np.zeros((0, 3, RANK))


def _rows(where):
    """The rows of U of vertices, or of a named group: (count, 3, r)."""
    return xp.asarray(_basis[GROUPS[where] if isinstance(where, str) else _np.atleast_1d(where)])


def displacement(q, where):
    """Displacement [m] of vertices (numbers from 0) or of a group by its name: (..., count, 3)."""
    return (_rows(where) * q[..., None, None, :]).sum(-1)


def point_force(where, newtons):
    """The reduced load f of a force [N], a list of three, that the vertices named share evenly: (r,)."""
    rows = _rows(where)
    return (rows.sum(0) * xp.asarray(_np.asarray(newtons, float))[:, None]).sum(0) / rows.shape[0]


def gravity(acceleration):
    """The reduced load of an acceleration [m/s^2], a list of three: (r,)."""
    return (xp.asarray(_file["axis_mass"]) * xp.asarray(_np.asarray(acceleration, float))[:, None]).sum(0)


# --- steps -------------------------------------------------------------------------------------------------------------
def _solve(residual, jacobian, d, iterations):
    for _ in range(iterations):
        d = d - xp.linalg.solve(jacobian(d), residual(d)[..., None])[..., 0]
    return d


def step_midpoint(q, p, f, h, alpha=0.0, beta=0.0, iterations=6):
    """One step of h [s] by the implicit midpoint rule, with damping D = alpha + beta omega^2; returns q, p."""
    damping = alpha + beta * OMEGA2
    d = _solve(lambda d: d - h * p + 0.5 * h * h * (force(q + 0.5 * d) + damping * d / h - f),
               lambda d: (1 + 0.5 * h * damping) * _EYE + 0.25 * h * h * tangent(q + 0.5 * d), h * p, iterations)
    return q + d, 2 * d / h - p


def _own_steps():
    """Modes that are stepped at their own frequency: all but those that follow the square of a much softer one."""
    row = _np.arange(RANK)
    coupling = _np.zeros((RANK, RANK))  # of j, j, s
    diagonal = _np.zeros(RANK)
    s3, s4 = _np.asarray(_S3), _np.asarray(_S4)
    coupling[:] = s3[:, _square[row, row]].T / 2
    diagonal[:] = s4[_square[row, row], _square[row, row]] / 12
    follows = coupling**2 / (2 * _np.maximum(_omega2, 1e-300)) > 0.15 * diagonal[:, None]
    softer = _np.sqrt(_omega2)[:, None] < _np.sqrt(_omega2) / 3
    return ~(follows & softer).any(0)


_OWN = xp.asarray(_own_steps())


def step_energy(q, p, f, h, alpha=0.0, beta=0.0, iterations=6, matched=True):
    """One step of h [s] that conserves the energy (trapezoidal discrete gradient); returns q, p.

    With `matched` the modes below omega h = 1 are stepped at their own frequency.
    """
    # the length of the step of each mode, and the weight of its velocity in the middle
    x = 0.5 * h * xp.sqrt(OMEGA2)
    own = _OWN & (2 * x <= 1) & (x > 0) if matched else x < 0
    safe = xp.where(own, x, xp.ones_like(x))
    delta = xp.where(own, h * xp.tan(safe) / safe, h * xp.ones_like(x))
    weight = xp.where(own, safe / xp.sin(safe), xp.ones_like(x))
    damping = (alpha + beta * OMEGA2) * weight * weight / h

    # sigma makes the mean of both end forces a discrete gradient: R_mean . d = V(q + d) - V(q)
    start, stiff = force(q), tangent(q)

    def mean_force(d):
        end = tangent(q + d)
        square = (d * d).sum(-1)[..., None] + 1e-300
        sigma = -(d * _times(end - stiff, d)).sum(-1)[..., None] / (12 * square)
        slope = (0.5 * (force(q + d) - start) - 0.5 * _times(end, d) - 2 * sigma * d) / square
        return 0.5 * (start + force(q + d)) + sigma * d, end, sigma, slope

    def residual(d):
        return d - delta * p + 0.5 * delta * delta * (mean_force(d)[0] + damping * d - f)

    def jacobian(d):
        _, end, sigma, slope = mean_force(d)
        inner = 0.5 * end + (sigma[..., None] + damping) * _EYE + d[..., :, None] * slope[..., None, :]
        return _EYE + (0.5 * delta * delta)[:, None] * inner

    d = _solve(residual, jacobian, delta * p, iterations)
    return q + d, 2 * d / delta - p
