"""`thrum export --fmu`: units of FMI 2.0 and 3.0 in a small importer, against the library.
SPDX-License-Identifier: Apache-2.0"""
import copy
import os
import platform
import random
import subprocess
import sys
import unittest
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
from fmu_importer import DISCARD, ERROR, OK, Fmu, faults
from support import FOLDER, beam, beam_file, block_file, model_file

import thrum

PROGRAM = os.environ["THRUM_PROGRAM"]
STEP = 0.002
PLACES = ("tip", "near:0.5,0,0")


def export(model, name, *arguments):
    path = Path(FOLDER, name)
    done = subprocess.run([PROGRAM, "export", model, "--fmu", path, *arguments], stdout=subprocess.DEVNULL,
                          stderr=subprocess.PIPE, text=True)
    return path, done


def unit(version, name="beam"):
    path, done = export(beam_file(), f"{name}.fmu", "--fmi", str(version), *(word for place in PLACES for word in ("--at", place)))
    if done.returncode != 0:
        raise AssertionError(done.stderr)
    return Fmu(path, Path(FOLDER, f"{name}-{version}"))


if platform.machine() != "x86_64" or platform.system() != "Linux":
    print("skipped: units have a library for Linux x86-64 alone")
    sys.exit()
UNITS = {version: unit(version) for version in (2, 3)}
RANK = beam().rank
Q, P = ([f"{letter}[{i + 1}]" for i in range(RANK)] for letter in "qp")
RATES = [f"der({name})" for name in Q + P]

# The state machines of the standard: what each call makes of each phase. A call that is not there is refused, and the
# instance is in error then.
SAME = object()


def stays(*phases):
    return {phase: SAME for phase in phases}


def machine(version, exchange):
    begun = ("instantiated", "set up") if version == 2 else ("instantiated",)
    running = ("event", "continuous") if exchange else ("step",)
    failed = ("failed",) if version == 2 and not exchange else ()
    after = ("terminated", "error")
    readable = ("initialization", *running, *failed, *after)
    every = (*begun, *readable)
    calls = {
        "enter": {begun[-1]: "initialization"}, "leave": {"initialization": running[0]},
        "terminate": {phase: "terminated" for phase in (*running, *failed)}, "reset": {phase: "instantiated" for phase in every},
        "get": stays(*readable), "set_input": stays(*begun, "initialization", *running),
        "set_tunable": stays(*begun, "initialization", *(phase for phase in running if phase != "continuous")),
        "set_fixed": stays(*begun, "initialization"), "set_start": stays(*begun, "initialization"), "set_output": {},
        "keep": stays(*every), "restore": {phase: "kept" for phase in every}, "serialize": stays(*every),
        "derivative": stays(*readable),
    }
    if version == 2:
        calls["set_up"] = {phase: "set up" for phase in begun}
        calls["cancel"] = {}
    else:
        calls["configure"] = calls["step_mode"] = {}
    own = {"do_step": stays("step"), "fail": {"step": "failed" if version == 2 else SAME}}
    other = {"event_mode": {"continuous": "event"}, "update": stays("event"), "continuous": {"event": "continuous"},
             "time": stays("event", "continuous"), "states": stays("continuous"), "get_states": stays(*readable),
             "rates": stays(*readable), "completed": stays("continuous")}
    for mine, theirs in ((own, other),) if not exchange else ((other, own),):
        calls.update(mine)
        calls.update({name: {} for name in theirs})
    return every, calls


