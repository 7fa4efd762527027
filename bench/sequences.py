#!/usr/bin/python3
"""Renders scenes that move by each method, and prints as a Markdown table each one's error, flicker and CPU time a frame,
against pairs of neighbouring frames of the reference. Outside CI."""
import argparse
import pathlib
import tempfile

from harness import ROOT, SCENES, Run, compare, machine, publish

WHOLE = ["kite", "doors", "orbit"]
# Each frame anew at several accuracies, so that a time at equal error can be read off.
METHODS = {
    "anew": [],
    "anew, accuracy 0.6": ["--accuracy", "0.6"],
    "anew, accuracy 0.8": ["--accuracy", "0.8"],
    "temporal, none": ["--lifespan", "4", "--temporal-gradients", "none"],
    "temporal, extrapolated": ["--lifespan", "4"],
    "temporal, interpolated": ["--lifespan", "4", "--temporal-gradients", "interpolated"],
    "temporal, interpolated, 12 frames": ["--lifespan", "12", "--temporal-gradients", "interpolated"],
    "anchors": ["--anchors"],
    "k-means anew": ["--placement", "kmeans"],
    "k-means, interpolated": ["--placement", "kmeans", "--lifespan", "4", "--temporal-gradients", "interpolated"],
    "hints": ["--method", "hints"],
    "denoised, 64 paths": ["--method", "denoised", "--spp", "64"],
}


def animate(sheen, scene, out, frames, *options):
    return Run([sheen, "animate", scene, "-o", f"{out}/%04d.exr", "--frames", frames, "--aa", "1", "--caustics", "none",
                "--json", f"{out}/figures.json", *options])


def pairs(first, last, count):
    """First frames of so many pairs of neighbours, evenly spread."""
    return sorted({first + (last - 1 - first) * i // max(count - 1, 1) for i in range(count)})


def judge(sheen, images, reference):
    """What compare says of a sequence; of flicker and the mean error of its frames."""
    figures, _ = compare(sheen, "--sequence", f"{images}/%04d.exr", f"{reference}/%04d.exr")
    return figures["flicker"], sum(f["rel_rmse"] for f in figures["frames"]) / len(figures["frames"])


def measure(sheen, name, method, reference, frames, size):
    """A row of figures: error and flicker are relative, times are seconds a frame of one processor core."""
    with tempfile.TemporaryDirectory() as images:
        run = animate(sheen, SCENES / f"{name}.glb", images, f"0..{frames - 1}", *size, *METHODS[method])
        flicker, error = judge(sheen, images, reference)
    return {"scene": name, "method": method, "error": error, "flicker": flicker["value"],
            "resolution": flicker["resolution"], "seconds": run.cpu / frames}


def cells(row):
    return [row["scene"], row["method"], f"{100 * row['error']:.2f}%",
            f"{100 * row['flicker']:.2f}% ({100 * row['resolution']:.2f}%)", f"{row['seconds']:.2f}"]


def parse():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", default=WHOLE, help="of scenes/, without .glb")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    parser.add_argument("--size", default="128x128")
    parser.add_argument("--bounces", default="1")
    parser.add_argument("--frames", type=int, default=48)
    parser.add_argument("--pairs", type=int, default=12, help="of the reference")
    parser.add_argument("--spp", type=int, default=2048, help="of the reference")
    parser.add_argument("--methods", nargs="*", default=list(METHODS))
    parser.add_argument("--references", type=pathlib.Path, help="folder where references are kept, for another run")
    parser.add_argument("--json", type=pathlib.Path, help="also writes the figures here, for sheen chart --sequences")
    return parser.parse_args()


def described(arguments, sheen):
    return (f"{machine(sheen, None)[0]} {arguments.frames} frames of {arguments.size} pixels, light of {arguments.bounces} "
            f"bounces, against {arguments.pairs} pairs of frames by {arguments.spp} paths a pixel.")


def main():
    arguments = parse()
    sheen = arguments.build / "sheen"
    size = ["--size", arguments.size, "--bounces", arguments.bounces]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name in arguments.scenes:
            reference = (arguments.references or pathlib.Path(folder)) / name
            reference.mkdir(parents=True, exist_ok=True)
            for first in pairs(0, arguments.frames - 1, arguments.pairs):
                animate(sheen, SCENES / f"{name}.glb", reference, f"{first}..{first + 1}", *size, "--method", "reference",
                        "--spp", str(arguments.spp))
            for method in arguments.methods:
                rows.append(measure(sheen, name, method, reference, arguments.frames, size))
                print(*cells(rows[-1]), sep=" | ", flush=True)
    publish(rows, described(arguments, sheen), arguments.json,
            ["scene", "method", "error", "flicker (resolution)", "CPU s a frame"], cells)


if __name__ == "__main__":
    main()
