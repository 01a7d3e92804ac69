#!/usr/bin/env python3
"""`thrum response` beside harmonic balance in numpy, of the same condensed polynomial, in one run.

usage: response_numpy.py THRUM [--masters K] [--whole] [--harmonics H] [--repeat N]

A clamped panel is precomputed with all derivatives of K modes and condensed to them. Both follow its forced curve through two
folds by arc length, with the stability of each point, without the inertia of what follows, which numpy's has not; with --whole
all coordinates move. numpy's is
written as its users write it: tensors by einsum, Newton's method with a Jacobian from sampled tangents, and the monodromy matrix
by implicit midpoint steps. Printed are seconds of processor time, the fastest of N runs, and the folds of each. Of thrum that is
the time of the whole command less that of a curve of two points; neither writes files.

SPDX-License-Identifier: Apache-2.0
"""
import argparse
import itertools
import json
import math
import os
import resource
import subprocess
import tempfile
import time

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # read as numpy is imported; thrum inherits it
import numpy as np  # noqa: E402

PANEL = ["beam:12x1x10@0.4x0.003x0.3", "--order", "2", "--fix", "x<1e-6", "--fix", "x>0.399999", "--fix", "z<-0.149999",
         "--fix", "z>0.149999", "--young", "70e9", "--poisson", "0.33", "--density", "2700"]
RATIO, FROM, TO, STEPS = 0.005, 220.0, 300.0, 48
LONGEST = 0.0125 # step of both along the curve: so many points that starting a process is little beside them


def derivatives(values, rank, order):
    """The symmetric tensor of derivatives of sum c q_i q_j .., i <= j <= .., from the coefficients in their block order."""
    tensor, at = np.zeros((rank,) * order), 0
    for j in range(rank):
        tails = [(k,) for k in range(j, rank)] if order == 3 else [(k, l) for k in range(j, rank) for l in range(k, rank)]
        for i in range(j + 1):
            for tail in tails:
                index = (i, j, *tail)
                repeated = math.prod(math.factorial(index.count(n)) for n in set(index))
                for place in set(itertools.permutations(index)):
                    tensor[place] = values[at] * repeated
                at += 1
    return tensor


class Balance:
    """Harmonic balance of q'' + D q' + R(q) = f sin(Omega t)."""

    def __init__(self, force, tangent, damping, sine, harmonics):
        self.force, self.tangent, self.damping, self.sine = force, tangent, damping, sine
        self.r, self.h = len(damping), harmonics
        count = 4 * harmonics + 1
        angles = 2 * np.pi * np.arange(count) / count
        k = np.arange(1, harmonics + 1)
        self.basis = np.hstack([np.ones((count, 1)), np.cos(np.outer(angles, k)), np.sin(np.outer(angles, k))])
        self.project = 2 * self.basis.T / count
        self.project[0] /= 2
        n = 2 * harmonics + 1
        self.first, self.second = np.zeros((n, n)), np.zeros((n, n))
        for i in k:
            self.first[i, harmonics + i], self.first[harmonics + i, i] = i, -i
        self.second = self.first @ self.first

    def residual(self, x, omega):
        z = x.reshape(-1, self.r)
        q = self.basis @ z
        out = self.project @ self.force(q) + omega**2 * self.second @ z + omega * self.first @ z * self.damping
        out[self.h + 1] -= self.sine
        return out.ravel()

    def jacobian(self, x, omega):
        z = x.reshape(-1, self.r)
        t = self.tangent(self.basis @ z)
        n = len(x)
        jacobian = np.einsum("ps,sij,sk->pikj", self.project, t, self.basis, optimize=True).reshape(n, n)
        jacobian += np.kron(omega**2 * self.second, np.eye(self.r)) + np.kron(omega * self.first, np.diag(self.damping))
        by_omega = 2 * omega * self.second @ z + self.first @ z * self.damping
        return jacobian, by_omega.ravel()

    def stable(self, x, omega):
        z, r = x.reshape(-1, self.r), self.r
        h = 2 * np.pi / omega / STEPS
        at = 2 * np.pi * (np.arange(STEPS) + 0.5) / STEPS
        k = np.arange(1, self.h + 1)
        basis = np.hstack([np.ones((STEPS, 1)), np.cos(np.outer(at, k)), np.sin(np.outer(at, k))])
        t = self.tangent(basis @ z)
        monodromy, eye = np.eye(2 * r), np.eye(2 * r)
        for s in range(STEPS):
            a = np.block([[np.zeros((r, r)), np.eye(r)], [-t[s], -np.diag(self.damping)]])
            monodromy = np.linalg.solve(eye - h / 2 * a, (eye + h / 2 * a) @ monodromy)
        return np.abs(np.linalg.eigvals(monodromy)).max() < 1 + 1e-6

    def follow(self, low, high):
        """Points (omega, x, stable) from low to high."""
        x, omega, width = np.zeros((2 * self.h + 1) * self.r), low, high - low
        size = 0.0
        for _ in range(20):
            jacobian, _ = self.jacobian(x, omega)
            x = x - np.linalg.solve(jacobian, self.residual(x, omega))
        jacobian, by_omega = self.jacobian(x, omega)
        tangent = np.append(np.linalg.solve(jacobian, -by_omega), 1.0)
        points, step = [(omega, x, self.stable(x, omega))], LONGEST / 10
        while omega < high and len(points) < 2000:
            size = max(size, np.linalg.norm(x))
            scale = np.append(np.full(len(x), size), width)
            tangent = tangent / np.linalg.norm(tangent / scale)
            guess = np.append(x, omega) + step * tangent
            y, found = guess.copy(), False
            for it in range(10):
                g = self.residual(y[:-1], y[-1])
                plane = np.dot(tangent / scale**2, y - guess)
                jacobian, by_omega = self.jacobian(y[:-1], y[-1])
                whole = np.block([[jacobian, by_omega[:, None]], [(tangent / scale**2)[None, :]]])
                change = np.linalg.solve(whole, np.append(g, plane))
                y -= change
                if np.linalg.norm(change / scale) < 1e-9:
                    found = True
                    break
            if not found:
                step /= 2
                continue
            new = np.linalg.solve(whole, np.append(np.zeros(len(x)), 1.0))
            tangent = new if np.dot(new / scale**2, tangent) > 0 else -new
            x, omega = y[:-1], y[-1]
            points.append((omega, x, self.stable(x, omega)))
            step = min(1.5 * step, LONGEST) if it <= 3 else step
        return points