class Walker:
    """Makes the calls of a walk; each returns its status."""

    def __init__(self, one):
        self.one, self.kept = one, one.keep()[1]

    def __call__(self, name):
        one = self.one
        tip = "tip.force.z"
        made = {
            "terminate": lambda: one.call("Terminate"), "reset": lambda: one.call("Reset"), "cancel": lambda: one.call("CancelStep"),
            "configure": lambda: one.call("EnterConfigurationMode"), "step_mode": lambda: one.call("EnterStepMode"),
            "get": lambda: one.get_values(["tip.displacement.x", "energy.strain"])[0],
            "set_input": lambda: one.set_values([tip], [1.0]), "set_tunable": lambda: one.set_values(["stiffness"], [1.1]),
            "set_fixed": lambda: one.set_values(["step"], [STEP]), "set_start": lambda: one.set_values(["q[1]"], [0.01]),
            "set_output": lambda: one.set_values(["energy.strain"], [1.0]),
            "keep": self.keep, "restore": lambda: one.restore(self.kept), "serialize": lambda: one.serialize(self.kept)[0],
            "derivative": lambda: one.derivative(["energy.strain"], ["q[1]"], [1.0])[0],
            "do_step": self.step, "fail": self.fail, "time": lambda: one.time(0.5), "states": lambda: one.states([0.01] * 2 * RANK),
            "get_states": lambda: one.get_states(2 * RANK)[0], "rates": lambda: one.rates(2 * RANK)[0],
        }
        return made[name]() if name in made else getattr(one, name)()

    def keep(self):
        self.one.drop(self.kept)
        status, self.kept = self.one.keep()
        return status

    def step(self):
        status, now = self.one.get_values(["time"])
        return self.one.step(now[0], STEP) if status == OK else status

    def fail(self):
        # no load may be as large; the step is not taken
        self.one.set_values(["tip.force.z"], [1e250])
        status = self.step()
        if status == DISCARD:
            self.one.set_values(["tip.force.z"], [0.0]) if not self.one.two else None
            return OK
        return status


