"""States and batches from Python. SPDX-License-Identifier: Apache-2.0"""
import gc
import itertools
import os
import pickle
import signal
import threading
import unittest
import weakref

import numpy as np
from support import beam, model_file

import thrum


def struck(model, **options):
    """A state that swings: its tip is 0.1 m off."""
    state = model.state(**options)
    state.set(model.start(0, 0.1)[:model.rank])
    return state


class Acting(unittest.TestCase):
    def test_levels_by_name_do_work(self):
        wire = "wire=tendon:near:0,0,0.075,near:0.5,0,0.075,near:1,0,0.075"
        model = thrum.Model.load(model_file("arm", "beam:4x1x1@1x0.15x0.15,split=6", fix="x<0.001", order=1, modes=3,
                                            rank=6, actuator=[wire, "heat=swell:all"]))
        self.assertEqual(model.actuators, ["wire", "heat"])
        state = model.state()
        state.actuation = {"wire": 100.0}
        state.actuation = {"heat": 0.01}
        self.assertEqual(state.actuation, {"wire": 100.0, "heat": 0.01})
        state.step(200)
        self.assertAlmostEqual(sum(state.actuation_work.values()) / state.energies.total, 1.0, 10)
        self.assertNotEqual(state.actuation_measures["wire"], 1.0)
        with self.assertRaisesRegex(KeyError, "no actuator 'rope'"):
            state.actuation = {"rope": 1.0}
        state.actuation = None
        self.assertEqual(set(state.actuation.values()), {0.0})
        found = model.equilibrium(np.zeros(model.rank), actuation={"wire": 100.0})
        self.assertTrue(found.stable and found.energy > 0)

        # levels of many, and of each step: those of each state by itself
        levels = np.stack([np.linspace(0, 200, 3 * 8), np.linspace(0.01, -0.01, 3 * 8)], axis=1).reshape(3, 8, 2)
        alone, batch = [model.state() for _ in range(3)], model.batch([model.state() for _ in range(3)], 2)
        q, _ = batch.rollout(np.zeros(model.rank), np.zeros((3, 8, model.rank)), actuation=levels)
        for one, rows in zip(alone, levels):
            for row in rows:
                one.actuation = row
                one.step()
        np.testing.assert_array_equal(q[:, -1], [one.q for one in alone])
        np.testing.assert_array_equal(batch.actuation, levels[:, -1])
        batch.actuation = [50.0, 0.0]
        np.testing.assert_array_equal(batch.actuation, [[50.0, 0.0]] * 3)
        with self.assertRaisesRegex(ValueError, "actuation: its shape is 3, not 3 x 2 or 2"):
            batch.actuation = [1.0, 2.0, 3.0]
        with self.assertRaisesRegex(thrum.BadValue, "that of state 1 is not finite"):
            batch.actuation = [[1.0, 0.0], [np.nan, 0.0], [1.0, 0.0]]
        np.testing.assert_array_equal(batch.actuation, [[50.0, 0.0]] * 3)


