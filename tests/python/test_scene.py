"""Scenes from Python. SPDX-License-Identifier: Apache-2.0"""
import gc
import json
import math
import subprocess
import unittest
import weakref

import numpy as np
from support import beam, block, model_file

import thrum
from thrum import _fields, _keywords
from thrum._native import lib


def shown_by(thing):
    """Arrays that the properties of an object show, each with its name."""
    for name in dir(type(thing)):
        if name.startswith("_") or not isinstance(getattr(type(thing), name), property):
            continue
        values = [getattr(thing, name)]
        while values:
            value = values.pop()
            if isinstance(value, dict):
                values += value.values()
            elif isinstance(value, (list, tuple)):
                values += value
            elif isinstance(value, np.ndarray):
                yield f"{type(thing).__name__}.{name}", value


class Objects(unittest.TestCase):
    def test_arrays_of_properties_are_read_only_and_reprs_say_what_things_are(self):
        model = block()
        state = model.state()
        rest = beam().equilibrium(beam().external_load((0, 0, -1e-3), group="tip"))
        scene = thrum.Scene(dt=0.002)
        body = scene.add_body(model, free=True, triangles=model.outer_triangles())
        pull = body.pull(0, (0, 0, 1), 100.0)
        link = scene.add_link("spring", body, place=(0, 0, 0), other_place=(0, 0, 1), stiffness=10.0)
        scene.step()
        things = [model, state, state.energies, state.report, model.batch([state]), rest, model.monitor(),
                  model.surface(), model.stress_nodes(), model.stress_points(), model.stress_points().read(state.q),
                  model.stress_nodes().read(state.q), scene, body, pull, link, thrum.Obstacle(), thrum.Load(force=(0, 0, 1)),
                  thrum.Mesh(model.vertices, model.tets)]
        found = [pair for thing in things for pair in shown_by(thing)]
        self.assertGreater(len(found), 20)
        self.assertEqual([name for name, array in found if array.flags.writeable], [])

        # no address, no array, and one line
        for thing in things:
            self.assertNotRegex(repr(thing), " at 0x|array\\(|\n")
            self.assertLess(len(repr(thing)), 900)


