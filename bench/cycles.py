#!/usr/bin/python3
"""Compares the reference with Blender's path tracer Cycles on the same .glb files: means of the image per
channel, of pixels away from lamps and sky, as a Markdown table (docs/reference.md). Outside CI; needs the Debian packages
blender, python3-numpy and python3-openimageio, and build/release/sheen.

Blender runs this file again, with bpy, to render one scene. Its Principled BSDF is another model (the
diffuse term, Smith and Fresnel terms differ), and its spots have softer edges. So both programs get
copies without the gloss of dielectrics and with points for spots, and Blender plain terms: Lambertian,
and GGX that scatters more than once for metals."""
import argparse
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Scene, and the sky it is seen under.
CASES = [("cornell_diffuse", None), ("cornell_glossy", None), ("lamp_room", None),
         ("gallery", "3,3.6,5")]


def read_gltf(path):
    """The JSON part of a .glb file, and what follows it."""
    data = path.read_bytes()
    length = struct.unpack("<I", data[12:16])[0]
    return json.loads(data[20:20 + length]), data[20 + length:]


def write_plain(source, copy):
    """The same scene, its dielectrics Lambertian and its spots points."""
    gltf, rest = read_gltf(source)
    for index, material in enumerate(gltf["materials"]):
        material["name"] = f"material {index}"  # that no two share
        if material["pbrMetallicRoughness"].get("metallicFactor", 1) < 1:
            material.setdefault("extensions", {})["KHR_materials_specular"] = {"specularFactor": 0}
    for light in gltf.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", []):
        if light["type"] == "spot":
            light["type"] = "point"
            del light["spot"]
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    copy.write_bytes(struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text),
                                 0x4E4F534A) + text + rest)


# Inside Blender.

def build_material(bpy, material, source):
    """Gives a Blender material the terms that `source`, its glTF material, means."""
    nodes, links = material.node_tree.nodes, material.node_tree.links
    metallic_roughness = source["pbrMetallicRoughness"]
    color = metallic_roughness.get("baseColorFactor", [1, 1, 1, 1])
    nodes.clear()
    if metallic_roughness.get("metallicFactor", 1) == 1:
        surface = nodes.new("ShaderNodeBsdfGlossy")
        surface.distribution = "MULTI_GGX"
        surface.inputs["Roughness"].default_value = metallic_roughness.get("roughnessFactor", 1)
    else:
        surface = nodes.new("ShaderNodeBsdfDiffuse")
    surface.inputs[0].default_value = color
    shown = surface.outputs[0]
    if "emissiveFactor" in source:
        emission = nodes.new("ShaderNodeEmission")
        emission.inputs["Color"].default_value = source["emissiveFactor"] + [1]
        emission.inputs["Strength"].default_value = source.get("extensions", {}).get(
            "KHR_materials_emissive_strength", {}).get("emissiveStrength", 1)
        both = nodes.new("ShaderNodeAddShader")
        links.new(shown, both.inputs[0])
        links.new(emission.outputs[0], both.inputs[1])
        shown = both.outputs[0]
    links.new(shown, nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])


def set_lights(bpy, gltf):
    """Point lights in candela: Blender's watts are 4 pi times that."""
    sources = gltf.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
    for light in bpy.data.lights:
        source = next(s for s in sources if light.name.startswith(s["name"]))
        light.energy = 4 * math.pi * source["intensity"]
        light.shadow_soft_size = 0


def render_in_blender(scene_file, output, size, spp, bounces, sky):
    import bpy
    import numpy
    numpy.bool = bool  # the importer of Debian 12 asks for a name that NumPy no longer has
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=scene_file)
    gltf, _ = read_gltf(pathlib.Path(scene_file))
    for source in gltf["materials"]:
        build_material(bpy, bpy.data.materials[source["name"]], source)
    set_lights(bpy, gltf)
    scene = bpy.context.scene
    scene.camera = next(o for o in bpy.data.objects if o.type == "CAMERA" and
                        o.data.name.startswith(gltf["cameras"][0]["name"]))
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    background = scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = [float(c) for c in (sky or "0,0,0").split(",")] + [1]
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.samples = spp
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = bounces
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = cycles.light_sampling_threshold = 0
    cycles.pixel_filter_type = "BOX"
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    image = scene.render.image_settings
    image.file_format, image.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = output
    bpy.ops.render.render(write_still=True)


# Outside.

def read_image(path, prefix=""):
    """The red, green and blue channel of a layer, [y][x][channel]."""
    import OpenImageIO
    image = OpenImageIO.ImageInput.open(str(path))
    names = image.spec().channelnames
    return image.read_image("float")[:, :, [names.index(prefix + c) for c in "RGB"]]


def away_from(shining):
    """Pixels none of whose neighbours shines: Sheen sees the middle of a pixel, Cycles all of it, and
    where one of the two sees a lamp or the sky the difference drowns all others."""
    import numpy
    mask = numpy.pad(shining.max(axis=2) > 0, 1)
    height, width = shining.shape[:2]
    near = [mask[y:y + height, x:x + width] for y in range(3) for x in range(3)]
    return ~numpy.logical_or.reduce(near)


def compare(folder, name, sky, options):
    scene = folder / f"{name}.glb"
    write_plain(ROOT / "scenes" / scene.name, scene)
    ours, theirs = folder / "sheen.exr", folder / "cycles.exr"
    command = [ROOT / "build/release/sheen", "render", scene, "--method", "reference", "--aa", "1", "--size",
               f"{options.size}x{options.size}", "--spp", str(options.spp), "--bounces",
               str(options.bounces), "--caustics", "none", "--layers", "all", "-o", ours]
    subprocess.run(command + (["--environment", sky] if sky else []), check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    subprocess.run(["blender", "--background", "--factory-startup", "--python-exit-code", "1",
                    "--python", __file__, "--", scene, theirs, str(options.size),
                    str(options.spp), str(options.bounces), sky or ""],
                   check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    kept = away_from(read_image(ours, "emission."))
    a, b = (read_image(path)[kept].mean(axis=0, dtype="float64") for path in (ours, theirs))
    cells = [f"{x:.4g} / {y:.4g} ({100 * (x / y - 1):+.2f}%)" for x, y in zip(a, b)]
    print(f"| {name} | {sky or 'none'} | " + " | ".join(cells) + " |", flush=True)


def main():
    if "bpy" in sys.modules:
        arguments = sys.argv[sys.argv.index("--") + 1:]
        render_in_blender(arguments[0], arguments[1], *map(int, arguments[2:5]), arguments[5])
        return
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--size", type=int, default=256, help="of the square images, in pixels")
    parser.add_argument("--spp", type=int, default=64, help="paths a pixel, of both")
    parser.add_argument("--bounces", type=int, default=4)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="default: all of them")
    options = parser.parse_args()
    print("| scene | sky | red, Sheen / Cycles | green | blue |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for name, sky in CASES:
            if not options.scenes or name in options.scenes:
                compare(pathlib.Path(folder), name, sky, options)


main()
