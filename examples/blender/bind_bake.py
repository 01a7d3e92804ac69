"""Binds a run of Thrum to a mesh in Blender: the surface at rest, its vertex cache, frames, light and a camera.

First export the run, then open it:

    thrum export run --obj body.obj --mdd body.mdd --fps 24
    blender --python bind_bake.py -- body.obj body.mdd
    blender --background --python bind_bake.py -- body.obj body.mdd --check --render 12 frame.png --save body.blend

--check prints the number of frames and the place of a vertex in each of some, as Blender evaluates them.
SPDX-License-Identifier: Apache-2.0
"""
import argparse
import os
import struct
import sys

import bpy
from mathutils import Vector


def mdd_sizes(path):
    """Frames and vertices of an .mdd file: two big-endian int32 at its start."""
    with open(path, "rb") as file:
        return struct.unpack(">2i", file.read(8))


def bind(obj, mdd):
    """Imports the surface as it is and lets the cache move it, one row a frame."""
    # Thrum's z is up, as Blender's; the importer would turn the body otherwise
    bpy.ops.wm.obj_import(filepath=os.path.abspath(obj), forward_axis="Y", up_axis="Z")
    body = bpy.context.selected_objects[0]
    frames, vertices = mdd_sizes(mdd)
    if vertices != len(body.data.vertices):
        sys.exit(f"{mdd} moves {vertices} vertices, and {obj} has {len(body.data.vertices)}: export both at once")
    cache = body.modifiers.new("Thrum", "MESH_CACHE")
    cache.cache_format = "MDD"
    cache.filepath = os.path.abspath(mdd)
    cache.frame_start = 1
    cache.forward_axis, cache.up_axis = "POS_Y", "POS_Z"
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, frames
    scene.frame_set(1)
    for polygon in body.data.polygons:
        polygon.use_smooth = True
    return body, frames


def place(body):
    """A camera and a light that suit the size of the body, in place of what the file had."""
    corners = [body.matrix_world @ Vector(corner) for corner in body.bound_box]
    middle = sum(corners, Vector()) / 8
    size = max((corner - middle).length for corner in corners)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location = middle + size * Vector((0.6, -3.4, 1.4))
    camera.rotation_euler = (middle - camera.location).to_track_quat("-Z", "Y").to_euler()
    light = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    light.data.energy = 3
    light.rotation_euler = (0.8, 0.3, 0.6)
    for thing in (camera, light):
        bpy.context.collection.objects.link(thing)
    bpy.context.scene.camera = camera
    material = bpy.data.materials.new("Rubber")
    material.diffuse_color = (0.1, 0.3, 0.6, 1)
    material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.1, 0.3, 0.6, 1)
    body.data.materials.clear()
    body.data.materials.append(material)


def check(body, frames):
    """Prints what Blender makes of some frames: the vertex that is furthest along x at rest."""
    number = max(body.data.vertices, key=lambda vertex: vertex.co.x).index
    print(f"frames {frames} vertices {len(body.data.vertices)} vertex {number}")
    for frame in sorted({1, frames // 2, frames}):
        bpy.context.scene.frame_set(frame)
        shape = body.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        print("frame", frame, *(f"{x:.7g}" for x in shape.vertices[number].co))


def main():
    parser = argparse.ArgumentParser(prog="bind_bake.py")
    parser.add_argument("obj")
    parser.add_argument("mdd")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--render", nargs=2, metavar=("FRAME", "PNG"))
    parser.add_argument("--save", metavar="BLEND")
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])

    # the cube of a new file, its camera and its light go
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    body, frames = bind(options.obj, options.mdd)
    place(body)
    if options.check:
        check(body, frames)
    if options.render:
        scene = bpy.context.scene
        scene.render.engine = "CYCLES"  # draws without a display
        scene.cycles.samples = 16
        scene.cycles.use_denoising = False
        scene.render.resolution_x, scene.render.resolution_y = 640, 360
        scene.frame_set(int(options.render[0]))
        scene.render.filepath = os.path.abspath(options.render[1])
        bpy.ops.render.render(write_still=True)
    if options.save:
        bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(options.save))


if __name__ == "__main__":
    main()
