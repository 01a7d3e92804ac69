"""A tendon swings a beam to a place and stops it there: 100 controls, found by gradients of 1,000 steps.

usage: python3 swing_to_rest.py [PICTURE.png]

The tendon pulls the tip up or down. The beam starts at rest and is to end 5 cm lower, at rest, with little
pull. BFGS takes the gradient of all controls from one pass backward over the run.

SPDX-License-Identifier: Apache-2.0
"""
import sys

import numpy as np

import thrum

STEPS, CONTROLS, DT = 1000, 100, 0.001
TARGET, EFFORT = -0.05, 1e-6  # m; weight of the mean square of the pull [1/N^2]

model = thrum.Model.precompute("beam:10x2x2@1x0.1x0.08", fix="x<0.001", order=2, young=1e6, modes=3, rank=9)
tip = model.external_load((0, 0, 1), group="tip")  # u_z of the tip is tip @ q, and a pull of 1 N does this
rows = np.arange(STEPS) * CONTROLS // STEPS  # which control holds in each step


def loss(q, p):
    """How far the tip is from its place, and how fast, in the last tenth of the run."""
    place, speed = q[-100:] @ tip - TARGET, 0.1 * p[-100:] @ tip
    q_bar, p_bar = np.zeros_like(q), np.zeros_like(p)
    q_bar[-100:] = 2 * np.outer(place, tip)
    p_bar[-100:] = 2 * 0.1 * np.outer(speed, tip)
    return (place**2).sum() + (speed**2).sum(), q_bar, p_bar


def value_and_gradient(pulls):
    value, gradient = thrum.value_and_gradient(loss, model, STEPS, force=np.outer(pulls[rows], tip), dt=DT)
    by_step = gradient.force @ tip
    by_control = np.bincount(rows, by_step, CONTROLS)
    return value + EFFORT * (pulls**2).mean(), by_control + 2 * EFFORT * pulls / CONTROLS


pulls, inverse = np.zeros(CONTROLS), np.eye(CONTROLS)
value, slope = value_and_gradient(pulls)
inverse *= 0.1 / np.abs(slope).max()  # the first step is of 0.1 N
first, runs = value, 1
for _ in range(200):
    step = -inverse @ slope
    while True:
        next_value, next_slope = value_and_gradient(pulls + step)
        runs += 1
        if next_value <= value + 1e-4 * slope @ step or np.abs(step).max() < 1e-9:
            break
        step /= 4
    change = next_slope - slope
    pulls, value, slope = pulls + step, next_value, next_slope
    if step @ change > 0:
        scale = 1 / (step @ change)
        left = np.eye(CONTROLS) - scale * np.outer(step, change)
        inverse = left @ inverse @ left.T + scale * np.outer(step, step)
    if np.abs(step).max() < 1e-4 * np.abs(pulls).max():
        break

run = thrum.rollout(model, STEPS, force=np.outer(pulls[rows], tip), dt=DT)
height, speed = run.q @ tip, run.p @ tip
print(f"loss {first:.3g} -> {value:.3g} after {runs} runs with gradients")
print(f"tip in the last 0.1 s: {height[-100:].mean():.5f} m, within {np.abs(height[-100:] - TARGET).max():.1e} m")

if len(sys.argv) > 1:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure, (above, below) = plt.subplots(2, 1, sharex=True, figsize=(8, 5))
    above.plot(run.times, height)
    above.axhline(TARGET, color="grey", linestyle="--")
    above.set_ylabel("height of the tip [m]")
    below.step(np.arange(CONTROLS) * STEPS * DT / CONTROLS, pulls, where="post")
    below.set_ylabel("pull [N]")
    below.set_xlabel("time [s]")
    figure.tight_layout()
    figure.savefig(sys.argv[1], dpi=90)
