#!/usr/bin/python3
"""Bakes lightmaps of scenes by each method, and prints as a Markdown table each one's error over texels, hemispheres and
CPU time, against path-traced texels. Outside CI."""
import argparse
import json
import pathlib
import tempfile

from harness import ROOT, SCENES, Run, compare, machine, publish

# Method, in the page's words, and its option: the settings that are swept.
METHODS = {
    "records": ("records", "--accuracy", ["2", "1.2", "0.8", "0.6", "0.4"]),
    "a hemisphere a texel": ("texels", "--accuracy", ["2", "0.8", "0.4"]),
    "paths": ("reference", "--spp", ["4", "16", "64", "256"]),
}


def bake(sheen, scene, size, out, *options):
    """Seconds of one processor core, and the figures."""
    figures = out.with_suffix(".json")
    run = Run([sheen, "bake", scene, "--size", size, "-q", "-o", out, "--json", figures, *options])
    return run.cpu, json.loads(figures.read_text(encoding="utf-8"))


def judge(sheen, image, reference):
    """rel_rmse of the indirect light, and whether the reference can tell."""
    figures, judged = compare(sheen, image, reference, "--layer", "indirect")
    return figures["rel_rmse"], judged


def measure(sheen, name, size, spp, folder):
    """A row of figures for each method and setting."""
    scene, reference = SCENES / f"{name}.glb", folder / f"{name}.exr"
    bake(sheen, scene, size, reference, "--method", "reference", "--spp", str(spp))
    for label, (method, option, settings) in METHODS.items():
        for setting in settings:
            image = folder / "image.exr"
            seed = ["--seed", "1"] if method == "reference" else []  # other paths than the reference's
            cpu, figures = bake(sheen, scene, size, image, "--method", method, option, setting, *seed)
            error, judged = judge(sheen, image, reference)
            yield {"scene": name, "method": label, "setting": f"{option[2:]} {setting}", "error": error, "judged": judged,
                   "share": figures.get("records_share", 0), "seconds": cpu}


def cells(row):
    return [row["scene"], row["method"], row["setting"], f"{100 * row['share']:.1f}%" if row["share"] else "",
            f"{100 * row['error']:.2f}%" + ("" if row["judged"] else " (not judged)"), f"{row['seconds']:.1f}"]


def parse():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", default=["cornell_diffuse"], help="of scenes/, without .glb")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    parser.add_argument("--size", default="256", help="texels along each side")
    parser.add_argument("--spp", type=int, default=4096, help="paths a texel of the reference")
    parser.add_argument("--json", type=pathlib.Path, help="also writes the figures here, for sheen chart --bakes")
    return parser.parse_args()


def described(arguments, sheen):
    return (f"{machine(sheen, None)[0]} Lightmaps of {arguments.size} x {arguments.size} texels, indirect light of all "
            f"bounces, against {arguments.spp} paths a texel.")


def main():
    arguments = parse()
    sheen = arguments.build / "sheen"
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name in arguments.scenes:
            for row in measure(sheen, name, arguments.size, arguments.spp, pathlib.Path(folder)):
                rows.append(row)
                print(*cells(row), sep=" | ", flush=True)
    publish(rows, described(arguments, sheen), arguments.json,
            ["scene", "method", "setting", "hemispheres, of the texels", "rel_rmse", "CPU s"], cells)


if __name__ == "__main__":
    main()
