#!/usr/bin/python3
"""Renders every .glb and .gltf file below a folder by Sheen and by three.js from the same camera under the same light, and prints
as a Markdown table by how much the two differ; FOLDER/index.html shows both pictures of each model and their difference. Outside
CI; needs the Debian packages chromium, npm and python3-numpy, and build/release/sheen.

Both get a copy of the model, seen as model viewers do, from the front and a little from the right and above, and lit by one point
light at the eye, so that no shadow shows: three.js casts none. There is no other light, no sky and no tone curve. Compared is what
leaves surfaces directly: their emission and the light of the point light, in linear light, over pixels that both cover but for the
borders of what is covered, where the two find their pixels differently."""
import argparse
import base64
import http.server
import json
import math
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import threading
import zlib

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent
NAME = "side by side"  # of the camera and of the light
FIELD_OF_VIEW = math.radians(40.0)
TOWARD_EYE = numpy.array([0.35, 0.25, 1.0]) / numpy.linalg.norm([0.35, 0.25, 1.0])

PAGE = """<!doctype html><meta charset="utf-8">
<script type="importmap">{"imports": {"three": "/three/build/three.module.js"}}</script>
<script type="module">
import * as THREE from "three";
import { GLTFLoader } from "/three/examples/jsm/loaders/GLTFLoader.js";
import { MeshoptDecoder } from "/three/examples/jsm/libs/meshopt_decoder.module.js";
const { names, width, height } = await (await fetch("/list")).json();
// Baked light, which GLTFLoader leaves to plug-ins.
class Lightmaps {
    constructor(parser) {
        this.parser = parser;
        this.name = "MOZ_lightmap";
    }
    async extendMaterialParams(index, params) {
        const lightmap = this.parser.json.materials[index].extensions?.MOZ_lightmap;
        if (lightmap) {
            await this.parser.assignTexture(params, "lightMap", lightmap);
            params.lightMapIntensity = lightmap.intensity ?? 1;
        }
    }
}
const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).register(parser => new Lightmaps(parser));
const renderer = new THREE.WebGLRenderer({ antialias: false });
renderer.toneMapping = THREE.NoToneMapping;
renderer.setClearColor(0x000000, 0);
const target = new THREE.WebGLRenderTarget(width, height, { type: THREE.FloatType, colorSpace: THREE.LinearSRGBColorSpace });
for (const [index, path] of names.entries()) {
    let answer;
    try {
        const gltf = await loader.loadAsync(path);
        const camera = gltf.cameras.find(c => c.userData.side_by_side) ?? gltf.cameras[gltf.cameras.length - 1];
        camera.aspect = width / height;
        camera.updateProjectionMatrix();
        renderer.setRenderTarget(target);
        renderer.clear();
        renderer.render(gltf.scene, camera);
        // Twice: what a transmissive surface shows is drawn from the first.
        answer = new Float32Array(4 * width * height);
        renderer.readRenderTargetPixels(target, 0, 0, width, height, answer);
    } catch (error) {
        answer = String(error);
    }
    await fetch("/result/" + index, { method: "POST", body: answer });
}
await fetch("/done", { method: "POST", body: "" });
</script>"""


# Models.

