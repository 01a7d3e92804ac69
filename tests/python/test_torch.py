"""Runs as functions of PyTorch. SPDX-License-Identifier: Apache-2.0"""
import unittest

import torch
from support import beam

import thrum.autograd

STEPS = 6


class Autograd(unittest.TestCase):
    def test_gradcheck_passes(self):
        model = beam()
        torch.manual_seed(1)
        double = {"dtype": torch.float64, "requires_grad": True}
        q = (0.02 * torch.randn(2, model.rank, dtype=torch.float64)).requires_grad_()
        p = (0.5 * torch.randn(model.rank, dtype=torch.float64)).requires_grad_()
        force = (30 * torch.randn(STEPS, model.rank, dtype=torch.float64)).requires_grad_()
        alpha, beta, stiffness, density = (torch.tensor(value, **double) for value in (0.4, 1e-5, 1.3, 0.8))

        # each input about as large as what it changes
        def run(q, p, force, alpha, beta, stiffness, density):
            found = thrum.autograd.rollout(model, STEPS, q, p, 100 * force, alpha, 1e-4 * beta, stiffness, density, tolerance=1e-14)
            return found[0], 0.01 * found[1]

        given = (q, p, (force.detach() / 100).requires_grad_(), alpha, (beta.detach() / 1e-4).requires_grad_(), stiffness, density)
        self.assertTrue(torch.autograd.gradcheck(run, given, eps=1e-6, atol=1e-5, rtol=1e-4))

    def test_a_batch_has_the_gradient_of_its_runs(self):
        model = beam()
        q = torch.zeros(3, model.rank, dtype=torch.float64)
        q[:, 0] = torch.tensor([0.01, 0.02, 0.05])
        q.requires_grad_()
        stiffness = torch.tensor(1.1, dtype=torch.float64, requires_grad=True)
        path, _ = thrum.autograd.rollout(model, STEPS, q, stiffness=stiffness)
        self.assertEqual(tuple(path.shape), (3, STEPS + 1, model.rank))
        path[:, -1].square().sum().backward()
        total = 0.0
        for n in range(3):
            one = q[n].detach().requires_grad_()
            factor = torch.tensor(1.1, dtype=torch.float64, requires_grad=True)
            alone, _ = thrum.autograd.rollout(model, STEPS, one, stiffness=factor)
            alone[-1].square().sum().backward()
            torch.testing.assert_close(q.grad[n], one.grad, rtol=0, atol=0)
            total += float(factor.grad)
        self.assertAlmostEqual(total / float(stiffness.grad), 1.0, 12)

    def test_shapes_are_checked(self):
        model = beam()
        with self.assertRaisesRegex(ValueError, "q: its shape"):
            thrum.autograd.rollout(model, STEPS, torch.zeros(3))
        with self.assertRaisesRegex(ValueError, "batches of 2, 3"):
            thrum.autograd.rollout(model, STEPS, torch.zeros(2, model.rank), torch.zeros(3, model.rank))


if __name__ == "__main__":
    unittest.main()