class Stepping(unittest.TestCase):
    def test_energy_is_kept(self):
        state = struck(beam())
        before = state.energies.total
        self.assertEqual(state.step(2000), thrum.Status.OK)
        self.assertAlmostEqual(state.energies.total / before, 1.0, 12)
        self.assertEqual(state.report.steps, 2000)
        self.assertAlmostEqual(state.time, 6.0, 9)

    def test_a_copy_refuses_to_be_written_to(self):
        state = struck(beam())
        for array in (state.q, state.p, state.force):
            with self.assertRaisesRegex(ValueError, "read-only"):
                array[0] = 1.0
        # what get fills is the caller's own
        q, _ = state.get()
        q[0] = 1.0

    def test_an_interrupt_ends_many_steps(self):
        state = struck(beam())
        timer = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            state.step(10**12)
        timer.join()
        # the state is that between two steps, and goes on
        made = state.report.steps
        self.assertGreater(made, 0)
        state.step()
        self.assertEqual(state.report.steps, made + 1)

    def test_many_steps_are_as_many_single_ones(self):
        for integrator in thrum.integrators():
            # manifold steps what condensed models leave out
            model = beam().condense(4) if integrator == "manifold" else beam()
            once, often = struck(model, integrator=integrator, dt=2e-4), struck(model, integrator=integrator, dt=2e-4)
            once.step(40)
            for _ in range(40):
                often.step()
            np.testing.assert_array_equal(once.q, often.q, integrator)

    def test_every_integrator_of_the_library_is_named(self):
        self.assertIn("energy", thrum.integrators())
        self.assertIn("imexv", thrum.integrators())
        with self.assertRaisesRegex(thrum.InvalidArgument, "newmark"):
            beam().state(integrator="euler")

    def test_failures(self):
        # explicit and far beyond its stability: it is said, and nothing that is not finite stays
        state = struck(beam(), integrator="rk4", dt=0.05)
        with self.assertRaises(thrum.NotConverged) as caught:
            state.step(100000)
        self.assertEqual(caught.exception.status, thrum.Status.NOT_FINITE)
        self.assertTrue(np.isfinite(state.q).all())
        self.assertLess(state.report.steps, 100000)

    def test_plastic_flow(self):
        with self.assertRaisesRegex(thrum.Unsupported, "cannot flow"):
            beam().state(plastic_yield=0.1)
        model = thrum.Model.load(model_file("points", "beam:3x1x1@0.3x0.1x0.1", fix="x<0.001", order=1, modes=3, rank=6,
                                            young=1e5, cubature=True, cubature_error=0.1, law="corotational"))
        # points that were not trained on flow are refused, but where that is asked for
        self.assertEqual(model.point_training.tolist()[1:], [0.0, 0.0, 0.0])
        self.assertGreater(model.point_training[0], 0.0)
        with self.assertRaisesRegex(thrum.Unsupported, "not trained on plastic flow"):
            model.state(plastic_yield=0.01)
        state = model.state(plastic_yield=0.01, plastic_creep=50, untrained_flow=True)
        state.set(p=np.eye(6)[0])
        before = state.energies.total
        state.step(50)
        self.assertGreater(state.report.plastic_work, 0)
        self.assertAlmostEqual((state.energies.total + state.report.plastic_work) / before, 1.0, 12)

        # a copy and a pickled one go on from what has flowed, and it can be taken back
        for twin in (state.copy(), pickle.loads(pickle.dumps(state))):
            self.assertEqual(twin.plastic_strain, state.plastic_strain)
        self.assertGreater(state.plastic_strain, 0)
        self.assertGreater(state.point_stiffness, 0)
        state.clear_plastic()
        self.assertEqual(state.plastic_strain, 0)

    def test_refusals(self):
        model = beam()
        for options in ({"dt": 0.0}, {"dt": float("nan")}, {"split_rule": "half"}, {"kernel": "gpu"},
                        {"iterations_max": 0}, {"iterations_max": 1 << 40}):
            with self.assertRaises((ValueError, OverflowError)):
                model.state(**options)
        with self.assertRaisesRegex(TypeError, "integrator"):
            model.state(timestep=0.1)
        state = model.state()
        for wrong in (np.zeros(11), np.full(12, np.nan), "q"):
            with self.assertRaises(ValueError):
                state.set(wrong)
            with self.assertRaises(ValueError):
                state.force = wrong
        with self.assertRaises(thrum.InvalidArgument):
            state.step(-1)
        with self.assertRaises(TypeError):
            state.step(1.5)
        with self.assertRaises(thrum.InvalidArgument):
            state.set_dt(-1)

    def test_load_and_statics(self):
        """Under a load the damped beam comes to rest at its equilibrium."""
        model = beam()
        load = model.external_load(gravity=(0, 0, -9.81))
        state = model.state(damping_alpha=20.0)
        state.force = load
        np.testing.assert_array_equal(state.force, load)
        state.step(2000)
        np.testing.assert_allclose(state.q, model.equilibrium(load).q, atol=1e-8)
        state.force = None
        self.assertEqual(state.force.tolist(), [0.0] * 12)

    def test_snapshots_copies_pickles(self):
        state = struck(beam(), integrator="imexv")
        state.force = state.model.external_load(gravity=(0, 0, -1))
        state.step(50)
        kept = state.snapshot()
        twins = [state.copy(), pickle.loads(pickle.dumps(state))]
        state.step(50)
        end = state.q
        for twin in twins:
            twin.step(50)
            np.testing.assert_array_equal(twin.q, end)
        state.restore(kept)
        state.step(50)
        np.testing.assert_array_equal(state.q, end)
        changed = bytearray(kept)
        changed[-1] ^= 1
        with self.assertRaises(thrum.BadFile):
            state.restore(bytes(changed))
        with self.assertRaises(thrum.ModelMismatch):
            state.model.truncate(5).state().restore(kept)

    def test_output_in_place(self):
        state = struck(beam())
        q, p = np.empty(12), np.empty(12)
        got = state.get(q, p)
        self.assertIs(got[0], q)
        self.assertIs(got[1], p)
        frozen = np.empty(12)
        frozen.flags.writeable = False
        with self.assertRaises(ValueError):
            state.get(q=frozen)

    def test_closed(self):
        with beam().state() as state:
            state.step()
        for use in (state.step, state.snapshot, lambda: state.q, lambda: state.report, lambda: state.energies):
            with self.assertRaisesRegex(ValueError, "closed"):
                use()
        state.close()
        self.assertIn("closed", repr(state))