def numpy_curve(path, modes, harmonics, repeat):
    """Seconds, and the curve as rows of Hz and the largest first harmonic of the first coordinate."""
    with np.load(path) as file:
        whole = "c3" in file.files
        rank = len(file["omega2"]) - (0 if whole else len(file["slave_map"]))
        omega2 = file["omega2"][:rank]
        cubic = derivatives(file["c3" if whole else "condensed_c3"], rank, 3)
        quartic = derivatives(file["c4" if whole else "condensed_c4"], rank, 4)
        vertex = np.argmin(((file["vertices"] - [0.15, 0, 0.02])**2).sum(axis=1))
        load = 12 * file["basis"][3 * vertex + 1, :rank]

    def force(q):
        cubed = np.einsum("ijkl,sj,sk,sl->si", quartic, q, q, q, optimize=True)
        return omega2 * q + np.einsum("ijk,sj,sk->si", cubic, q, q, optimize=True) / 2 + cubed / 6

    def tangent(q):
        return np.diag(omega2) + np.einsum("ijk,sk->sij", cubic, q) + np.einsum("ijkl,sk,sl->sij", quartic, q, q, optimize=True) / 2

    # what follows the modes has their least rate
    rates = np.where(np.arange(rank) < modes, 2 * RATIO * np.sqrt(omega2), 2 * RATIO * np.sqrt(omega2[0]))
    balance = Balance(force, tangent, rates, load, harmonics)
    least = math.inf
    for _ in range(repeat):
        began = time.process_time()
        points = balance.follow(2 * np.pi * FROM, 2 * np.pi * TO)
        least = min(least, time.process_time() - began)
    return least, points, rank


def measure(line, repeat):
    """Least user time of a command's runs, and what it printed."""
    least, output = math.inf, ""
    for _ in range(repeat):
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        run = subprocess.run(line, env={**os.environ, "THRUM_GNUPLOT": ""}, check=False, capture_output=True, text=True)
        least, output = min(least, resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before), run.stdout
    return least, json.loads(output)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("thrum")
    parser.add_argument("--masters", type=int, default=8)
    parser.add_argument("--whole", action="store_true")
    parser.add_argument("--harmonics", type=int, default=5)
    parser.add_argument("--repeat", type=int, default=3)
    asked = parser.parse_args()
    quiet = {"env": {**os.environ, "THRUM_GNUPLOT": ""}, "check": True, "capture_output": True, "text": True}
    with tempfile.TemporaryDirectory() as work:
        model, k = os.path.join(work, "panel.npz"), asked.masters
        subprocess.run([asked.thrum, "precompute", *PANEL, "--modes", str(k), "--rank", str(k + k * (k + 1) // 2),
                        *([] if asked.whole else ["--condense"]), "-o", model, "-q"], **quiet)
        line = [asked.thrum, "response", model, "--load", "sine:0,12,0@near:0.15,0,0.02", "--damping-ratio", str(RATIO), "--from",
                str(FROM), "--to", str(TO), "--harmonics", str(asked.harmonics), "--no-check", "--json", "-q", "--step", str(LONGEST),
                *(["--condense", "none"] if asked.whole else [])]
        rows = []
        for inertia in ("off",) if asked.whole else ("off", "on"):
            took, report = measure([*line, "--follower-inertia", inertia], asked.repeat)
            without, _ = measure([*line, "--follower-inertia", inertia, "--points", "2"], asked.repeat)
            rows.append(("thrum" if asked.whole else f"thrum, inertia {inertia}", took - without, report["points"],
                         [special["frequency_hz"] for special in report["special"]]))
        seconds, points, rank = numpy_curve(model, k, asked.harmonics, asked.repeat)

    # both turn back at the same frequencies
    hertz = np.array([omega for omega, _, _ in points]) / (2 * np.pi)
    turns = [hertz[n] for n in range(1, len(hertz) - 1) if (hertz[n] - hertz[n - 1]) * (hertz[n + 1] - hertz[n]) < 0]
    rows.append(("numpy", seconds, len(points), turns))
    print(f"{rank} coordinates, {asked.harmonics} harmonics, forced curve with stability")
    for name, took, count, special in rows:
        print(f"{name:20s} {took:8.4f} s {count:5d} points {1e3 * took / count:8.3f} ms a point  folds",
              ", ".join(f"{f:.4f}" for f in special))
    for name, took, count, _ in rows[:-1]:
        print(f"numpy takes {seconds / len(points) / (took / count):.1f} times as long a point as {name}")


if __name__ == "__main__":
    main()
