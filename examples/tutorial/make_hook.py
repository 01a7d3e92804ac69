#!/usr/bin/env python3
"""Writes hook.stl, the surface of docs/tutorial.md: a round bar that rises and bends into a hook.

Lengths are in millimetres, as in most CAD files. Binary STL, outward normals.
usage: make_hook.py hook.stl
SPDX-License-Identifier: Apache-2.0
"""
import math
import struct
import sys

RADIUS, SIDES = 12.0, 10  # of the bar
STEM, BEND = 120.0, 45.0  # height of the straight part, radius of the bend
ANGLE = math.radians(250)  # of the bend
EDGE = 2 * math.pi * RADIUS / SIDES  # triangles are about as long as they are wide


def centre_line():
    """Points of the centre line and its directions, in the plane y = 0."""
    straight = round(STEM / EDGE)
    for i in range(straight):
        yield (0.0, 0.0, STEM * i / straight), (0.0, 0.0, 1.0)
    bent = round(ANGLE * BEND / EDGE)
    for i in range(bent + 1):
        a = ANGLE * i / bent
        yield (BEND * (1 - math.cos(a)), 0.0, STEM + BEND * math.sin(a)), (math.sin(a), 0.0, math.cos(a))


def ring(point, along):
    """The corners of the bar's section; y and the normal in the plane span it."""
    normal = (along[2], 0.0, -along[0])
    corners = []
    for side in range(SIDES):
        a = 2 * math.pi * side / SIDES
        across = RADIUS * math.cos(a)
        corners.append((point[0] + across * normal[0], RADIUS * math.sin(a), point[2] + across * normal[2]))
    return corners


def triangles():
    points = list(centre_line())
    rings = [ring(point, along) for point, along in points]
    for below, above in zip(rings, rings[1:]):
        for i in range(SIDES):
            j = (i + 1) % SIDES
            yield below[i], below[j], above[j]
            yield below[i], above[j], above[i]
    for i in range(SIDES):
        j = (i + 1) % SIDES
        yield points[0][0], rings[0][j], rings[0][i]
        yield points[-1][0], rings[-1][i], rings[-1][j]


def main():
    faces = list(triangles())
    with open(sys.argv[1], "wb") as out:
        out.write(b"hook, millimetres".ljust(80, b" "))
        out.write(struct.pack("<I", len(faces)))
        for face in faces:
            # a reader takes the normal from the corners
            out.write(struct.pack("<12fH", 0, 0, 0, *(x for corner in face for x in corner), 0))


main()
