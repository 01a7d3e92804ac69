"""An environment for reinforcement learning: many beams at once, which a force at the tip is to bring to rest.

It has the shape of a vector environment of Gymnasium, reset and step with arrays, and needs Thrum and NumPy alone. The program
tries two policies, to do nothing and to push against the velocity of the tip, and fails where the second is not the better.

usage: environment.py MODEL.npz
SPDX-License-Identifier: Apache-2.0
"""
import sys

import numpy as np

import thrum


class BeamsAtRest:
    """observation: place and velocity of each tip, count x 6 [m, m/s]; action: a force on it, count x 3, within -1 to 1."""

    def __init__(self, model, count=64, dt=0.01, newtons=20.0, steps=300):
        self.count, self.steps = count, steps
        self.batch = model.batch([model.state(dt=dt) for _ in range(count)])
        tip = model.group("tip")
        self.rows = model.basis.reshape(-1, 3, model.rank)[tip].mean(axis=0)  # 3 x r: the mean displacement of the tip
        self.newtons, self.modes = newtons, model.start(0, 1.0)
        self.made = np.zeros(count, int)

    def _observe(self):
        q, p = self.batch.get()
        return np.concatenate([q @ self.rows.T, p @ self.rows.T], axis=1)

    def _begin(self, which):
        """The beams of a mask are struck, each another way."""
        q = np.zeros((self.count, len(self.modes)))
        q[:, :2] = self.random.uniform(-0.1, 0.1, (self.count, 2)) * self.modes[0]
        self.batch.set(q, where=which)
        self.made[which] = 0

    def reset(self, seed=None):
        self.random = np.random.default_rng(seed)
        self._begin(np.ones(self.count, bool))
        return self._observe(), {}

    def step(self, action):
        self.batch.force = self.newtons * np.clip(action, -1, 1) @ self.rows
        failed = self.batch.step() < 0
        seen = self._observe()
        self.made += 1
        reward = -np.square(seen[:, :3]).sum(axis=1)
        truncated = self.made >= self.steps
        if (failed | truncated).any():
            self._begin(failed | truncated)
            seen = self._observe()
        return seen, reward, failed, truncated, {}


def total(environment, policy):
    """The mean reward of an episode."""
    seen, _ = environment.reset(seed=1)
    rewards = []
    for _ in range(environment.steps):
        seen, reward, _, _, _ = environment.step(policy(seen))
        rewards.append(reward)
    return np.sum(rewards, axis=0).mean()


def main():
    environment = BeamsAtRest(thrum.Model.load(sys.argv[1]))
    still, against = total(environment, lambda seen: 0 * seen[:, 3:]), total(environment, lambda seen: -seen[:, 3:])
    print(f"reward of an episode: {still:.3f} without force, {against:.3f} against the velocity")
    return 0 if against > 0.5 * still else 1


if __name__ == "__main__":
    sys.exit(main())
