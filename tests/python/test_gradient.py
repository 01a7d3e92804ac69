"""Gradients of runs from Python. SPDX-License-Identifier: Apache-2.0"""
import os
import tempfile
import unittest

import numpy as np
from support import beam, model_file

import thrum

STEPS = 30


def inputs(model, seed=1):
    random = np.random.default_rng(seed)
    return {"q": 0.02 * random.standard_normal(model.rank), "p": 0.5 * random.standard_normal(model.rank),
            "force": 30 * random.standard_normal((STEPS, model.rank)), "damping_alpha": 0.4, "damping_beta": 1e-5,
            "stiffness": 1.3, "density": 0.8}


OPTIONS = {"energy": 0.002, "newmark": 0.002, "midpoint": 0.002, "verlet": 2e-5}


class Gradients(unittest.TestCase):
    def test_a_gradient_agrees_with_differences(self):
        model = beam()
        random = np.random.default_rng(2)
        weights = random.standard_normal((2, STEPS + 1, model.rank))

        def loss(q, p):
            return (weights[0] * q).sum() + 0.01 * (weights[1] * p).sum(), weights[0], 0.01 * weights[1]

        given, change = inputs(model), inputs(model, 3)
        for integrator, dt in OPTIONS.items():
            options = {"integrator": integrator, "dt": dt, "tolerance": 1e-14}
            _, g = thrum.value_and_gradient(loss, model, STEPS, **given, **options)
            found = ((g.q * change["q"]).sum() + (g.p * change["p"]).sum() + (g.force * change["force"]).sum()
                     + g.alpha * change["damping_alpha"] + g.beta * change["damping_beta"]
                     + g.stiffness * change["stiffness"] + g.density * change["density"])
            by = 1e-4
            values = [thrum.value_and_gradient(loss, model, STEPS, **{name: given[name] + n * by * change[name] for name in given},
                                               **options)[0] for n in (-2, -1, 1, 2)]
            differences = (values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * by)
            self.assertAlmostEqual(differences / found, 1.0, 7, integrator)

            # the pass forward is the transpose
            run = thrum.rollout(model, STEPS, **given, **options)
            names = {"damping_alpha": "alpha", "damping_beta": "beta"}
            q, p = run.push_forward(**{names.get(name, name): value for name, value in change.items()})
            self.assertAlmostEqual(((weights[0] * q).sum() + 0.01 * (weights[1] * p).sum()) / found, 1.0, 11)

    def test_second_derivatives_are_those_of_the_loss(self):
        model = beam()

        def loss(q, p):
            return 0.5 * (q**2).sum() + 1e-4 * (p[-1]**2).sum(), q, np.vstack([np.zeros((STEPS, model.rank)), 2e-4 * p[-1:]])

        def product(first, second):
            names = {"damping_alpha": "alpha", "damping_beta": "beta"}
            g = thrum.hessian_product(loss, model, STEPS, **given, along=first, dt=0.002, tolerance=1e-14)
            return sum((np.asarray(getattr(g, names.get(name, name))) * value).sum() for name, value in second.items())

        def value(by):
            moved = {name: given[name] + by * one[name] for name in given}
            return thrum.value_and_gradient(loss, model, STEPS, **moved, dt=0.002, tolerance=1e-14)[0]

        # the matrix is symmetric, and its form is the second difference of the loss
        given, one, two = inputs(model), inputs(model, 3), inputs(model, 4)
        one, two = ({name: value / 10 for name, value in direction.items()} for direction in (one, two))
        self.assertAlmostEqual(product(one, two) / product(two, one), 1.0, 6)
        h = 1e-2
        second = (-value(2 * h) + 16 * value(h) - 30 * value(0) + 16 * value(-h) - value(-2 * h)) / (12 * h * h)
        self.assertAlmostEqual(product(one, one) / second, 1.0, 5)

    def test_a_spring_is_that_of_a_link(self):
        model, steps = beam(), 200
        start, tip = model.start(0, 0.05), model.external_load((0, 0, 1), group="tip")
        q_bar = np.zeros((steps + 1, model.rank))
        q_bar[-1] = tip
        run = thrum.rollout(model, steps, start, dt=0.002, tolerance=1e-13)
        found = run.pull_back(q_bar, springs=[("tip", None)]).springs[0]

        place = model.vertices[model.group("tip")].mean(axis=0)

        # the scene steps the body with the link, whose place in the world is where the tip is at rest
        def hung(stiffness):
            scene = thrum.Scene(dt=0.002)
            body = scene.add_body(model, q=start)
            scene.add_link("spring", body, group="tip", other_place=place, stiffness=stiffness, length=0)
            scene.step(steps)
            return tip @ body.q
        self.assertAlmostEqual((hung(0.1) - tip @ run.q[-1]) / 0.1 / found, 1.0, 3)

    def test_what_follows_is_differentiated(self):
        model = beam().condense(3)
        force = np.tile(model.external_load((0, 0, -20), group="tip"), (STEPS, 1))
        q_bar = np.ones((STEPS + 1, 3))

        def run(by):
            return thrum.value_and_gradient(lambda q, p: (q.sum(), q_bar, None), model, STEPS, force=by * force, tolerance=1e-13)
        found = (run(1.0)[1].force * force).sum()
        self.assertAlmostEqual((run(1.001)[0] - run(0.999)[0]) / 0.002 / found, 1.0, 6)

    def test_a_body_that_acts(self):
        wire = "wire=tendon:at:-0.1,0,0.3,near:0.5,0.05,0.05,near:1,0.05,0.05"
        model = thrum.Model.load(model_file("acts", "beam:4x1x1@1x0.1x0.1", fix="x<0.001", order=1, young=1e6, modes=3, rank=8,
                                            actuator=[wire, "heat=swell:all"]))
        tip, time = model.external_load((0, 0, 1), group="tip"), np.linspace(0, 1, STEPS)
        q_bar = np.zeros((STEPS + 1, model.rank))
        q_bar[-1] = tip
        given = {"actuation": np.stack([2 * np.sin(3 * time + 0.5), 0.01 * time], axis=1), "stiffness": 1.2, "density": 0.8}
        change = {"actuation": np.stack([np.cos(5 * time), 0.005 * time], axis=1), "stiffness": 0.3, "density": 0.2}

        for integrator in ("energy", "midpoint"):
            options = {"integrator": integrator, "dt": 0.001, "tolerance": 1e-12}

            def value(by, options=options):
                return thrum.value_and_gradient(lambda q, p: (tip @ q[-1], q_bar, None), model, STEPS, **options,
                                                **{name: given[name] + by * change[name] for name in given})
            g = value(0.0)[1]
            found = sum(np.sum(getattr(g, name) * change[name]) for name in change)
            by = 1e-3
            values = [value(n * by)[0] for n in (-2, -1, 1, 2)]
            self.assertAlmostEqual((values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * by) / found, 1.0, 7)
            q = thrum.rollout(model, STEPS, **given, **options).push_forward(**change)[0]
            self.assertAlmostEqual(tip @ q[-1] / found, 1.0, 10)

        # levels by their names; a run with them is that of a state
        run = thrum.rollout(model, STEPS, actuation={"wire": given["actuation"][:, 0], "heat": 0.01})
        state = model.state()
        for level in given["actuation"][:, 0]:
            state.actuation = {"wire": level, "heat": 0.01}
            state.step()
        np.testing.assert_array_equal(run.q[-1], state.q)
        with self.assertRaisesRegex(KeyError, "no actuator 'rope'"):
            thrum.rollout(model, STEPS, actuation={"rope": 1})
        with self.assertRaisesRegex(ValueError, "actuation: its shape"):
            thrum.rollout(model, STEPS, actuation=np.zeros((2, 2)))
        with self.assertRaises(thrum.Unsupported):
            thrum.rollout(beam(), STEPS, actuation=np.zeros((STEPS, 0)))

    def test_checkpoints_keep_little_and_change_nothing(self):
        model, given = beam(), inputs(beam())
        weights = np.random.default_rng(2).standard_normal((STEPS // 10 + 1, model.rank))

        def loss(q, p):
            return (weights * q).sum() + (p[-1]**2).sum(), weights, np.vstack([np.zeros((len(q) - 1, model.rank)), 2 * p[-1:]])
        for integrator, dt in OPTIONS.items():
            options = {**given, "every": 10, "integrator": integrator, "dt": dt}
            value, g = thrum.value_and_gradient(loss, model, STEPS, **options)
            again, kept = thrum.value_and_gradient(loss, model, STEPS, checkpoints=4, **options)
            np.testing.assert_allclose(value, again, rtol=1e-13)
            np.testing.assert_allclose(g.q, kept.q, rtol=1e-12)
            np.testing.assert_allclose(g.force, kept.force, rtol=1e-9, atol=1e-12)
            self.assertAlmostEqual(g.stiffness / kept.stiffness, 1.0, 12)
        run = thrum.rollout(model, STEPS, given["q"], checkpoints=3, every=7)
        self.assertEqual(run.q.shape, (5, model.rank))
        self.assertAlmostEqual(run.times[-1], 28 * 0.003)
        self.assertEqual(run.push_forward(q=given["q"])[0].shape, (5, model.rank))
        with self.assertRaisesRegex(ValueError, "every"):
            thrum.rollout(model, STEPS, every=0)

    def test_a_body_that_touches(self):
        model = beam()
        tip = model.external_load((0, 0, 1), group="tip")
        q_bar = np.zeros((STEPS + 1, model.rank))
        q_bar[-1] = tip

        # the beam is pushed down on a soft floor half a millimetre below it
        def run(by=0.0, subgradient=None, integrator="midpoint", **floor):
            floor = {"centre": (0, 0, model.vertices[:, 2].min() - 0.0005), "stiffness": 1e6, "restitution": 1, "friction": 0, **floor}
            touching = thrum.Touching([thrum.Obstacle(**floor)], subgradient=subgradient)
            return thrum.value_and_gradient(lambda q, p: (tip @ q[-1], q_bar, None), model, STEPS, model.start(0, 0.001 * (1 + by)),
                                            force=np.tile(-80 * (1 + by) * tip, (STEPS, 1)), stiffness=1 + by, density=1 - 0.3 * by, dt=0.002,
                                            tolerance=1e-14, touching=touching, integrator=integrator)

        def derivative(g):
            return g.q @ model.start(0, 0.001) + (g.force * -80 * tip).sum() + g.stiffness - 0.3 * g.density
        value, g = run()
        free = thrum.value_and_gradient(lambda q, p: (tip @ q[-1], q_bar, None), model, STEPS, model.start(0, 0.001),
                                        force=np.tile(-80 * tip, (STEPS, 1)), dt=0.002)[0]
        self.assertGreater(abs(value / free - 1), 0.5)
        self.assertAlmostEqual((run(1e-5)[0] - run(-1e-5)[0]) / 2e-5 / derivative(g), 1.0, 6)
        damped = {"stiffness": 0, "damping": 1000}
        self.assertAlmostEqual((run(1e-5, **damped)[0] - run(-1e-5, **damped)[0]) / 2e-5 / derivative(run(**damped)[1]), 1.0, 6)

        # steps of energy give back what the prediction missed, and how that changes is left out
        by_energy = (run(1e-5, integrator="energy")[0] - run(-1e-5, integrator="energy")[0]) / 2e-5
        self.assertAlmostEqual(by_energy / derivative(run(integrator="energy")[1]), 1.0, 1)

        # where it is thrown back or rests it has none, unless it is asked for
        hard = {"restitution": 0.2, "friction": 0.5, "stiffness": 1e9}
        with self.assertRaisesRegex(thrum.Unsupported, r"step \d+ at t = .* vertex \d+ .* obstacle 0"):
            run(**hard)
        self.assertTrue(np.isfinite(run(subgradient="fixed", **hard)[1].q).all())
        with self.assertRaisesRegex(ValueError, "subgradient"):
            run(subgradient="any")

    def test_a_long_run_agrees_with_differences(self):
        model, steps = beam(), 10000

        def run(factor):
            tip = model.external_load((0, 0, 1), group="tip")
            q_bar = np.zeros((steps + 1, model.rank))
            q_bar[-1] = tip
            return thrum.value_and_gradient(lambda q, p: (tip @ q[-1], q_bar, None), model, steps, model.start(0, 0.02),
                                            stiffness=factor, damping_alpha=0.1, dt=0.002, tolerance=1e-14)

        found, by = run(1.0)[1].stiffness, 2e-6
        values = [run(1.0 + n * by)[0] for n in (-2, -1, 1, 2)]
        self.assertAlmostEqual((values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * by) / found, 1.0, 6)

    def test_derivatives_by_moduli_and_density(self):
        model = thrum.Model.load(model_file("parameters", "beam:6x1x1@1x0.15x0.15", fix="x<0.001", order=1, modes=3, rank=6,
                                            parameters=True))
        values = model.parameters
        np.testing.assert_allclose(model.with_parameters(values * [1.1, 1.1, 1.0]).omega2, 1.1 * np.array(model.omega2), 1e-9)

        # that body has a file, with the same bits and parameters
        other = model.with_parameters(values * [1.2, 1.1, 0.9])
        with tempfile.TemporaryDirectory() as folder:
            other.save(os.path.join(folder, "other.npz"))
            again = thrum.Model.load(os.path.join(folder, "other.npz"))
        np.testing.assert_array_equal(again.omega2, other.omega2)
        np.testing.assert_allclose(again.parameters, values * [1.2, 1.1, 0.9], 1e-12)
        q = other.start(0, 0.02)
        self.assertEqual(again.strain_energy(q), other.strain_energy(q))

        # a pull at the tip from rest, seen at the tip
        def run(body, parameters=False):
            tip = body.external_load((0, 0, 1), group="tip")
            q_bar = np.zeros((STEPS + 1, body.rank))
            q_bar[-1] = tip
            return thrum.value_and_gradient(lambda q, p: (tip @ q[-1], q_bar, None), body, STEPS, force=np.tile(40 * tip, (STEPS, 1)),
                                            dt=0.004, tolerance=1e-14, parameters=parameters)

        found = run(model, True)[1].parameters
        for n in range(3):
            by = np.zeros((1, 3))
            by[0, n] = 1e-4 * values[0, n]
            differences = (run(model.with_parameters(values + by))[0] - run(model.with_parameters(values - by))[0]) / (2 * by[0, n])
            self.assertAlmostEqual(found[0, n] / differences, 1.0, 5)
        with self.assertRaises(thrum.Unsupported):
            run(beam(), True)
        with self.assertRaises(thrum.Unsupported):
            beam().with_parameters(values)

    def test_a_run_is_that_of_a_state(self):
        model = beam()
        given = inputs(model)
        run = thrum.rollout(model, STEPS, given["q"], given["p"], given["force"])
        state = model.state()
        state.set(given["q"], given["p"])
        for force in given["force"]:
            state.force = force
            state.step()
        np.testing.assert_array_equal(run.q[-1], state.q)
        np.testing.assert_array_equal(run.p[-1], state.p)
        self.assertEqual(run.q.shape, (STEPS + 1, model.rank))
        self.assertFalse(run.q.flags.writeable)
        self.assertAlmostEqual(run.times[-1], 0.09)

    def test_what_has_no_gradient_is_refused(self):
        model = beam()
        with self.assertRaisesRegex(thrum.Unsupported, "imexv"):
            thrum.rollout(model, 3, integrator="imexv")
        with self.assertRaisesRegex(thrum.Unsupported, "condensed"):
            thrum.rollout(model.condense(4), 3, damping_beta=1e-4)
        with self.assertRaisesRegex(ValueError, "steps"):
            thrum.rollout(model, 0)
        with self.assertRaisesRegex(ValueError, "factors above 0"):
            thrum.rollout(model, 3, density=-1)
        with self.assertRaisesRegex(ValueError, "force: its shape is 2 x 12, not 3 x 12"):
            thrum.rollout(model, 3, force=np.zeros((2, 12)))
        with self.assertRaises(thrum.BadValue):
            thrum.rollout(model, 3).pull_back(np.full((4, 12), np.nan))


if __name__ == "__main__":
    unittest.main()
