#!/usr/bin/python3
"""Makes a hall with columns under few and under many lights, as many lux either way, renders each, and prints as a
Markdown table CPU seconds and errors: point lights asked one by one and chosen among, and luminous panels. The error of
direct light of point lights is against the reference; that of the others against more samples is not asked. Outside CI."""
import argparse
import json
import math
import pathlib
import random
import re
import struct
import subprocess
import tempfile

from harness import ROOT, Run, table

HALF_WIDTH, HEIGHT, HALF_LENGTH = 10, 8, 20
CANDELA = 3000.0  # of all point lights together
NITS, AREA = 600.0, 2.0  # of all panels together
FLOAT, UNSIGNED_INT = 5126, 5125


class Glb:
    """A .glb file that grows."""

    def __init__(self):
        self.bytes = b""
        self.json = {"asset": {"version": "2.0"}, "bufferViews": [], "accessors": [], "meshes": [], "nodes": [],
                     "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_emissive_strength"]}

    def accessor(self, values, component, kind, **more):
        """`values`: tuples alike."""
        letter = "f" if component == FLOAT else "I"
        data = b"".join(struct.pack(f"<{len(v)}{letter}", *v) for v in values)
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data)})
        self.bytes += data
        self.json["accessors"].append({"bufferView": len(self.json["bufferViews"]) - 1, "componentType": component,
                                       "count": len(values), "type": kind, **more})
        return len(self.json["accessors"]) - 1

    def mesh(self, quads, material):
        """A node of quads, each of four corners."""
        corners = [corner for quad in quads for corner in quad]
        bounds = {name: [of(c[k] for c in corners) for k in range(3)] for name, of in (("min", min), ("max", max))}
        indices = [(4 * quad + k,) for quad in range(len(quads)) for k in (0, 1, 2, 0, 2, 3)]
        self.json["meshes"].append({"primitives": [{
            "attributes": {"POSITION": self.accessor(corners, FLOAT, "VEC3", **bounds)},
            "indices": self.accessor(indices, UNSIGNED_INT, "SCALAR"), "material": material}]})
        self.json["nodes"].append({"mesh": len(self.json["meshes"]) - 1})

    def write(self, path):
        self.json["buffers"] = [{"byteLength": len(self.bytes)}]
        self.json["scenes"] = [{"nodes": list(range(len(self.json["nodes"])))}]
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        chunks += struct.pack("<II", len(self.bytes), 0x004E4942) + self.bytes
        path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def box(low, high):
    quads = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (low, high):
            quad = []
            for a, b in ((low, low), (high, low), (high, high), (low, high)):
                corner = [0.0] * 3
                corner[axis], corner[u], corner[v] = side[axis], a[u], b[v]
                quad.append(corner)
            quads.append(quad)
    return quads


def hall(kind, count):
    glb = Glb()
    paint = {"metallicFactor": 0, "roughnessFactor": 1}
    glb.json["materials"] = [
        {"pbrMetallicRoughness": {"baseColorFactor": [0.7, 0.68, 0.62, 1], **paint}},
        {"pbrMetallicRoughness": {"baseColorFactor": [0.4, 0.3, 0.25, 1], "metallicFactor": 0, "roughnessFactor": 0.5}},
        {"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], **paint}, "emissiveFactor": [1, 0.9, 0.7],
         "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": NITS}}}]
    glb.mesh(box((-HALF_WIDTH, 0, -HALF_LENGTH), (HALF_WIDTH, HEIGHT, HALF_LENGTH)), 0)
    glb.mesh([[(x, 0.001, z) for x, z in ((-HALF_WIDTH, HALF_LENGTH), (HALF_WIDTH, HALF_LENGTH),
                                         (HALF_WIDTH, -HALF_LENGTH), (-HALF_WIDTH, -HALF_LENGTH))]], 1)
    for z in range(-16, 17, 8):
        for x in (-5, 5):
            glb.mesh(box((x - 0.5, 0, z - 0.5), (x + 0.5, HEIGHT, z + 0.5)), 0)
    chance = random.Random(5)
    places = [(chance.uniform(-9.5, 9.5), chance.uniform(5, 7.8), chance.uniform(-19.5, 19.5)) for _ in range(count)]
    if kind == "panels":
        h = 0.5 * math.sqrt(AREA / count)
        glb.mesh([[(x - h, y, z - h), (x + h, y, z - h), (x + h, y, z + h), (x - h, y, z + h)] for x, y, z in places], 2)
    else:
        glb.json["extensions"] = {"KHR_lights_punctual": {"lights": [
            {"type": "point", "intensity": CANDELA / count, "color": [1, 0.9, 0.75]} for _ in places]}}
        glb.json["nodes"] += [{"translation": place, "extensions": {"KHR_lights_punctual": {"light": i}}}
                              for i, place in enumerate(places)]
    glb.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.05}}]
    glb.json["nodes"].append({"camera": 0, "translation": [2.5, 1.7, 18], "rotation": [-0.03, 0.05, 0, 0.998]})
    return glb


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sheen", default=ROOT / "build/release/sheen", help="the program")
    parser.add_argument("--size", default="128x96")
    parser.add_argument("--spp", default="64", help="paths a pixel of the reference")
    arguments = parser.parse_args()
    render = [arguments.sheen, "render", "--size", arguments.size, "--aa", "1"]
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for kind, count in (("points", 10), ("points", 256), ("points", 2000), ("panels", 5), ("panels", 5000)):
            scene, image, truth = folder / "hall.glb", folder / "image.exr", folder / "truth.exr"
            hall(kind, count).write(scene)
            seconds = Run([*render, scene, "-o", image]).cpu
            error = "not asked"
            if kind == "points":
                Run([*render, scene, "--method", "reference", "--bounces", "1", "--spp", arguments.spp, "-o", truth])
                judged = subprocess.run([arguments.sheen, "compare", image, truth, "--layer", "direct"], check=True,
                                        capture_output=True, text=True).stdout
                error = re.search(r"rel_rmse\s+(\S+)", judged).group(1)
            rows.append([f"{count} {kind}", f"{seconds:.1f}", error])
    print("\n".join(table(["lights", "CPU s", "direct, rel_rmse"], rows)))


if __name__ == "__main__":
    main()
