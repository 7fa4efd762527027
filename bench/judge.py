"""Renders scenes, or runs the studies of points, judges them by path-traced references, and makes the
tables of docs/measured.md and the page of docs/accuracy; bench/judge builds what this needs."""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

from harness import ROOT, SCENES, Run, fill, machine, table

SHEEN = ROOT / "sheen"
JUDGE = ROOT / "build/release/bench/judge"
MAKE_SCENES = ROOT / "build/release/scenes/make_scenes"
MEASURED = ROOT / "docs" / "measured.md"
ACCURACY = ROOT / "docs" / "accuracy"
DEFAULT = ["cornell_diffuse", "cornell_glossy", "venus_glossy", "atrium", "corridor"]
SEEDS = [1, 2, 3]
HEAD = ["scene", "camera", "rel_rmse", "bias", "median", "p99", "tile_max", "noise_share", "records",
        "wall time", "peak memory"]
NOT_JUDGED = 3  # compare's exit code where the reference's noise is more than half of the difference


# Whole renders.

def run_sheen(arguments, output):
    """What a subcommand of sheen writes to its --json."""
    done = Run([SHEEN, *arguments, "--json", output])
    done.stats = json.loads(pathlib.Path(output).read_text(encoding="utf-8"))
    return done


def compare(image, reference, output):
    command = [SHEEN, "compare", image, reference, "--json", output]
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode not in (0, NOT_JUDGED):
        sys.exit(done.stderr.strip())
    errors = json.loads(pathlib.Path(output).read_text(encoding="utf-8"))
    return errors, " (not judged)" if done.returncode == NOT_JUDGED else ""


def measure(scene, camera, options, folder):
    """A row of the table, and the OpenGL renderer."""
    view = [scene, "--camera", camera, "--size", options.size, "--aa", "1", "--bounces", "1", "--caustics", "none"]
    reference = options.references / f"{scene.stem}.{camera}.{options.size}.exr"
    if not reference.exists():
        print(f"judge: rendering {reference} with {options.spp} paths a pixel", file=sys.stderr)
        Run([SHEEN, "render", *view, "--method", "reference", "--spp", str(options.spp), "-o", reference])
    image = folder / "image.exr"
    runs = [run_sheen(["render", *view, "-o", image, *options.render], folder / "stats.json")
            for _ in range(options.runs)]
    errors, note = compare(image, reference, folder / "errors.json")
    percent = {key: 100 * errors[key] for key in ("rel_rmse", "bias", "median", "p99", "tile_max")}
    return [scene.stem, camera, f"{percent['rel_rmse']:.2f}%{note}", f"{percent['bias']:+.2f}%",
            f"{percent['median']:.2f}%", f"{percent['p99']:.1f}%", f"{percent['tile_max']:.1f}%",
            f"{errors['noise_share']:.2f}", str(runs[-1].stats["records"]),
            f"{statistics.median(run.seconds for run in runs):.2f} s",
            f"{runs[-1].memory:.0f} MiB"], runs[-1].stats["gl_renderer"]


def judge_scenes(options):
    options.references.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        scenes = [SCENES / f"{scene}.glb" for scene in options.scenes or DEFAULT]
        if options.moved:
            for seed in SEEDS:
                Run([MAKE_SCENES, folder, "--moved", str(seed)])
            scenes = [folder / f"{scene.stem}.moved{seed}.glb" for scene in scenes for seed in SEEDS]
        missing = [str(scene) for scene in scenes if not scene.exists()]
        if missing:
            sys.exit(f"judge: no such scene: {', '.join(missing)}")
        rows, renderer = [], ""
        for scene in scenes:
            info = run_sheen(["info", scene], folder / "info.json").stats
            cameras = [camera["name"] for camera in info["cameras"]]
            for camera in cameras if options.views == "all" else cameras[:1]:
                row, renderer = measure(scene, camera, options, folder)
                rows.append(row)
                print(" ".join(row), file=sys.stderr)
    lines = [*table(HEAD, rows), "", f"{options.size}. {machine(SHEEN, renderer)[0]}"]
    print("\n".join(lines))
    if options.page:
        fill(MEASURED, {"measured": lines})


# Points.

def judge_points(options):
    data = ROOT / "build" / "accuracy"
    plots = ACCURACY
    if options.records:
        data = plots = data / "quick"
    data.mkdir(parents=True, exist_ok=True)
    if not options.page:
        quick = ["--records", str(options.records)] if options.records else []
        subprocess.run([JUDGE, "points", SCENES, data, *options.studies, *quick], check=True)
    for plot in sorted((ACCURACY / "plots").glob("*.gp")):
        # Plots of studies that have not run yet have no data.
        needs = plot.read_text(encoding="utf-8").splitlines()[0].removeprefix("# data: ")
        if (data / needs).exists():
            subprocess.run(["gnuplot", "-e", f"data='{data}'; out='{plots / plot.stem}.svg'",
                            ACCURACY / "style.gp", plot], check=True)
    if options.records:
        print(f"judge: tables and plots are in {data.relative_to(ROOT)}", file=sys.stderr)
        return
    fill(ACCURACY / "README.md", {made.stem: made.read_text(encoding="utf-8").splitlines()
                                  for made in sorted(data.glob("*.md"))})


def parse_scenes(arguments):
    parser = argparse.ArgumentParser(
        prog="bench/judge scenes", usage="%(prog)s REFERENCES [options] [SCENE...] [-- RENDER-OPTIONS...]",
        description="Whole renders by default options: the table of docs/measured.md.")
    parser.add_argument("references", type=pathlib.Path, metavar="REFERENCES",
                        help="folder that keeps references, SCENE.CAMERA.WxH.exr; what is missing is rendered")
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=f"names in scenes/ ({' '.join(DEFAULT)})")
    parser.add_argument("--views", choices=["first", "all"], default="first", help="cameras of each scene")
    parser.add_argument("--spp", type=int, default=1024, help="paths a pixel of references that are missing")
    parser.add_argument("--size", default="512x512", metavar="WxH")
    parser.add_argument("--runs", type=int, default=3, help="the wall time is the median of so many")
    parser.add_argument("--moved", action="store_true",
                        help="each scene three times, its first camera and lights moved by three seeds")
    parser.add_argument("--page", action="store_true", help="also puts the table into docs/measured.md")
    split = arguments.index("--") if "--" in arguments else len(arguments)
    options = parser.parse_intermixed_args(arguments[:split])
    options.render = arguments[split + 1:]
    if options.runs < 1:
        parser.error("--runs: must be above 0")
    if options.page and (options.moved or options.render or options.scenes):
        parser.error("--page: its table is of the defaults")
    return options


def parse_points(arguments):
    parser = argparse.ArgumentParser(
        prog="bench/judge points", description="Each approximation alone: the page of docs/accuracy.")
    parser.add_argument("studies", nargs="*", metavar="STUDY",
                        help="sh, hemispheres, raster, sizes, yardstick or gradients (default: all; about "
                             "fifteen minutes on two cores)")
    parser.add_argument("--records", type=int, metavar="N",
                        help="a quick look with at most N points a scene: nothing under docs/ changes")
    parser.add_argument("--page", action="store_true",
                        help="measures nothing: tables and plots from what the last run left")
    return parser.parse_intermixed_args(arguments)


def main():
    kind, *arguments = sys.argv[1:]
    try:
        if kind == "scenes":
            judge_scenes(parse_scenes(arguments))
        else:
            judge_points(parse_points(arguments))
    except subprocess.CalledProcessError as error:  # which has said why
        sys.exit(error.returncode)


if __name__ == "__main__":
    main()