def place_in_view(gltf, bounds):
    """Adds a camera that sees all of the bounds, and a light where it stands."""
    lower, upper = (numpy.array(corner, dtype=float) for corner in bounds)
    center, radius = 0.5 * (lower + upper), max(0.5 * float(numpy.linalg.norm(upper - lower)), 1e-6)
    distance = radius / math.sin(0.5 * FIELD_OF_VIEW)
    eye = center + distance * TOWARD_EYE
    right = numpy.cross([0.0, 1.0, 0.0], TOWARD_EYE)
    right /= numpy.linalg.norm(right)
    up = numpy.cross(TOWARD_EYE, right)
    matrix = [*right, 0.0, *up, 0.0, *TOWARD_EYE, 0.0, *eye, 1.0]
    gltf.setdefault("cameras", []).append({"type": "perspective", "name": NAME, "extras": {"side_by_side": True}, "perspective": {
        "yfov": FIELD_OF_VIEW, "znear": 0.01 * distance, "zfar": 10.0 * distance}})
    used = gltf.setdefault("extensionsUsed", [])
    if "KHR_lights_punctual" not in used:
        used.append("KHR_lights_punctual")
    lights = gltf.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {}).setdefault("lights", [])
    lights.clear()
    for node in gltf.get("nodes", []):
        node.get("extensions", {}).pop("KHR_lights_punctual", None)
    lights.append({"type": "point", "name": NAME, "intensity": math.pi * distance * distance})
    nodes = gltf.setdefault("nodes", [])
    nodes.append({"name": NAME, "matrix": matrix, "camera": len(gltf["cameras"]) - 1,
                  "extensions": {"KHR_lights_punctual": {"light": 0}}})
    scenes = gltf.setdefault("scenes", [{"nodes": list(range(len(nodes) - 1))}])
    scenes[gltf.setdefault("scene", 0)].setdefault("nodes", []).append(len(nodes) - 1)


def copy_lit(sheen, model, folder):
    """A copy of the model with that camera and light; None where Sheen refuses it."""
    run = subprocess.run([sheen, "info", "--json", "-", model], capture_output=True, text=True, check=False)
    if run.returncode != 0:
        return None
    info = json.loads(run.stdout)
    bounds = info["bounds"]
    bounds = (bounds["lower"], bounds["upper"]) if isinstance(bounds, dict) else bounds
    if model.suffix == ".gltf":
        shutil.copytree(model.parent, folder, dirs_exist_ok=True)
        gltf = json.loads(model.read_text())
        place_in_view(gltf, bounds)
        copy = folder / model.name
        copy.write_text(json.dumps(gltf))
        return copy
    data = model.read_bytes()
    length = struct.unpack("<I", data[12:16])[0]
    gltf, rest = json.loads(data[20:20 + length]), data[20 + length:]
    place_in_view(gltf, bounds)
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    folder.mkdir(parents=True, exist_ok=True)
    copy = folder / model.name
    copy.write_bytes(struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A) + text + rest)
    return copy


# Sheen.

