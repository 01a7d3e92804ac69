"""Short scenes with contact, and equilibria, with which without_contact_constants.py tries the constants of both.

Each scene is there for what its name says and takes a few hundredths of a second to some tenths; blocks have 0.1 m and 1 kg.
SPDX-License-Identifier: Apache-2.0
"""
import json
import math
import pathlib

EXAMPLES = pathlib.Path(__file__).resolve().parent.parent / "examples" / "scenes"
STIFF, SOFT = 1e9, 2e5  # Young's modulus of near-rigid and of soft blocks [Pa]
FLOOR = {"shape": "plane", "friction": 0.5, "restitution": 0.3}
ELASTIC_FLOOR = dict(FLOOR, restitution=1)
ON_CORNER = {"axis": [1, 2, 0.5], "angle": 35}
QUIET = {"record_every": 5, "plots": False, "monitor": False}


def block(name, at, young=1e6, **more):
    """A free cube about a place."""
    return {"name": name, "model": "beam:2x2x2@0.1x0.1x0.1", "material": {"young": young, "density": 1000}, "rank": 8,
            "free": True, "position": [at[0] - 0.05, at[1], at[2]], **more}


def plate(**more):
    """A plate of 2 cm, about the origin."""
    return {"name": "plate", "model": "beam:6x6x1@0.6x0.6x0.02", "material": {"young": 1e9}, "rank": 8,
            "position": [-0.3, 0, 0], **more}


def slab(side, **more):
    """A solid whose face is at a distance above or below the origin."""
    return {"shape": "box", "size": [2, 2, 1], "centre": [0, 0, math.copysign(0.5 + abs(side), side)], **more}


def scene(time, bodies, obstacles=(), gravity=9.81, slope=0.0, dt=0.002, **collisions):
    """Bodies under a gravity that is tilted by a slope."""
    angle = math.atan(slope)
    return {"dt": dt, "time": time, "gravity": [gravity * math.sin(angle), 0, -gravity * math.cos(angle)], "bodies": bodies,
            "obstacles": list(obstacles), "collisions": {"friction": 0.5, "restitution": 0.3, **collisions}, "outputs": QUIET}


def example(name, time):
    """The beginning of a scene of examples/."""
    made = json.loads((EXAMPLES / f"{name}.json").read_text(encoding="utf-8"))
    for obstacle in made.get("obstacles", []):
        if "file" in obstacle:
            obstacle["file"] = str(EXAMPLES / obstacle["file"])
    return dict(made, time=time, outputs=QUIET)


def on_obstacles():
    """One body on obstacles that points touch."""
    ball = {"shape": "sphere", "radius": 0.08, "restitution": 0.3}
    corner = {"rotation": ON_CORNER, "velocity": [-0.5, 0, -2], "spin": [60, 0, 0]}
    return {
        "soft block lands on its corner": scene(1, [block("b", (0, 0, 0.25), SOFT, rotation=ON_CORNER)], [FLOOR]),
        "soft block is thrown down": scene(0.5, [block("b", (0, 0, 0.2), SOFT, velocity=[0, 0, -6])], [FLOOR], dt=0.004),
        "block on a ball": scene(0.5, [block("b", (0.01, 0.02, 0.2), SOFT, velocity=[0, 0, -1])], [ball]),
        "stiff block bounces flat": scene(0.8, [block("b", (0, 0, 0.08), STIFF)], [ELASTIC_FLOOR]),
        "stiff block lands flat and rests": scene(1, [block("b", (0, 0, 0.08), STIFF)], [FLOOR]),
        "stiff corner strikes": scene(0.4, [block("b", (0, 0, 0.25), STIFF, **corner)], [ELASTIC_FLOOR]),
        "elastic block bounces": scene(0.5, [block("b", (0, 0, 0.1), 1e6, velocity=[0, 0, -2])], [ELASTIC_FLOOR]),
    }


def rests_and_slides():
    """Blocks that lie on others, on slopes and on a plate."""
    rough = {"friction": 0.4, "restitution": 0}
    heap = [block(f"b{n}", (0.01 * n, -0.01 * n, 0.052 + 0.102 * n), damping=2) for n in range(3)]
    stairs = [block(f"b{n}", (0.02 * n, 0, 0.0515 + 0.101 * n), STIFF) for n in range(3)]
    bar = {"model": "beam:6x2x2@0.3x0.1x0.1", "material": {"young": SOFT, "density": 1000}, "rank": 12}
    return {
        "stack": scene(0.4, heap, [FLOOR]),
        "stiff stairs": scene(0.2, stairs, [slab(-1e-4, **rough)]),
        "below the angle of friction": scene(0.6, [block("b", (0, 0, 0.0515), 1e7)], [slab(-1e-9, **rough)], slope=0.36),
        "stiff, below the angle": scene(0.6, [block("b", (0, 0, 0.0515), 5e9)], [slab(-1e-9, **rough)], slope=0.36),
        "above the angle of friction": scene(0.3, [block("b", (0, 0, 0.0515), 1e7)], [slab(-1e-9, **rough)], slope=0.52),
        "plane, below the angle": scene(0.6, [block("b", (0, 0, 0.0505), 1e7)], [dict(FLOOR, friction=0.4)], slope=0.36),
        "on the end of a plate": scene(0.3, [plate(fix="x<0.001"), block("b", (0.2, 0, 0.062))]),
        "on a curved bar": scene(0.4, [dict(bar, name="bar", fix=["x<0.001", "x>0.299"], position=[-0.15, 0, 0]),
                                       block("b", (0.03, 0.01, 0.102), STIFF, rotation={"axis": [0, 0, 1], "angle": 20})]),
        "heavy on light": scene(0.3, [block("a", (0, 0, 0.051)), block("b", (0, 0, 0.16), density=100)], [FLOOR]),
    }