class Fields(unittest.TestCase):
    def test_rows_are_the_keywords_and_the_keys_of_scene_files(self):
        """Names, defaults and ranges of thrum/fields.h, as C, scene files and the keywords have them."""
        schema = json.loads(subprocess.run([thrum.program(), "schema", "scene"], check=True, capture_output=True, text=True).stdout)
        keys = schema["properties"]
        obstacles = keys["obstacles"]["items"]
        parts = {"body": keys["bodies"]["items"], "obstacle": obstacles, "solid": obstacles, "link": keys["links"]["items"],
                 "contact between bodies": keys["collisions"], "wind": keys["wind"]}
        words = {"body": _keywords.BodyOptions, "obstacle": _keywords.ObstacleOptions, "solid": _keywords.SolidOptions,
                 "link": _keywords.LinkOptions, "contact between bodies": _keywords.PairsOptions, "wind": _keywords.WindOptions,
                 "load": _keywords.LoadOptions}
        own = {"body": {"touch"}, "link": {"kind"}, "wind": {"velocity"},
               "load": {"kind", "vector", "vertices", "field", "reduced", "parts", "moments", "resultant", "from"}}
        added = {"load": {"start"}}
        checked = 0
        for record, fields in _fields._FIELDS.items():
            self.assertEqual(set(words[record].__annotations__), set(fields) - own.get(record, set()) | added.get(record, set()))
            made = _fields.Def(record)
            for name, field in fields.items():
                if not field.key or record == "load":  # a text of scene files has those
                    continue
                key = parts[record]["properties"][name]
                if "default" in key and field.kind != lib.THRUM_FIELD_FLOAT:
                    found = made.get(name)
                    self.assertEqual(list(found) if isinstance(found, tuple) else found, key["default"], (record, name))
                    checked += 1
                least = key.get("exclusiveMinimum", key.get("minimum"))
                if least is not None:
                    self.assertEqual((least, "exclusiveMinimum" in key), (field.least, bool(field.above)), (record, name))
                self.assertEqual(key.get("maximum", math.inf), field.most if key.get("type") in ("number", "integer") else math.inf)
        self.assertGreater(checked, 20)

    def test_an_option_that_is_wrong_is_refused_by_its_name(self):
        with thrum.Scene() as scene:
            for call, wrong in ((lambda **options: scene.add_body(block(), **options), {"scale": -1.0}),
                                (lambda **options: scene.add_body(block(), **options), {"velocity": (0, math.inf, 0)}),
                                (scene.add_solid, {"segments": 2}), (scene.set_collisions, {"restitution": 1.5}),
                                (lambda **options: scene.add_obstacle(thrum.Obstacle(**options)), {"friction": -1.0})):
                with self.subTest(wrong), self.assertRaisesRegex(thrum.BadValue, f"^{list(wrong)[0]} is "):
                    call(**wrong)
            self.assertEqual(scene.bodies, [])

    def test_solids_of_all_shapes_are_touched(self):
        """A block that falls on each shape is held up by it."""
        corners = [(x, y, z) for z in (-0.1, 0) for y in (-1, 1) for x in (-1, 1)]
        faces = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6),
                 (1, 3, 5), (3, 7, 5)]
        shapes = ({"shape": "box", "half": (1, 1, 0.1), "position": (0, 0, -0.1)},
                  {"shape": "cylinder", "radius": 1.0, "height": 0.2, "position": (0, 0, -0.1)},
                  {"shape": "capsule", "radius": 0.5, "height": 1.0, "position": (0, 0, -1.0)},
                  {"shape": "height_field", "heights": np.zeros((3, 4)), "spacing": (1.0, 1.0)},
                  {"shape": "mesh", "vertices": corners, "triangles": faces})
        model = block()
        for solid in shapes:
            with self.subTest(solid["shape"]), thrum.Scene(dt=0.002, gravity=(0, 0, -9.81)) as scene:
                self.assertEqual(scene.add_solid(**solid), 0)
                body = scene.add_body(model, free=True, triangles=model.outer_triangles(), position=(0, 0, 0.11))
                scene.step(150)
                self.assertGreater(body.matrix[2, 3], 0.05)
                touched = [touch.bodies for touch in scene.touches]
                self.assertTrue(all(set(map(type, bodies)) == {thrum.Body, int} for bodies in touched), touched)
                np.testing.assert_allclose(body.contact_force(solid=0), body.contact_force())