class Units(unittest.TestCase):
    def near(self, one, other, share):
        one, other = np.asarray(one), np.asarray(other)
        self.assertEqual(one.shape, other.shape)
        self.assertLessEqual(abs(one - other).max(), share * abs(other).max())

    def test_descriptions_follow_the_schema(self):
        for version, fmu in UNITS.items():
            self.assertEqual(faults(fmu.root), [])
            self.assertEqual([name for name in fmu.variables if fmu.causality(name) == "input"][3:],
                             [f"{place}.force.{axis}" for place in PLACES for axis in "xyz"])

            # and the rules find what breaks them
            for breaking in (lambda r: r.find("ModelStructure")[0].clear() if version == 3 else r.find("ModelStructure")[0][0].clear(),
                             lambda r: r.find("ModelVariables")[9].set("name", "time"),
                             lambda r: r.insert(0, r.find("ModelVariables")), lambda r: r.set("colour", "red"),
                             lambda r: r.find("ModelVariables")[8].set("initial", "exact")):
                root = copy.deepcopy(fmu.root)
                breaking(root)
                self.assertNotEqual(faults(root), [])

    def test_every_order_of_calls_is_allowed_or_refused_as_the_standard_says(self):
        for version, fmu in UNITS.items():
            for exchange in (False, True):
                phases, calls = machine(version, exchange)
                chance = random.Random(version)
                one = fmu.instance(exchange)
                walker, phase, kept, seen = Walker(one), "instantiated", "instantiated", set()
                want = {(phase, call) for phase in phases for call in calls}

                # at random, until each call was made in each phase: one that is new here, or one that is allowed
                for _ in range(20000):
                    allowed = [call for call in calls if phase in calls[call]]
                    new = [call for call in calls if (phase, call) not in seen]
                    call = chance.choice(new if new and chance.random() < 0.2 else allowed)
                    one.said.clear()
                    status = walker(call)
                    self.assertEqual(status, OK if call in allowed else ERROR, (version, exchange, phase, call, one.said))
                    self.assertTrue(status == OK or len(one.said) > 0 and "\n" not in one.said[-1])
                    seen.add((phase, call))

                    # where that leads
                    follows = calls[call].get(phase, "error")
                    if call == "keep":
                        kept = phase
                    phase = kept if follows == "kept" else phase if follows is SAME else follows
                    if seen == want:
                        break
                self.assertEqual(want - seen, set())
                one.free()
            self.assertEqual(fmu.function("Reset")(None), ERROR)

    def test_a_pulled_bar_moves_as_in_the_library(self):
        model = beam()
        load = model.external_load((0, 0, -10), group="tip") - model.external_load(gravity=(0, 0, 2.0))
        for version, fmu in UNITS.items():
            one = fmu.instance()
            self.assertEqual(one.begin(damping_alpha=0.5, damping_beta=1e-4, step=STEP), [OK] * 4)
            self.assertEqual(one.set(tip_force_z=-10.0, acceleration_z=2.0), OK)
            with model.state(integrator="energy", dt=STEP, tolerance=1e-13, damping_alpha=0.5, damping_beta=1e-4) as state:
                state.force = load

                # fifty communication steps of four steps each
                for n in range(50):
                    self.assertEqual(one.step(4 * n * STEP, 4 * STEP), OK, one.said)
                    state.step(4)
                tip = model.group("tip")
                self.near(one.get(*Q), state.q, 1e-9)
                self.near(one.get(*P), state.p, 1e-7)
                self.near(one.get(*(f"tip.displacement.{a}" for a in "xyz")), model.displacement(state.q)[tip].mean(0), 1e-9)
                self.near(one.get(*(f"tip.velocity.{a}" for a in "xyz")), model.displacement(state.p)[tip].mean(0), 1e-7)
                self.near(one.get("energy.strain", "energy.kinetic"),
                          [model.strain_energy(state.q), 0.5 * state.p @ state.p], 1e-7)
            one.free()

    def test_stiffness_is_that_of_the_scaled_model_and_the_energy_stays(self):
        stiff = beam().scale(stiffness=2.5)
        for version, fmu in UNITS.items():
            one = fmu.instance()
            one.begin(stiffness=2.5, step=STEP, **{"p[1]": 5.0})
            self.near(one.get("energy.kinetic", "energy.strain"), [12.5, 0.0], 1e-14)
            with stiff.state(integrator="energy", dt=STEP, tolerance=1e-13) as state:
                state.set(p=5.0 * np.eye(RANK)[0])
                for n in range(100):
                    one.step(n * STEP, STEP)
                state.step(100)
                self.near(one.get(*Q), state.q, 1e-8)
            self.near(sum(one.get("energy.kinetic", "energy.strain")), 12.5, 1e-11)
            self.assertGreater(max(map(abs, one.get(*(f"tip.displacement.{a}" for a in "xyz")))), 0.005)

    def test_a_state_comes_back_and_goes_to_another_instance(self):
        for version, fmu in UNITS.items():
            one = fmu.instance()
            one.begin(start=1.0, step=STEP, **{"q[1]": 0.1})
            one.set(tip_force_z=-30.0)
            one.step(1.0, 0.02)
            status, kept = one.keep()
            data = one.serialize(kept)[1]
            names = [*Q, *P, "time"]
            one.step(1.02, 0.05)
            after = one.get(*names)

            # the same bits again, here and elsewhere, from bytes too
            self.assertEqual(one.restore(kept), OK)
            one.step(1.02, 0.05)
            self.assertEqual(one.get(*names), after)
            other = fmu.instance()
            self.assertEqual(other.restore(other.deserialize(data)[1]), OK)
            other.step(1.02, 0.05)
            self.assertEqual(other.get(*names), after)

            # what is no state is refused, and changes nothing
            for broken in (data[:-1], b"x" + data[1:], data[:40] + b"\3\0\0\0" + data[44:], data[:-8 * 20] + b"\xff" * 8 * 20):
                self.assertEqual(other.deserialize(broken)[0], ERROR)
                self.assertEqual(other.get(*names), after)
            self.assertEqual(one.drop(kept), OK)
            one.free()
            other.free()

    def test_derivatives_are_those_of_differences(self):
        for version, fmu in UNITS.items():
            one = fmu.instance()
            start = dict(zip(Q + P, 0.05 * np.random.default_rng(5).standard_normal(2 * RANK)))
            one.set_up()
            one.enter()
            one.set(damping_alpha=0.3, damping_beta=1e-3, stiffness=1.5, tip_force_x=2.0, **start)
            knowns = [*Q, *P, "damping.alpha", "damping.beta", "stiffness", "acceleration.y", "tip.force.z",
                      "near:0.5,0,0.force.x"]
            unknowns = [*fmu.outputs(), *RATES]
            jacobian = np.array([one.derivative(unknowns, [known], [1.0])[1] for known in knowns]).T
            for known, column in zip(knowns, jacobian.T):
                at, = one.get(known)
                # what is linear may be far apart
                linear = {"damping.alpha": 0.2, "acceleration.y": 1e3, "tip.force.z": 1e3, "near:0.5,0,0.force.x": 1e3}
                change = linear.get(known, 1e-5 * max(abs(at), 0.1))
                ends = []
                for sign in (1, -1):
                    self.assertEqual(one.set_values([known], [at + sign * change]), OK)
                    ends.append(np.array(one.get(*unknowns)))
                one.set_values([known], [at])
                self.near(column, (ends[0] - ends[1]) / (2 * change), 1e-5)

            # all at once, and transposed
            seed = np.arange(1.0, len(knowns) + 1)
            self.near(one.derivative(unknowns, knowns, seed)[1], jacobian @ seed, 1e-12)
            if version == 3:
                seed = np.arange(1.0, len(unknowns) + 1)
                self.near(one.derivative(unknowns, knowns, seed, adjoint=True)[1], jacobian.T @ seed, 1e-12)
            for wrong in ((["q[1]"], ["p[1]"]), (["energy.strain"], ["energy.kinetic"])):
                self.assertEqual(one.derivative(*wrong, [1.0])[0], ERROR)
            one.free()

    def test_model_exchange_is_the_same_motion(self):
        for version, fmu in UNITS.items():
            one, other = fmu.instance(exchange=True), fmu.instance()
            for instance in (one, other):
                self.assertEqual(instance.begin(step=1e-4, damping_alpha=1.0), [OK] * 4)
            self.assertEqual([one.update(), one.continuous()], [OK, OK])
            for instance in (one, other):
                instance.set(tip_force_z=-10.0)

            # the classical Runge-Kutta method outside, the energy step inside
            x, h = np.array(one.get_states(2 * RANK)[1]), 2e-5

            def rate(time, at):
                one.time(time)
                one.states(at)
                return np.array(one.rates(2 * RANK)[1])

            for n in range(500):
                a = rate(n * h, x)
                b = rate((n + 0.5) * h, x + 0.5 * h * a)
                c = rate((n + 0.5) * h, x + 0.5 * h * b)
                x = x + h / 6 * (a + 2 * b + 2 * c + rate((n + 1) * h, x + h * c))
                one.completed()
            other.step(0.0, 500 * h)
            one.states(x)
            self.near(one.get("tip.displacement.z"), other.get("tip.displacement.z"), 1e-4)

    def test_what_cannot_be_is_refused_with_one_line(self):
        for version, fmu in UNITS.items():
            one = fmu.instance()
            status, fresh = one.keep()
            self.assertEqual(one.begin(stop=1.0), [OK] * 4)
            for at, length, said in ((0.0, -0.1, "time goes forward"), (0.0, 0.0, "time goes forward"),
                                     (0.5, 0.1, "the body is at 0 s"), (0.0, 1.5, "past the end"),
                                     (0.0, float("nan"), "time goes forward"), (0.0, float("inf"), "time goes forward")):
                kept = one.keep()[1]
                self.assertEqual(one.step(at, length), ERROR)
                self.assertIn(said, one.said[-1])
                self.assertEqual(one.restore(kept), OK)
                one.drop(kept)

            # values out of range are not taken, and the instance goes on
            for name, value in (("tip_force_x", float("nan")), ("damping_alpha", -1.0), ("stiffness", 0.0)):
                before = one.get(name.replace("_", "."))
                self.assertEqual(one.set(**{name: value}), DISCARD)
                self.assertEqual(one.get(name.replace("_", ".")), before)

            # a step that is not solved leaves the motion as it was
            self.assertEqual(one.step(0.0, 0.01), OK)
            before = one.get(*Q, *P)
            one.set(tip_force_z=1e250)
            self.assertEqual(one.step(0.01, 0.01), DISCARD)
            self.assertEqual(one.get(*Q, *P, "time"), [*before, 0.01])
            self.assertEqual(one.call("GetReal" if version == 2 else "GetFloat64", one.names(["time"]), 0, None, 0), OK)

            # instances of other tokens, of no resources, without a name
            for wrong in ({"token": "{0}"}, {"folder": "/nowhere"}, {"name": b""}):
                none = fmu.instance(**wrong)
                self.assertIsNone(none.at)
                self.assertEqual(len(none.said), 1)
            one.free()

    def test_sources_compile_alone_and_with_a_prefix(self):
        warnings = ("-std=c11", "-O1", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off")
        for version, fmu in UNITS.items():
            sources = fmu.folder / "sources"
            root = fmu.root if version == 2 else ET.parse(sources / "buildDescription.xml").getroot()
            files = sorted({f.get("name") for f in root.iter("File" if version == 2 else "SourceFile")})
            library = fmu.folder / "own.so"
            subprocess.run(["gcc", *warnings, "-fsanitize=undefined", "-fno-sanitize-recover=all", "-shared", "-fPIC",
                            f"-DFMI{version}_OVERRIDE_FUNCTION_PREFIX", *files, "-lm", "-o", library], cwd=sources, check=True)
            own = Fmu(Path(FOLDER, "beam.fmu"), Path(FOLDER, "own"), library) if version == 3 else None

            # the motion of a library that was compiled here, which watches what C leaves undefined
            found = []
            for used in (fmu, own) if own else (fmu,):
                one = used.instance()
                one.begin(step=STEP)
                one.set(tip_force_z=-20.0)
                one.step(0.0, 0.1)
                one.derivative([*fmu.outputs(), *RATES], [*Q, "stiffness"], [1.0] * (RANK + 1))
                found.append(one.get(*Q))
            self.assertTrue(all(q == found[0] for q in found))

            # and all names of a static one begin with the name of the model
            subprocess.run(["gcc", *warnings, "-c", *files], cwd=sources, check=True)
            objects = [Path(name).with_suffix(".o") for name in files]
            listed = subprocess.run(["nm", "-g", "--defined-only", *objects], cwd=sources, check=True, stdout=subprocess.PIPE,
                                    text=True).stdout
            defined = [line.split()[2] for line in listed.splitlines() if len(line.split()) == 3]
            self.assertGreater(len(defined), 50)
            self.assertEqual([name for name in defined if not name.startswith("beam_")], [])

    def test_what_is_no_unit_is_refused(self):
        condensed = model_file("condensed", "beam:4x1x1@1x0.1x0.1", fix="x<0.001", modes=4, rank=8, condense=True)
        for model, name, arguments, said in (
                (block_file(), "block.fmu", (), "the body is free"), (condensed, "no.fmu", (), "follow the others at rest"),
                (beam_file(), "no-name.fmu", (), "letters, digits and underscores"), (beam_file(), "beam.zip", (), "end with .fmu"),
                (beam_file(), "no.fmu", ("--at", "nose"), "nose"), (beam_file(), "no.fmu", ("--at", "near:0,0,0"), "is held"),
                (beam_file(), "no.fmu", ("--at", "tip", "--at", "tip"), "two places"), (beam_file(), "no.fmu", ("--fmi", "1"), "fmi")):
            path, done = export(model, name, *arguments)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(said, done.stderr)
            self.assertFalse(path.exists())


if __name__ == "__main__":
    unittest.main()