def crossed(young, speed):
    """Two blocks on edge, of which the upper falls across the lower, beside the middles of both."""
    below = block("a", (0, 0, 0), young, rotation={"axis": [1, 0, 0], "angle": 45})
    above = block("b", (0, 0, 0), young, rotation={"axis": [0, 1, 0], "angle": 45}, velocity=[0, 0, -speed])
    return scene(0.1, [below, dict(above, position=[-0.025, 0.01, 0.187])], gravity=0)


def impacts():
    """Bodies that meet in flight."""
    free_plate, fast = plate(free=True), {"velocity": [0, 0, -100]}
    row = [block(f"b{n}", (0.102 * n - 0.05, 0, 0), STIFF) for n in range(1, 5)]
    shot = block("shot", (-0.08, 0.01, 0.01), STIFF, velocity=[3, 0, 0])
    spun = [block("a", (0, 0, 0), 3e5, spin=[0, 300, 900]),
            block("b", (0.3, 0.06, 0.03), 1e6, velocity=[-3, 0, 0], spin=[600, 0, -700])]
    oblique = [block("a", (0, 0, 0), STIFF), block("b", (0.25, 0.03, 0.02), 3e9, velocity=[-3, 0, 0], rotation=ON_CORNER)]
    door = {"shape": "box", "size": [0.6, 0.05, 0.3], "restitution": 0.3,
            "path": [{"time": 0, "centre": [0, 0, 0]},
                     {"time": 0.2, "centre": [0, 0, 0], "rotation": {"axis": [0, 0, 1], "angle": 170}}]}
    return {
        "soft blocks spin and meet": scene(0.3, spun, gravity=0),
        "the same at 4 ms": scene(0.3, spun, gravity=0, dt=0.004),
        "stiff blocks meet obliquely": scene(0.2, oblique, gravity=0),
        "shot at a plate's middle": scene(0.03, [free_plate, block("b", (0.02, 0, 0.93), STIFF, **fast)], gravity=0),
        "shot near a plate's rim": scene(0.03, [free_plate, block("b", (0.2, 0, 0.93), STIFF, **fast)], gravity=0),
        "soft shot at a plate": scene(0.03, [free_plate, block("b", (0.1, 0.05, 0.33), 1e7, velocity=[0, 0, -30])], gravity=0),
        "shot along a row": scene(0.05, [shot, *row], gravity=0, restitution=1),
        "stiff edges cross": crossed(STIFF, 2), "soft edges cross": crossed(SOFT, 3),
        "between two walls": scene(0.06, [block("b", (0, 0, 0), STIFF, velocity=[0, 0, -1])],
                                   [slab(side * 0.05119, friction=0, restitution=1) for side in (-1, 1)], gravity=0,
                                   thickness=0.001),
        "door that turns": scene(0.2, [block("b", (0.2, 0.12, 0))], [door], gravity=0),
    }


def scenes():
    """All scenes by their names; those of examples/ at the end."""
    return {**on_obstacles(), **rests_and_slides(), **impacts(), "drop.json": example("drop", 1),
            "collide.json": example("collide", 0.45), "shapes.json": example("shapes", 0.8)}


COLUMN = "beam:20x2x2@1x0.05x0.05 --fix x<1e-9 --modes 6 --rank 16 --young 1e6 --poisson 0 --density 1000"
THIN_COLUMN = "beam:20x1x1@1x0.05x0.05 --fix x<1e-9 --modes 8 --rank 20 --young 1e6 --poisson 0 --density 1000"

# mesh with options of thrum precompute, or a model; the load
EQUILIBRIA = {
    "beam buckles": ("beam", "constant:-30000,0,10@load"),
    "beam sags far": ("beam", "constant:0,0,-300@load"),
    "tower buckles": ("tower", "constant:0,0,-3e5@load"),
    "basket snaps": ("basket", "constant:0,0,-1000@load"),
    "heart": ("heart", "constant:0,0,-300@load"),
    "column buckles": (COLUMN, "constant:-4,0,0@tip"),
    "column far beyond": (COLUMN, "constant:-20,0,0@tip"),
    "thin column far beyond": (THIN_COLUMN, "constant:-15,0,0@tip"),
}
