#!/usr/bin/env python3
"""Writes bench.glb, a shot as another program would: several meshes, materials, a camera, a light.

usage: make-bench.py OUT.glb
"""
import json
import math
import struct
import sys

STEPS = 32
binary = bytearray()
views, accessors, meshes, nodes = [], [], [], []


def accessor(values, kind, component, target, bounds=False):
    """Appends values (tuples of numbers) to the binary chunk; the index of their accessor."""
    flat = [x for value in values for x in value]
    data = struct.pack("<%d%s" % (len(flat), component), *flat)
    while len(binary) % 4:
        binary.append(0)
    views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data), "target": target})
    binary.extend(data)
    held = {"bufferView": len(views) - 1, "componentType": 5126 if component == "f" else 5125,
            "count": len(values), "type": kind}
    if bounds:
        single = [[struct.unpack("<f", struct.pack("<f", x))[0] for x in value] for value in values]
        held["min"] = [min(axis) for axis in zip(*single)]
        held["max"] = [max(axis) for axis in zip(*single)]
    accessors.append(held)
    return len(accessors) - 1


def mesh(name, vertices, triangles, material):
    primitive = {"attributes": {"POSITION": accessor(vertices, "VEC3", "f", 34962, True)},
                 "indices": accessor([(i,) for t in triangles for i in t], "SCALAR", "I", 34963),
                 "material": material}
    meshes.append({"name": name, "primitives": [primitive]})
    return len(meshes) - 1


def turned(profile):
    """A body turned about y, from (radius, height) pairs upwards; radius 0 closes it."""
    vertices, triangles = [], []
    for radius, height in profile:
        for step in range(STEPS):
            angle = 2 * math.pi * step / STEPS
            vertices.append((radius * math.cos(angle), height, radius * math.sin(angle)))
    for ring in range(len(profile) - 1):
        for step in range(STEPS):
            a, b = ring * STEPS + step, ring * STEPS + (step + 1) % STEPS
            triangles += [(a, a + STEPS, b), (b, a + STEPS, b + STEPS)]
    return vertices, triangles


def block(half):
    corners = [(x * half[0], y * half[1], z * half[2])
               for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]


def node(which, name, at, **more):
    nodes.append({"mesh": which, "name": name, "translation": at, **more})


plank = mesh("plank", *block((0.09, 0.0025, 0.008)), 0)
leg = mesh("leg", *block((0.004, 0.02, 0.024)), 1)
lamp = mesh("lamp", *turned([(0, 0), (0.016, 0), (0.014, 0.008), (0.005, 0.016), (0.004, 0.15),
                             (0.013, 0.154), (0.017, 0.182), (0.021, 0.184), (0.003, 0.203), (0, 0.206)]), 1)
fir = mesh("fir", *turned([(0, 0), (0.008, 0), (0.008, 0.03), (0.062, 0.034), (0.024, 0.09),
                           (0.048, 0.093), (0.016, 0.145), (0.033, 0.148), (0, 0.205)]), 2)
lawn = mesh("lawn", *block((0.34, 0.004, 0.27)), 3)
wall = mesh("wall", *block((0.55, 0.15, 0.008)), 4)
for row in range(3):
    node(plank, "seat", [0, 0.0425, 0.018 * (row - 1)])
for row in range(2):
    node(plank, "back", [0, 0.063 + 0.021 * row, -0.029 - 0.004 * row],
         rotation=[math.sin(0.70), 0, 0, math.cos(0.70)])
for side in (-1, 1):
    node(leg, "leg", [0.07 * side, 0.02, 0])
    node(leg, "upright", [0.07 * side, 0.055, -0.031], scale=[0.8, 1.8, 0.1])
node(lamp, "lamp", [0.145, 0, -0.02])
node(fir, "fir", [-0.155, 0, -0.05])
node(fir, "small fir", [-0.19, 0, 0.045], scale=[0.62, 0.55, 0.62])
node(lawn, "lawn", [0, -0.004, 0])
node(wall, "wall", [-0.1, 0.14, -0.26])


def look_at(eye, at):
    """The rotation (x, y, z, w) of a camera at `eye` that looks at `at`, without roll."""
    x, y, z = (e - a for e, a in zip(eye, at))
    yaw, pitch = math.atan2(x, z), -math.atan2(y, math.hypot(x, z))
    sy, cy, sp, cp = math.sin(yaw / 2), math.cos(yaw / 2), math.sin(pitch / 2), math.cos(pitch / 2)
    return [cy * sp, sy * cp, -sy * sp, cy * cp]


eye = [0.17, 0.24, 0.62]
nodes.append({"name": "eye", "camera": 0, "translation": eye, "rotation": look_at(eye, [-0.005, 0.068, 0])})
nodes.append({"name": "sun", "extensions": {"KHR_lights_punctual": {"light": 0}}})


def material(name, r, g, b):
    return {"name": name, "pbrMetallicRoughness": {"baseColorFactor": [r, g, b, 1], "metallicFactor": 0}}


document = {
    "asset": {"version": "2.0", "generator": "make-bench.py"},
    "extensionsUsed": ["KHR_lights_punctual"],
    "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 3}]}},
    "scene": 0,
    "scenes": [{"nodes": list(range(len(nodes)))}],
    "nodes": nodes,
    "meshes": meshes,
    "cameras": [{"name": "eye", "type": "perspective",
                 "perspective": {"yfov": math.radians(26), "aspectRatio": 4 / 3, "znear": 0.01}}],
    "materials": [material("wood", 0.32, 0.13, 0.05), material("iron", 0.03, 0.04, 0.05),
                  material("needles", 0.03, 0.10, 0.04), material("lawn", 0.12, 0.12, 0.06),
                  material("plaster", 0.16, 0.18, 0.21)],
    "accessors": accessors,
    "bufferViews": views,
    "buffers": [{"byteLength": 0}],
}
while len(binary) % 4:
    binary.append(0)
document["buffers"][0]["byteLength"] = len(binary)
text = json.dumps(document, separators=(",", ":")).encode()
text += b" " * (-len(text) % 4)
with open(sys.argv[1], "wb") as file:
    file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)))
    file.write(struct.pack("<I4s", len(text), b"JSON") + text)
    file.write(struct.pack("<I4s", len(binary), b"BIN\0") + binary)