class Batches(unittest.TestCase):
    def test_bits_of_single_steps(self):
        model = beam()
        alone = [struck(model, damping_alpha=0.1 * k) for k in range(20)]
        together = [struck(model, damping_alpha=0.1 * k) for k in range(20)]
        batch = model.batch(together)
        self.assertEqual(batch.step(30).tolist(), [0] * 20)
        for state in alone:
            state.step(30)
        np.testing.assert_array_equal(batch.coordinates(), [state.q for state in alone])

    def test_refusals(self):
        model = beam()
        state = model.state()
        with self.assertRaises(ValueError):
            model.batch([state, state])
        with self.assertRaises(thrum.ModelMismatch):
            model.batch([state, model.truncate(5).state()])
        with self.assertRaises(thrum.ModelMismatch):
            model.batch([model.scale(stiffness=2.0).state()])
        batch = model.batch([state])
        state.close()
        with self.assertRaisesRegex(ValueError, "closed"):
            batch.step()
        with self.assertRaisesRegex(ValueError, "closed"):
            model.batch([state])

    def test_arrays_of_a_batch_are_those_of_its_states(self):
        model = beam()
        for threads in (1, 3):
            states, alone = ([model.state(damping_alpha=0.1 * k) for k in range(7)] for _ in range(2))
            batch = model.batch(states, threads)
            random = np.random.default_rng(1)
            q, p, force = (random.standard_normal((7, model.rank)) * size for size in (1e-3, 0.1, 5.0))
            batch.set(q, p)
            batch.force = force
            for state, a, b, f in zip(alone, q, p, force):
                state.set(a, b)
                state.force = f
                state.step(5)
            self.assertEqual(batch.step(5).tolist(), [0] * 7)
            np.testing.assert_array_equal(batch.q, [state.q for state in alone])
            np.testing.assert_array_equal(batch.p, [state.p for state in alone])
            np.testing.assert_array_equal(batch.force, force)

            # one row for all
            batch.force = force[0]
            batch.step()
            for state in alone:
                state.force = force[0]
                state.step()
            np.testing.assert_array_equal(batch.q, [state.q for state in alone])
            batch.force = force
            np.testing.assert_array_equal(states[3].force, force[3])
            np.testing.assert_array_equal(batch.energies["total"], [state.energies.total for state in alone])

            # some begin anew, and all are pulled alike
            before = batch.q
            batch.set(0.01 * np.eye(model.rank)[0], where=np.arange(7) == 2)
            self.assertEqual(batch.q[2, 0], 0.01)
            np.testing.assert_array_equal(np.delete(batch.q, 2, 0), np.delete(before, 2, 0))
            batch.force = force[0]
            np.testing.assert_array_equal(batch.force, np.tile(force[0], (7, 1)))
            batch.force = None
            self.assertFalse(batch.force.any())

            # a rollout is the same step by step
            loads = 3 * random.standard_normal((7, 6, model.rank))
            motion, statuses = batch.rollout(q, loads, p)
            self.assertEqual((motion.shape, statuses.any()), ((7, 6, model.rank), False))
            batch.set(q, p)
            for n in range(6):
                batch.force = loads[:, n]
                batch.step()
                np.testing.assert_array_equal(motion[:, n], batch.q)

            # what does not fit is refused, and nothing is changed
            before = batch.q
            for wrong in (lambda: batch.set(q[:3]), lambda: batch.set(q, where=[1] * 7), lambda: batch.rollout(q, loads[0]),
                          lambda: setattr(batch, "force", force[:, :3])):
                with self.assertRaises(ValueError):
                    wrong()
            np.testing.assert_array_equal(batch.q, before)
            broken, held = force.copy(), batch.force
            broken[4, 1] = np.nan
            with self.assertRaisesRegex(thrum.BadValue, "state 4"):
                batch.force = broken
            np.testing.assert_array_equal(batch.force, held)
            np.testing.assert_array_equal([state.force for state in states], held)

    def test_a_state_that_fails_stops_alone(self):
        model = beam()
        batch = model.batch([struck(model), struck(model, integrator="rk4", dt=0.05)])
        statuses = batch.step(1000)
        self.assertEqual(statuses[0], thrum.Status.OK)
        self.assertLess(statuses[1], 0)


