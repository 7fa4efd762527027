#!/usr/bin/python3
"""Renders every .glb and .gltf file below a folder, and prints as a Markdown table how each ended: exit code, seconds,
warnings. Exits with 1 where one did not load, or warned of what docs/gltf.md does not say. The images are to be looked at:
the Khronos sample models show by ticks and crosses whether they are right. Outside CI."""
import argparse
import pathlib
import re
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
# What docs/gltf.md says is made, approximated, or ignored with a warning.
STATED = re.compile("|".join([
    "the scene has no camera", "the scene has no light", "orthographic camera is approximated",
    "the file is animated", "points and lines are not supported", "the file has [0-9]+ scenes",
    "extension KHR_materials_(diffuse_transmission|dispersion) ",
    "the images would take ",
]))


def render(sheen, model, image, options):
    """Exit code, seconds, warnings and errors without their beginnings."""
    start = time.monotonic()
    run = subprocess.run([sheen, "render", model, "-o", image, *options], capture_output=True, text=True, check=False)
    lines = [line.split(": ", 2)[2] for line in run.stderr.splitlines()
             if line.startswith(("sheen: warning: ", "sheen: error: "))]
    return run.returncode, time.monotonic() - start, lines


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("models", type=pathlib.Path, help="folder of models")
    parser.add_argument("images", type=pathlib.Path, help="folder for the images, .png")
    parser.add_argument("--sheen", default=ROOT / "build/release/sheen", help="the program")
    parser.add_argument("--option", action="append", default=[], metavar="=--NAME=VALUE", help="for sheen render, such as =--size=160x120")
    arguments = parser.parse_args()
    arguments.images.mkdir(parents=True, exist_ok=True)
    models = sorted(path for path in arguments.models.rglob("*") if path.suffix in (".glb", ".gltf"))
    if not models:
        sys.exit(f"{arguments.models}: has no .glb or .gltf files")
    bad = 0
    print("| model | exit | seconds | said |\n|---|---|---|---|")
    for model in models:
        image = arguments.images / f"{model.stem}.png"
        code, seconds, said = render(arguments.sheen, model, image, arguments.option)
        unstated = [line for line in said if not STATED.match(line)]
        bad += 1 if code != 0 or unstated else 0
        said = "; ".join(("**not stated**: " if line in unstated else "") + line for line in said)
        print(f"| {model.stem} | {code} | {seconds:.1f} | {said} |", flush=True)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
