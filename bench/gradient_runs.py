#!/usr/bin/env python3
"""What gradients cost beside the run: in runs, of 1,000 steps under a force that stays (docs/bench.md).

usage: PYTHONPATH=build/release/python python3 bench/gradient_runs.py MODEL.npz...

Processor times, the least of nine turns that are taken in alternation. SPDX-License-Identifier: Apache-2.0
"""
import sys
import time

import numpy as np

import thrum

TURNS, STEPS = 9, 1000


def least(tasks):
    """Least time of each task in s, tried in turns so that all see the same machine."""
    best = [float("inf")] * len(tasks)
    for _ in range(TURNS):
        for number, task in enumerate(tasks):
            start = time.process_time()
            task()
            best[number] = min(best[number], time.process_time() - start)
    return best


def main():
    if len(sys.argv) < 2:
        sys.stderr.write(__doc__)
        return 2
    print("rank,integrator,us_a_step,recorded_runs,run_and_gradient_runs,hessian_product_runs")
    for path in sys.argv[1:]:
        body = thrum.Model.load(path)
        rank = body.rank
        start = body.start(0, 0.05)
        held = 5 * np.random.default_rng(1).standard_normal(rank)
        force = np.tile(held, (STEPS, 1))
        for integrator in ("energy", "newmark", "midpoint", "verlet"):
            options = {"integrator": integrator, "dt": 0.5 / np.sqrt(body.omega2[-1]) if integrator == "verlet" else 0.002}
            state = body.state(**options)
            state.force = held
            q_bar = np.ones((STEPS + 1, rank))

            def loss(q, p, q_bar=q_bar):
                return q.sum(), q_bar, None

            def plain(state=state):
                state.set(start)
                state.step(STEPS)

            runs, recorded, gradient, second = least([
                plain, lambda: thrum.rollout(body, STEPS, start, None, force, **options),
                lambda: thrum.value_and_gradient(loss, body, STEPS, start, None, force, **options),
                lambda: thrum.hessian_product(loss, body, STEPS, start, None, force, along={"q": start}, **options)])
            print(f"{rank},{integrator},{runs / STEPS * 1e6:.2f},{recorded / runs:.2f},{gradient / runs:.2f},{second / runs:.2f}",
                  flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