def read_exr(path):
    """Channels by name, [y][x], of a file as Sheen writes it: scan lines, zip, halves and floats."""
    data = path.read_bytes()
    at = 8

    def text():
        nonlocal at
        end = data.index(b"\0", at)
        value, at = data[at:end].decode(), end + 1
        return value

    attributes = {}
    while data[at]:
        name, _, size = text(), text(), struct.unpack("<i", data[at:at + 4])[0]
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    at += 1
    left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    channels, place = [], 0
    listed = attributes["channels"]
    while listed[place]:
        end = listed.index(b"\0", place)
        channels.append((listed[place:end].decode(), struct.unpack("<i", listed[end + 1:end + 5])[0]))
        place = end + 17
    types = {0: numpy.dtype("<u4"), 1: numpy.dtype("<f2"), 2: numpy.dtype("<f4")}
    image = {name: numpy.zeros((height, width), numpy.float32) for name, _ in channels}
    rows = 16  # of a block of zip
    for block in range((height + rows - 1) // rows):
        offset = struct.unpack("<Q", data[at + 8 * block:at + 8 * block + 8])[0]
        y, size = struct.unpack("<ii", data[offset:offset + 8])
        packed = data[offset + 8:offset + 8 + size]
        count = min(rows, bottom + 1 - y)
        whole = count * width * sum(types[kind].itemsize for _, kind in channels)
        if size < whole:
            bytes_ = numpy.frombuffer(zlib.decompress(packed), numpy.uint8).astype(numpy.int64)
            bytes_[1:] -= 128
            bytes_ = (numpy.cumsum(bytes_) & 255).astype(numpy.uint8)
            half = (whole + 1) // 2
            merged = numpy.empty(whole, numpy.uint8)
            merged[0::2], merged[1::2] = bytes_[:half], bytes_[half:]
            packed = merged.tobytes()
        place = 0
        for row in range(y - top, y - top + count):
            for name, kind in channels:
                values = numpy.frombuffer(packed, types[kind], width, place)
                image[name][row] = values
                place += values.nbytes
    return image


def render_by_sheen(sheen, copy, size, folder):
    """Direct light and emission, [y][x][channel], and which pixels are covered; a line where it fails."""
    out = folder / "sheen.exr"
    run = subprocess.run([sheen, "render", copy, "--camera", NAME, "--size", f"{size[0]}x{size[1]}", "--aa", "1", "--bounces", "1",
                          "--accuracy", "2", "--environment", "none", "--layers", "all", "-o", out],
                         capture_output=True, text=True, check=False)
    if run.returncode != 0:
        return run.stderr.strip().splitlines()[-1], None
    image = read_exr(out)
    light = numpy.stack([image[f"direct.{c}"] + image.get(f"emission.{c}", 0.0) for c in "RGB"], axis=-1)
    return light, image["A"] > 0.5


# three.js.

def fetch_three(folder):
    """Where npm puts three.js."""
    module = folder / "node_modules" / "three"
    if not module.is_dir():
        subprocess.run(["npm", "install", "--silent", "--no-save", "--prefix", folder, "three"], check=True)
    return module


def render_by_three(three, copies, size, out):
    """By model: [y][x][4], or a line that says why not."""
    answers = {}
    done = threading.Event()

    class Handler(http.server.BaseHTTPRequestHandler):
        def log_message(self, *_):
            pass

        def reply(self, body, kind):
            self.send_response(200)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def do_GET(self):
            path = self.path.split("?")[0]
            if path == "/":
                self.reply(PAGE.encode(), "text/html")
            elif path == "/list":
                names = ["/models/" + copy.relative_to(out).as_posix() for copy in copies]
                self.reply(json.dumps({"names": names, "width": size[0], "height": size[1]}).encode(), "application/json")
            else:
                base, rest = (three, path[7:]) if path.startswith("/three/") else (out, path[8:])
                file = (base / rest).resolve()
                if not file.is_relative_to(base.resolve()) or not file.is_file():
                    self.send_error(404)
                    return
                self.reply(file.read_bytes(), "text/javascript" if file.suffix == ".js" else "application/octet-stream")

        def do_POST(self):
            body = self.rfile.read(int(self.headers["Content-Length"]))
            if self.path == "/done":
                done.set()
            else:
                pixels = 4 * size[0] * size[1]
                answers[int(self.path.rsplit("/", 1)[1])] = (
                    numpy.frombuffer(body, "<f4").reshape(size[1], size[0], 4)[::-1] if len(body) == 4 * pixels
                    else body.decode(errors="replace"))
            self.reply(b"", "text/plain")

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    # The browser may still be writing when it is ended.
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = subprocess.Popen(
            ["chromium", "--headless=new", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", f"--user-data-dir={profile}",
             *(["--no-sandbox"] if os.geteuid() == 0 else []), f"http://127.0.0.1:{server.server_address[1]}/"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        finished = done.wait(60 + 60 * len(copies))
        browser.terminate()
        browser.wait(30)
    server.shutdown()
    server.server_close()
    return [answers.get(i, "no answer" if finished else "took too long") for i in range(len(copies))]


# Comparison.

def inner(covered):
    """What is covered and all around is too."""
    kept = covered.copy()
    for axis in (0, 1):
        for step in (-1, 1):
            kept &= numpy.roll(covered, step, axis)
    return kept


def compare(sheen, covered, three):
    """Mean difference over the mean, by channel; the share of pixels that differ by more than a tenth of the mean; both maps."""
    kept = inner(covered & (three[..., 3] > 0.5))
    if not kept.any():
        return None
    difference = numpy.abs(sheen - three[..., :3])
    mean = numpy.maximum(three[..., :3][kept].mean(axis=0), 1e-6)
    far = (difference[kept].mean(axis=-1) > 0.1 * mean.mean()).mean()
    return difference[kept].mean(axis=0) / mean, (sheen[kept].mean(axis=0) / mean), far, difference * kept[..., None]


def png(image):
    """A data URI."""
    image = numpy.clip(image, 0.0, 1.0)
    encoded = numpy.where(image <= 0.0031308, 12.92 * image, 1.055 * image ** (1.0 / 2.4) - 0.055)
    rows = (255.0 * encoded + 0.5).astype(numpy.uint8)
    raw = b"".join(b"\0" + row.tobytes() for row in rows)

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    file = (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", rows.shape[1], rows.shape[0], 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b""))
    return "data:image/png;base64," + base64.b64encode(file).decode()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models", type=pathlib.Path, help="folder of models")
    parser.add_argument("folder", type=pathlib.Path, help="for the page and the copies of the models")
    parser.add_argument("--sheen", default=ROOT / "build/release/sheen", help="the program")
    parser.add_argument("--size", default="256x256", metavar="WxH")
    parser.add_argument("--three", type=pathlib.Path, help="three.js as npm installs it; default: installed into FOLDER")
    arguments = parser.parse_args()
    size = tuple(int(side) for side in arguments.size.split("x"))
    out = arguments.folder
    out.mkdir(parents=True, exist_ok=True)
    three = arguments.three or fetch_three(out)
    models = sorted(path for path in arguments.models.rglob("*") if path.suffix in (".glb", ".gltf"))
    copies = [copy_lit(arguments.sheen, model, out / "models" / model.stem) for model in models]
    models = [model for model, copy in zip(models, copies) if copy]
    refused = len(copies) - len(models)
    copies = [copy for copy in copies if copy]
    if not copies:
        sys.exit(f"{arguments.models}: has no .glb or .gltf files that load")
    by_three = render_by_three(three, copies, size, out)
    version = json.loads((three / "package.json").read_text())["version"]
    print(f"three.js {version}, {size[0]} x {size[1]}: mean absolute difference over three.js's mean, Sheen's mean over it, pixels off by "
          "more than a tenth of the mean\n\n| model | red | green | blue | means | far off |\n|---|---|---|---|---|---|")
    cells = []
    for model, copy, seen in zip(models, copies, by_three):
        light, covered = render_by_sheen(arguments.sheen, copy, size, copy.parent)
        if isinstance(light, str) or isinstance(seen, str):
            print(f"| {model.stem} | {light if isinstance(light, str) else 'three.js: ' + seen} | | | | |", flush=True)
            continue
        figures = compare(light, covered, seen)
        if figures is None:
            print(f"| {model.stem} | nothing is covered by both | | | | |", flush=True)
            continue
        errors, means, far, difference = figures
        row = " | ".join(f"{100 * error:.1f}%" for error in errors)
        print(f"| {model.stem} | {row} | {', '.join(f'{mean:.3f}' for mean in means)} | {100 * far:.1f}% |", flush=True)
        cells.append(f"<tr><th>{model.stem}<br>{row}</th>" + "".join(
            f'<td><img src="{png(image)}"></td>' for image in (light, seen[..., :3], 4.0 * difference)) + "</tr>")
    (out / "index.html").write_text(
        '<!doctype html><meta charset="utf-8"><title>Sheen and three.js</title><style>body{font:14px sans-serif;background:#eee}'
        "td img{display:block}th{font-weight:normal}</style><table><tr><th>model<th>Sheen<th>three.js<th>difference, four times</tr>" +
        "".join(cells) + "</table>\n")
    return 1 if refused else 0


if __name__ == "__main__":
    sys.exit(main())
