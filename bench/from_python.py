#!/usr/bin/env python3
"""What a step costs from Python beside the same steps in one call of C (docs/bench.md).

usage: PYTHONPATH=build/release/python python3 bench/from_python.py MODEL.npz [RANK...]

Processor times, the least of nine turns that are taken in alternation. SPDX-License-Identifier: Apache-2.0
"""
import sys
import time

import thrum

TURNS = 9
STEPS = 4000
BODIES = 32


def least(tasks):
    """Least time of each task in us, tried in turns so that all see the same machine."""
    best = [float("inf")] * len(tasks)
    for _ in range(TURNS):
        for number, task in enumerate(tasks):
            start = time.process_time()
            task()
            best[number] = min(best[number], (time.process_time() - start) * 1e6)
    return best


def single_steps(state):
    for _ in range(STEPS):
        state.step()


def small_batches(batch, calls):
    for _ in range(calls):
        batch.step()


def main():
    if len(sys.argv) < 2:
        sys.stderr.write(__doc__)
        return 2
    model = thrum.Model.load(sys.argv[1])
    calls = STEPS // BODIES
    print("rank,us_a_step_of_n,us_a_step_alone,us_more,batch_us_of_n,batch_us_alone,batch_ratio")
    for rank in [int(word) for word in sys.argv[2:]] or [model.rank]:
        body = model.truncate(rank)
        start = body.start(0, 0.05)
        state = body.state()
        state.set(start)
        states = [body.state() for _ in range(BODIES)]
        for one in states:
            one.set(start)
        batch = body.batch(states)
        many, alone, batches, batch_alone = least([
            lambda: state.step(STEPS), lambda: single_steps(state),
            lambda: batch.step(calls), lambda: small_batches(batch, calls)])
        steps = calls * BODIES
        print(f"{rank},{many / STEPS:.3f},{alone / STEPS:.3f},{(alone - many) / STEPS:.3f},"
              f"{batches / steps:.3f},{batch_alone / steps:.3f},{batch_alone / batches:.3f}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