class Lifetimes(unittest.TestCase):
    def test_freed_in_every_order(self):
        """The memory of a model lives as long as anything that was made from it, and no longer."""
        users = {
            "model": lambda model: model,
            "state": lambda model: model.state(),
            "view": lambda model: model.basis,
            "derived": lambda model: model.truncate(4).state(),
            "stress": lambda model: (model.stress_points(), model.stress_nodes()),
        }
        for order in itertools.permutations(users):
            model = beam()
            handle = weakref.ref(model._shared)
            held = {name: make(model) for name, make in users.items()}
            del model
            for name in order:
                self.assertIsNotNone(handle(), order)
                for rest in held.values():
                    self.use(rest)
                del rest
                del held[name]
            gc.collect()
            self.assertIsNone(handle(), order)

    def use(self, thing):
        if isinstance(thing, thrum.State):
            thing.step()
        elif isinstance(thing, np.ndarray):
            self.assertTrue(np.isfinite(thing).all())
        elif isinstance(thing, tuple):
            for stress in thing:
                stress.read(np.zeros(12))
        else:
            thing.strain_energy(np.zeros(12))

    def test_model_closed_under_a_state(self):
        model = beam()
        state = struck(model)
        model.close()
        gc.collect()
        self.assertEqual(state.step(10), thrum.Status.OK)


class Threads(unittest.TestCase):
    def test_steps_release_the_interpreter_lock(self):
        state = struck(beam(), integrator="newmark", iterations_max=50)
        worker = threading.Thread(target=state.step, args=(20000,))
        worker.start()
        turns = 0
        while worker.is_alive():
            turns += 1
        worker.join()
        # with the lock held this thread would get a turn or two
        self.assertGreater(turns, 100)

    def test_one_model_many_threads_same_bits(self):
        model = beam()
        expected = struck(model)
        expected.step(3000)
        states = [struck(model) for _ in range(4)]
        workers = [threading.Thread(target=state.step, args=(3000,)) for state in states]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        for state in states:
            np.testing.assert_array_equal(state.q, expected.q)

    def test_one_state_many_threads_takes_turns(self):
        state = struck(beam())
        workers = [threading.Thread(target=lambda: [state.step() for _ in range(500)]) for _ in range(4)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        expected = struck(beam())
        expected.step(2000)
        np.testing.assert_array_equal(state.q, expected.q)


if __name__ == "__main__":
    unittest.main()