class Scenes(unittest.TestCase):
    def test_free_fall(self):
        """A free body falls by g t^2 / 2, and keeps its energy."""
        scene = thrum.Scene(dt=0.001, gravity=(0, 0, -9.81))
        body = scene.add_body(block(), "stone", free=True, position=(0, 0, 10.0))
        start = body.matrix[2, 3]
        before = body.energies["total"]
        self.assertEqual(scene.step(1000), thrum.Status.OK)
        self.assertAlmostEqual(scene.time, 1.0, 9)
        self.assertAlmostEqual(start - body.matrix[2, 3], 0.5 * 9.81, 9)
        self.assertAlmostEqual(body.energies["total"], before, 8)

    def test_spin_stretches(self):
        """A coupled body that spins has strain energy, and keeps the sum."""
        scene = thrum.Scene(dt=0.002)
        body = scene.add_body(block(), free=True, coupled=True, spin=(3, 40, 5), stiffness=0.01)
        before = body.energies["total"]
        scene.step(500)
        self.assertGreater(body.energies["potential"], 0)
        self.assertAlmostEqual(body.energies["total"] / before, 1, 12)
        with self.assertRaises(thrum.Error):
            scene.add_body(block(), free=True, coupled=True, integrator="newmark")

    def test_bounce(self):
        scene = thrum.Scene(dt=0.001, gravity=(0, 0, -9.81))
        model = block()
        body = scene.add_body(model, free=True, triangles=model.outer_triangles(), touch="all", position=(0, 0, 0.3))
        number = scene.add_obstacle(thrum.Obstacle(restitution=0.3))
        self.assertEqual(scene.obstacle(number).restitution, 0.3)
        touched = 0
        for _ in range(1500):
            scene.step()
            touched += body.touching > 0
        self.assertGreater(touched, 0)
        surface = model.surface()
        world = body.positions(surface) @ body.matrix[:3, :3].T + body.matrix[:3, 3]
        self.assertGreater(world[:, 2].min(), -0.02)

    def test_fewer_coordinates_do_not_lock(self):
        """With half and a third of its coordinates a body swings as far: the others follow."""
        model = beam()
        tip = int(model.group("tip")[0])

        def furthest(rank=0, later=0, of=model):
            scene = thrum.Scene(dt=0.002)
            body = scene.add_body(of, rank=rank)
            if later:
                body.set_rank(later)
            body.add_load(thrum.Load(force=(0, 0, -140), group="tip"))
            far = 0.0
            for _ in range(150):
                scene.step()
                far = max(far, abs(body.vertex(tip)[0][2] - model.vertices[tip, 2]))
            return far

        whole = furthest()
        self.assertGreater(whole, 0.1)
        for rank in (6, 4):
            self.assertLess(abs(furthest(rank) / whole - 1), 0.03)
            self.assertLess(abs(furthest(later=rank) / whole - 1), 0.03)

            # and without a scene
            fewer = model.truncate(rank)
            self.assertEqual((fewer.rank, fewer.shown), (rank, model.rank))
            state, far = fewer.state(integrator="energy", dt=0.002), 0.0
            load = model.external_load(force=(0, 0, -140), group="tip")
            for _ in range(150):
                state.set_load(load)
                state.step()
                shape = fewer.shape(state.q, load)
                far = max(far, abs(model.displacement(shape)[tip, 2]))
            self.assertLess(abs(far / whole - 1), 0.03)
        self.assertIs(model.truncate(model.rank), model)

    def test_level_of_detail(self):
        """A far body steps fewer coordinates, and comes back where the eye does."""
        scene = thrum.Scene()
        body = scene.add_body(beam(), "arm", start_mode=1, start_amplitude=0.01)
        self.assertEqual(body.detail["set"], 0)
        body.set_detail(2, 0.01, beyond=20.0)
        scene.set_eye((100.0, 0, 0))
        scene.update_detail()
        scene.step(50)
        self.assertEqual(body.detail["reduced_steps"], 50)
        self.assertLessEqual(body.detail["largest_jump"], 0.01)
        scene.set_eye((0, 0, 0))
        scene.update_detail()
        self.assertEqual((body.detail["reduced"], body.detail["changes"]), (0, 2))
        body.clear_detail()
        body.set_condensed(3)
        scene.step(10)
        self.assertEqual(body.detail["set"], 0)
        with self.assertRaises(thrum.Error):
            body.set_detail(3, 0.01, beyond=1.0)

    def test_loads_pulls_and_changes(self):
        scene = thrum.Scene()
        model = beam()
        body = scene.add_body(model, "arm", integrator="imexv", state={"damping_alpha": 1.0})
        body.add_load(thrum.Load(force=(0, 0, -40), group="tip", until=0.3))
        body.add_load(thrum.Load(acceleration=(0, 1, 0), frequency=2.0))
        scene.step(100)
        tip = int(model.group("tip")[0])
        position, velocity = body.vertex(tip)
        self.assertLess(position[2], model.vertices[tip, 2])
        self.assertTrue(np.isfinite(velocity).all())
        pull = body.pull(tip, position + [0, 0, 0.2], stiffness=200.0)
        scene.step(50)
        self.assertGreater(pull.force[2], 0.0)
        pull.move(position)
        pull.end()
        body.set_damping(5.0)
        body.set_stiffness(2.0)
        body.set_rank(8)
        body.set_integrator("energy")
        scene.dt = 0.002
        scene.step(10)
        self.assertEqual((len(body.q), body.report.scheme), (model.rank, "energy"))
        self.assertIs(scene.find("arm"), body)
        with self.assertRaises(KeyError):
            scene.find("leg")

    def test_bodies_act(self):
        model = thrum.Model.load(model_file("acting", "beam:4x1x1@1x0.1x0.1", fix="x<0.001", order=1, young=1e6, modes=2, rank=4,
                                            actuator=["heat=swell:all", "lean=muscle:all,1,0,1"]))
        scene, state = thrum.Scene(dt=0.002), thrum.State(model, dt=0.002)
        body = scene.add_body(model)
        body.add_actuation("heat", 0.01, thrum.Load(force=(0, 0, 0), until=0.05))
        body.add_actuation("lean", 0.02)
        for step in range(50):
            state.actuation = {"heat": 0.01 if step < 25 else 0.0, "lean": 0.02}
            state.step()
        scene.step(50)
        np.testing.assert_array_equal(body.q, state.q)
        with self.assertRaises(KeyError):
            body.add_actuation("wire", 1.0)

        # it steps all of its coordinates, and says so before it would fail in a step
        for follow in (lambda: body.set_rank(2), lambda: body.set_condensed(2), lambda: body.set_detail(2, 1e-3, still=0.1)):
            with self.assertRaises(thrum.Unsupported):
                follow()
        scene.step(1)
        other = scene.add_body(model)
        other.set_detail(2, 1e-3, still=0.1)
        with self.assertRaises(thrum.Unsupported):
            other.add_actuation("heat", 0.01)

    def test_bodies_touch_each_other(self):
        scene, model = thrum.Scene(dt=0.002), block()
        triangles = model.outer_triangles()
        height = np.ptp(model.vertices[:, 2])
        # soft enough to stay in touch for several steps
        low = scene.add_body(model, "low", free=True, triangles=triangles, stiffness=0.01)
        high = scene.add_body(model, "high", free=True, triangles=triangles, position=(0, 0, 1.2 * height),
                              velocity=(0, 0, -1), stiffness=0.01)
        scene.set_collisions(friction=0.3, restitution=0.5)
        self.assertIsNone(scene.find_overlap())
        before, touches = scene.account, []
        while scene.steps < 200 and not touches:
            scene.step()
            touches = scene.touches
        self.assertEqual({touches[0].bodies[0].name, touches[0].bodies[1].name}, {"low", "high"})
        self.assertGreater(touches[0].force[2] * touches[0].normal[2], 0.0)

        # what one feels of the other is what all places together do, and the opposite of what the other feels
        felt = high.contact_force(low)
        places = sum((1 if touch.bodies[0] is high else -1) * (touch.force + touch.impulse / 0.002) for touch in touches)
        np.testing.assert_allclose(felt, places, rtol=1e-12, atol=1e-12 * abs(felt).max())
        np.testing.assert_array_equal(felt, -low.contact_force())
        with self.assertRaises(TypeError):
            high.contact_force(low, obstacle=0)
        scene.step(100)
        after = scene.account
        self.assertGreater(low.vertex(0)[1][2] * -1, 0.0)
        np.testing.assert_allclose(after["momentum"], before["momentum"], atol=1e-12 * abs(before["momentum"]).max())
        self.assertLess(after["total"], before["total"])
        self.assertLess(scene.collisions["deepest_share"], 1.0)

        # without it they pass through each other
        other = thrum.Scene()
        first = other.add_body(model, "a", free=True, triangles=triangles)
        other.add_body(model, "b", free=True, triangles=triangles, position=(0, 0, 0.3 * height))
        other.add_body(model, "c", free=True, triangles=triangles, collide=False)
        other.set_collisions()
        overlap = other.find_overlap()
        self.assertIn(first, (overlap.body, overlap.other))
        self.assertIsNone(overlap.obstacle)
        self.assertGreater(overlap.depth, 0.0)
        other.set_collisions(False)
        self.assertIsNone(other.find_overlap())
        self.assertEqual(other.collisions["steps"], 0)
        with self.assertRaisesRegex(TypeError, "thickness"):
            other.set_collisions(bounce=1)
        with self.assertRaises(ValueError):
            other.set_collisions(restitution=2)

        # a body that touches itself needs its triangles
        other.add_body(model, "d", free=True, triangles=triangles, self_contact=True, position=(0, 0, 9 * height))
        other.step()
        self.assertEqual(other.collisions["steps"], 1)
        self.assertEqual(other.collisions["touching"], 0)
        with self.assertRaisesRegex(thrum.Error, "triangles"):
            other.add_body(model, "e", free=True, self_contact=True)

    def test_joints_keep_bodies_together(self):
        """Two blocks on a hinge fly as one: places stay together, momentum and energy stay."""
        scene, model = thrum.Scene(dt=0.002), block()
        first = scene.add_body(model, "first", free=True, velocity=(1, 0, 0))
        second = scene.add_body(model, "second", free=True, position=(0.2, 0, 0), velocity=(1, 0, 0))
        hinge = scene.add_link("hinge", first, place=(0.2, 0.1, 0), other=second, axis=(0, 1, 0))
        first.add_load(thrum.Load(force=(0, 0, 30), vertices=[0], until=0.1))
        scene.step(60)
        before = scene.account
        scene.step(200)
        after = scene.account
        self.assertEqual((hinge.kind, hinge.holds, hinge.bodies), ("hinge", True, (first, second)))
        np.testing.assert_allclose(hinge.places[0], hinge.places[1], atol=1e-12)
        self.assertGreater(np.linalg.norm(hinge.force), 0.0)
        self.assertLess(hinge.report["largest_drift"], 1e-12)
        np.testing.assert_allclose(after["momentum"], before["momentum"], atol=1e-11 * abs(before["momentum"]).max())
        self.assertAlmostEqual(after["total"] / before["total"], 1.0, 9)

        # let go they part
        hinge.release()
        scene.step(50)
        self.assertFalse(hinge.holds)
        self.assertGreater(np.linalg.norm(hinge.places[0] - hinge.places[1]), 1e-4)

    def test_springs_and_handles(self):
        """A spring bears a weight, a handle goes along its path and lets go at its time."""
        scene, model = thrum.Scene(dt=0.002, gravity=(0, 0, -9.81)), block()
        mass = 0.2 ** 3 * model.material[0, 2]
        weight = scene.add_body(model, "weight", free=True, state={"damping_alpha": 5.0})
        spring = scene.add_link("spring", weight, other_place=(0.1, 0, 1), stiffness=50 * mass, damping=10 * mass)
        self.assertAlmostEqual(spring.length, 1.0, 12)
        scene.step(3000)
        self.assertAlmostEqual(spring.force[2], 9.81 * mass, delta=1e-6 * mass)
        self.assertAlmostEqual(scene.account["links"], spring.report["stored"], 12)

        held = thrum.Scene(dt=0.002)
        arm = beam()
        body = held.add_body(arm, "arm", state={"damping_alpha": 1.0})
        handle = held.add_link("ball", body, group="tip", until=0.5, path_times=[0, 0.3],
                               path_places=[(0, 0, 0), (0, 0, 0.05)])
        start = arm.vertices[arm.group("tip")].mean(axis=0)
        held.step(200)
        np.testing.assert_allclose(handle.places[0], start + (0, 0, 0.05), atol=1e-9)
        self.assertGreater(handle.report["driven"], 0.0)
        held.step(200)
        self.assertFalse(handle.holds)
        self.assertEqual(handle.bodies, (body, None))

    def test_links_that_are_refused(self):
        scene, model = thrum.Scene(), block()
        body = scene.add_body(model, free=True)
        stranger = thrum.Scene().add_body(model, free=True)
        for wrong in ({"kind": "rope"}, {"body": stranger}, {"vertices": [0], "group": "tip"}, {"vertices": [10 ** 6]},
                      {"other_vertices": [0]}, {"path_times": [0.0]}, {"path_times": [0, 1], "path_places": [(0, 0, 0)]},
                      {"length": -1}, {"other": body}, {"axis": (0, 0, 0)}, {"stiffness": math.nan}):
            with self.subTest(wrong), self.assertRaises(ValueError):
                scene.add_link(**{"kind": "spring", "body": body, **wrong})
        self.assertEqual(scene.links, [])

    def test_ground_and_wind(self):
        scene = thrum.Scene()
        model = beam()
        body = scene.add_body(model, triangles=model.outer_triangles())
        scene.set_wind((0, 20, 0))
        times = np.linspace(0, 1, 11)
        scene.add_base_motion(times, np.stack([np.zeros(11), np.zeros(11), np.sin(6 * times)], axis=1))
        del times
        gc.collect()
        scene.step(300)
        self.assertGreater(np.abs(body.q).max(), 0.0)

    def test_snapshot_and_reset(self):
        scene = thrum.Scene(gravity=(0, 0, -9.81))
        body = scene.add_body(beam(), start_mode=1, start_amplitude=0.05)
        scene.step(20)
        kept = scene.snapshot()
        scene.step(20)
        end = body.q
        scene.restore(kept)
        scene.step(20)
        np.testing.assert_array_equal(body.q, end)
        scene.reset()
        self.assertEqual((scene.steps, scene.time), (0, 0.0))
        with self.assertRaises(thrum.BadFile):
            scene.restore(b"nothing")

    def test_refusals(self):
        scene = thrum.Scene()
        model = beam()
        for options in ({"free": True}, {"position": (0, 0)}, {"rotation": (0, 0, 0, 0)}, {"touch": "all"},
                        {"triangles": [[0, 1, 500]]}, {"rank": 13}):
            with self.assertRaises((ValueError, LookupError)):
                scene.add_body(model, **options)
        with self.assertRaises(TypeError):
            scene.add_body(model, size=3)
        self.assertEqual(scene.bodies, [])
        body = scene.add_body(model)
        for load in (thrum.Load(), thrum.Load(force=(1, 0, 0), acceleration=(1, 0, 0)), thrum.Load(force=(1, np.nan, 0))):
            with self.assertRaises(ValueError):
                body.add_load(load)
        # a start where it once stood makes no ramp
        with self.assertRaises(TypeError):
            thrum.Load((0, 0, 1), None, None, None, None, 0.5)
        with self.assertRaises(ValueError):
            scene.add_obstacle(thrum.Obstacle(shape="cone"))
        with self.assertRaises(ValueError):
            scene.add_obstacle(thrum.Obstacle(radius=-1, shape="sphere"))
        with self.assertRaises(thrum.Error):
            thrum.Scene(dt=0)

    def test_a_surface_of_another_model_is_refused(self):
        scene = thrum.Scene()
        body = scene.add_body(block())
        for other in (beam(), block().scale(stiffness=2.0)):
            with self.assertRaisesRegex(thrum.ModelMismatch, "another model"):
                body.positions(other.surface())
        self.assertEqual(body.positions(block().surface()).shape, (27, 3))

    def test_a_copy_refuses_to_be_written_to(self):
        scene = thrum.Scene(gravity=(0, 0, -9.81))
        body = scene.add_body(block(), free=True)
        for array in (body.q, body.p, body.matrix, scene.gravity):
            with self.assertRaisesRegex(ValueError, "read-only"):
                array[0] = 1.0

    def test_scene_keeps_its_models(self):
        scene = thrum.Scene()
        model = beam()
        handle = weakref.ref(model._shared)
        body = scene.add_body(model)
        body.model = None
        del model
        gc.collect()
        self.assertIsNotNone(handle())
        scene.step(5)
        scene.close()
        gc.collect()
        self.assertIsNone(handle())
        with self.assertRaisesRegex(ValueError, "closed"):
            scene.step()


if __name__ == "__main__":
    unittest.main()
