#!/usr/bin/python3
"""Renders scenes that move by each method, and prints as a Markdown table each one's error, flicker and CPU time a frame,
against pairs of neighbouring frames of the reference. Outside CI."""
import argparse
import json
import pathlib
import subprocess
import tempfile

from harness import ROOT, SCENES, Run, table

WHOLE = ["kite", "doors", "orbit"]
# Each frame anew at two accuracies, so that a time at equal error can be read off.
METHODS = {
    "every frame anew": [],
    "every frame anew, accuracy 0.8": ["--accuracy", "0.8"],
    "temporal, extrapolated": ["--lifespan", "24"],
    "temporal, kept": ["--lifespan", "24", "--temporal-gradients", "none"],
    "hints": ["--method", "hints"],
    "denoised, 64 paths": ["--method", "denoised", "--spp", "64"],
}


def animate(sheen, scene, out, frames, *options):
    return Run([sheen, "animate", scene, "-o", f"{out}/%04d.exr", "--frames", frames, "--aa", "1", "--caustics", "none",
                "--json", f"{out}/figures.json", *options])


def pairs(first, last, count):
    """First frames of so many pairs of neighbours, evenly spread."""
    return sorted({first + (last - 1 - first) * i // max(count - 1, 1) for i in range(count)})


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", default=WHOLE, help="of scenes/, without .glb")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    parser.add_argument("--size", default="128x128")
    parser.add_argument("--bounces", default="1")
    parser.add_argument("--frames", type=int, default=48)
    parser.add_argument("--pairs", type=int, default=12, help="of the reference")
    parser.add_argument("--spp", type=int, default=2048, help="of the reference")
    parser.add_argument("--methods", nargs="*", default=list(METHODS))
    arguments = parser.parse_args()
    sheen = arguments.build / "sheen"
    size = ["--size", arguments.size, "--bounces", arguments.bounces]
    rows = []
    for name in arguments.scenes:
        scene = SCENES / f"{name}.glb"
        with tempfile.TemporaryDirectory() as folder:
            reference = pathlib.Path(folder) / "reference"
            reference.mkdir()
            for first in pairs(0, arguments.frames - 1, arguments.pairs):
                animate(sheen, scene, reference, f"{first}..{first + 1}", *size, "--method", "reference", "--spp",
                        str(arguments.spp))
            for method in arguments.methods:
                out = pathlib.Path(folder) / "images"
                out.mkdir()
                run = animate(sheen, scene, out, f"0..{arguments.frames - 1}", *size, *METHODS[method])
                judged = subprocess.run(
                    [sheen, "compare", "--sequence", f"{out}/%04d.exr", f"{reference}/%04d.exr", "--json", "-"],
                    capture_output=True, text=True, check=False)
                if judged.returncode not in (0, 3):  # 3: some frame is mostly the reference's noise
                    raise RuntimeError(judged.stderr)
                figures = json.loads(judged.stdout)
                error = sum(f["rel_rmse"] for f in figures["frames"]) / len(figures["frames"])
                flicker = figures["flicker"]
                rows.append([name, method, f"{100 * error:.1f}%",
                             f"{100 * flicker['value']:.2f}% ({100 * flicker['resolution']:.2f}%)",
                             f"{run.cpu / arguments.frames:.2f}"])
                print(*rows[-1], sep=" | ", flush=True)
                for file in out.iterdir():
                    file.unlink()
                out.rmdir()
    print()
    print(*table(["scene", "method", "error", "flicker (resolution)", "CPU s a frame"], rows), sep="\n")


if __name__ == "__main__":
    main()
