#!/usr/bin/python3
"""Writes a scene of many large textures, a square for each on a wall of squares, and says how much memory and time rendering it
takes. Outside CI; needs build/release/sheen."""
import argparse
import json
import pathlib
import resource
import struct
import subprocess
import sys
import time
import zlib

ROOT = pathlib.Path(__file__).resolve().parent.parent


def png(side, seed):
    """A picture that differs in every texel, quickly made: rows are one row turned."""
    row = bytes((seed * 37 + x * (seed % 7 + 1) + channel * 85) & 255 for x in range(side) for channel in range(3))
    raw = b"".join(b"\0" + row[3 * (y % side):] + row[:3 * (y % side)] for y in range(side))

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(raw, 1)) + chunk(b"IEND", b""))


def write_scene(path, count, side):
    columns = max(1, round(count ** 0.5))
    binary = bytearray()
    gltf = {"asset": {"version": "2.0"}, "scene": 0, "bufferViews": [], "accessors": [], "images": [], "textures": [],
            "materials": [], "meshes": [], "nodes": [], "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 3.0}]}},
            "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}]}

    def view(content):
        gltf["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(content)})
        binary.extend(content + b"\0" * (-len(content) % 4))
        return len(gltf["bufferViews"]) - 1

    def accessor(values, kind, components):
        gltf["accessors"].append({"bufferView": view(struct.pack(f"<{len(values)}f", *values)), "componentType": 5126,
                                  "count": len(values) // components, "type": kind})
        if kind == "VEC3":
            gltf["accessors"][-1].update({"min": [0, 0, 0], "max": [1, 1, 0]})
        return len(gltf["accessors"]) - 1

    positions = accessor([0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0], "VEC3", 3)
    uvs = accessor([0, 1, 1, 1, 1, 0, 0, 1, 1, 0, 0, 0], "VEC2", 2)
    for i in range(count):
        gltf["images"].append({"bufferView": view(png(side, i)), "mimeType": "image/png"})
        gltf["textures"].append({"source": i})
        gltf["materials"].append({"pbrMetallicRoughness": {"baseColorTexture": {"index": i}, "metallicFactor": 0}})
        gltf["meshes"].append({"primitives": [{"attributes": {"POSITION": positions, "TEXCOORD_0": uvs}, "material": i}]})
        gltf["nodes"].append({"mesh": i, "translation": [i % columns, i // columns, 0]})
    middle = 0.5 * columns
    gltf["nodes"].append({"camera": 0, "translation": [middle, middle, 1.3 * columns]})
    gltf["nodes"].append({"extensions": {"KHR_lights_punctual": {"light": 0}}})
    gltf["scenes"] = [{"nodes": list(range(len(gltf["nodes"])))}]
    gltf["buffers"] = [{"byteLength": len(binary)}]
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    path.write_bytes(struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + len(binary), len(text), 0x4E4F534A) + text +
                     struct.pack("<II", len(binary), 0x004E4942) + binary)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=pathlib.Path, help="for the scene and its image")
    parser.add_argument("--sheen", default=ROOT / "build/release/sheen", help="the program")
    parser.add_argument("--textures", type=int, default=200)
    parser.add_argument("--side", type=int, default=2048, help="of a texture, texels")
    parser.add_argument("--size", default="256x256", help="of the image")
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    scene = arguments.folder / f"textures_{arguments.textures}_{arguments.side}.glb"
    if not scene.exists():
        write_scene(scene, arguments.textures, arguments.side)
    start = time.monotonic()
    code = subprocess.run([arguments.sheen, "render", scene, "--size", arguments.size, "-o", arguments.folder / "textures.png"],
                          check=False).returncode
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"{arguments.textures} textures of {arguments.side} x {arguments.side}, file {scene.stat().st_size / 2**20:.0f} MiB: exit code "
          f"{code}, {used.ru_maxrss / 2**20:.2f} GiB, {time.monotonic() - start:.1f} s, {used.ru_utime:.1f} s of CPU time")
    return code


if __name__ == "__main__":
    sys.exit(main())
