#!/usr/bin/python3
"""Measures stages (the program `stages`), whole renders (the program `sheen`) and how both grow,
and makes Markdown tables and plots of it; bench/run builds both and calls this."""
import argparse
import csv
import json
import math
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile

from harness import ROOT, SCENES, Run, count, figure, fill, machine, table

PAGE = ROOT / "docs" / "performance.md"
# Default renders, and the sizes that docs/performance.md has goals for.
WHOLE = {"cornell_diffuse": "512x512", "cornell_glossy": "512x512", "venus_glossy": "512x512",
         "atrium": "1000x1000"}
ENOUGH_SECONDS = 60  # of a scene's warm runs, and of its cold ones: long runs vary little
STAGES = ["load", "gbuffer", "shadow", "placement", "gather", "project", "splat", "compose", "write"]
QUICK, FULL = (0.001, 1), (0.3, 3)  # of a stage: seconds at least, repetitions
# Growth: records by accuracy, of the same --gather-size; the box cut into triangles; pixels by the side.
GROWN = "cornell_glossy"
ACCURACIES = [1.6, 0.8, 0.4, 0.2, 0.1, 0.05]
BOXES = "cornell_.*"
BOX_RECORDS = 6000  # about as many as a default render of the box takes
SIDES = [128, 256, 512, 1024]
PLOTS = ROOT / "docs" / "images"


# Running.

def plain(name):
    """A benchmark's name without what Google Benchmark adds."""
    return re.sub("/(iterations:[0-9]+|real_time|manual_time|repeats:[0-9]+)", "", name)


def list_stages(program, wanted):
    """Names, of the benchmarks whose plain names match."""
    listed = subprocess.run([program, SCENES, "--benchmark_list_tests"], check=True,
                            capture_output=True, text=True)
    return [name for name in listed.stdout.split() if re.fullmatch(wanted, plain(name))]


def run_stages(program, threads, workers, names, min_time, repetitions, cache=None):
    """Rows by plain name, of those `names` of list_stages(): medians over the repetitions."""
    if not names:
        return {}
    environment = dict(os.environ)
    if cache:
        environment["MESA_SHADER_CACHE_DIR"] = cache
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out.json"
        command = [program, SCENES, "--threads", str(threads), "--workers", str(workers),
                   f"--benchmark_filter=^({'|'.join(names)})$", f"--benchmark_min_time={min_time}",
                   f"--benchmark_repetitions={repetitions}", "--benchmark_out_format=json",
                   f"--benchmark_out={out}", "--benchmark_report_aggregates_only=true"]
        subprocess.run(command, check=True, env=environment, stdout=sys.stderr)
        rows = json.loads(out.read_text())["benchmarks"]
    return {plain(row["run_name"]): row for row in rows
            if row["run_type"] == "iteration" or row["aggregate_name"] == "median"}


def run_whole(sheen, scene, size, runs, options=(), cold_runs=1):
    """`cold_runs` renders, each with an empty shader cache, then `runs` with what the last of them
    left there: the cold and the warm one of median time."""
    def render(folder, cache):
        stats = pathlib.Path(folder) / "stats.json"
        run = Run([sheen, "render", SCENES / f"{scene}.glb", "--size", size, "--aa", "1", "--bounces", "1",
                   "-o", f"{folder}/image.exr", "--json", stats, *options], cache)
        run.stats = json.loads(stats.read_text())
        return run

    def median(render_one, most):
        done = []
        while len(done) < most and (not done or sum(r.seconds for r in done) < ENOUGH_SECONDS):
            done.append(render_one(len(done)))
        done.sort(key=lambda run: run.seconds)
        return done[(len(done) - 1) // 2]

    with tempfile.TemporaryDirectory() as folder:
        caches = []

        def render_cold(i):
            caches.append(f"{folder}/cache{i}")
            return render(folder, caches[-1])
        cold = median(render_cold, cold_runs)
        return cold, median(lambda _: render(folder, caches[-1]), runs)


def order_name(name):
    """Of a row STAGE/ORDER/..."""
    order = name.split("/")[1]
    return "diffuse" if order == "0" else order


def gather_table(one, every, prefix):
    """`one`, `every`: rows of one thread, and of all."""
    rows = []
    for name, row in one.items():
        if not name.startswith(prefix + "/"):
            continue
        _, scene, hemisphere = name.split("/")
        other = every.get(name, row)
        rows.append([scene.replace("_", " "), count(row["triangles"]),
                     hemisphere.replace("_", " "), count(row["texels"]),
                     figure(row["record_ms"]), figure(other["record_ms"]),
                     figure(row["record_ms"] / other["record_ms"], 2),
                     figure(row["embree_ms"]), figure(other["embree_ms"]),
                     figure(row["ratio"], 2), figure(other["ratio"], 2),
                     figure(other["texels_per_s"] / 1e6), figure(other["embree_rays_per_s"] / 1e6)])
    return table(["scene", "triangles", "hemisphere", "texels", "ms a record, one",
                  "all", "faster by", "Embree, one", "all", "ratio, one", "all",
                  "M texels/s, all", "Embree M rays/s, all"], rows)


def build_table(rows_of):
    scenes = [n.split("/")[2] for n in rows_of if n.startswith("build/embree/")]
    return table(["scene", "triangles", "Embree, ms", "light cells, ms",
                  "upload and levels of detail, ms"],
                 [[s.replace("_", " "), count(rows_of[f"build/embree/{s}"]["triangles"])] +
                  [figure(rows_of[f"build/{part}/{s}"]["real_time"])
                   for part in ("embree", "cells", "levels")] for s in scenes])


def project_table(one, every):
    return table(["order", "ms a record, one", "all", "G products/s, one", "all"],
                 [[order_name(name), figure(row["record_ms"]), figure(every[name]["record_ms"]),
                   figure(row["products_per_s"] / 1e9), figure(every[name]["products_per_s"] / 1e9)]
                  for name, row in one.items() if name.startswith("project/")])


def splat_table(one, rows_of):
    rows = []
    for name, row in rows_of.items():
        if not name.startswith("splat/"):
            continue
        drawn = row["net_accepted_per_s"] * row["fragment_bytes"]
        bandwidth = rows_of["triad"]["bytes_per_s"] if "triad" in rows_of else math.inf
        rows.append([order_name(name), count(row["records"]),
                     figure(row["real_time"]), figure(row["fixed_ms"]),
                     f"{100 * row['accepted_share']:.0f}%",
                     figure(row["accepted_per_s"] / 1e6), figure(row["net_accepted_per_s"] / 1e6),
                     figure(one.get(name, row)["net_accepted_per_s"] / 1e6),
                     f"{100 * drawn / bandwidth:.1f}%"])
    return table(["order", "records", "ms", "of these fixed", "fragments accepted",
                  "M accepted/s", "without what is fixed", "and by one thread",
                  "of the memory's bandwidth"], rows)


def placement_table(rows_of):
    return table(["order", "records", "ms", "µs a record"],
                 [[order_name(name), count(row["records"]), figure(row["real_time"]),
                   figure(1e6 / row["records_per_s"])]
                  for name, row in rows_of.items() if name.startswith("placement/")])


def image_table(rows_of):
    titles = {"gbuffer": "G-buffer", "compose": "compose, order", "estimate": "estimate, order",
              "exr": "EXR, layers"}
    rows = []
    for name, row in rows_of.items():
        stage, _, of = name.partition("/")
        if stage in titles:
            what = of.replace("_", " ") if stage in ("gbuffer", "exr") else order_name(name)
            rows.append([f"{titles[stage]} {what}",
                         count(row["triangles"]) if "triangles" in row else "",
                         figure(row["real_time"])])
    if "triad" in rows_of:
        rows.append(["memory bandwidth", "",
                     f"{rows_of['triad']['bytes_per_s'] / 1e9:.1f} GB/s"])
    return table(["stage", "triangles", "ms"], rows)


def startup_table(starts):
    """`starts`: (what, warm, cold) in milliseconds."""
    return table(["start-up", "warm, ms", "cold, ms"],
                 [[what, figure(warm), figure(cold)] for what, warm, cold in starts])


def whole_table(runs):
    """`runs`: (scene, size, cold, warm)."""
    rows = []
    for scene, size, cold, warm in runs:
        stages = [warm.stats["seconds"][stage] for stage in STAGES]
        stages.append(warm.seconds - sum(stages))
        rows.append([scene, size, count(warm.stats["records"]), f"{warm.seconds:.2f} s",
                     f"{cold.seconds:.2f} s",
                     *(f"{s:.2f}, {100 * s / warm.seconds:.0f}%" for s in stages),
                     f"{warm.memory:.0f} MiB"])
    return table(["scene", "size", "records", "warm", "cold", *STAGES, "other", "peak memory"], rows)


# Growth: of each quantity, what takes time and its points (quantity, seconds).

def power(points):
    """Least squares in logarithms: the exponent, and the fitted power at each point."""
    x, y = ([math.log(value) for value in column] for column in zip(*points))
    line = statistics.linear_regression(x, y)
    return line.slope, [math.exp(line.intercept + line.slope * value) for value in x]


def render_growth(runs):
    """`runs`: (quantity, warm run)."""
    first, last = STAGES.index("placement"), STAGES.index("splat")
    return {"placement to splat": [(x, sum(run.stats["seconds"][stage]
                                           for stage in STAGES[first:last + 1]))
                                   for x, run in runs],
            "whole command": [(x, run.seconds) for x, run in runs]}


def triangle_growth(rows_of):
    """Of BOX_RECORDS records, alone and with what a scene needs before its first."""
    gather, with_build = [], []
    for name, row in rows_of.items():
        if not name.startswith("rays/"):
            continue
        scene = name.split("/")[1]
        seconds = BOX_RECORDS * row["record_ms"] / 1e3
        gather.append((row["triangles"], seconds))
        build = sum(rows_of[f"build/{part}/{scene}"]["real_time"]
                    for part in ("embree", "cells"))
        with_build.append((row["triangles"], seconds + build / 1e3))
    return {"gather": gather, "set-up and gather": with_build}


def growth_table(growth):
    rows = []
    for quantity, series in growth.items():
        for what, points in series.items():
            exponent, fitted = power(points)
            off = max(max(y / f, f / y) for (_, y), f in zip(points, fitted)) - 1
            rows.append([quantity, what, count(points[0][0]), count(points[-1][0]),
                         *(f"{points[i][1]:.2f} s" for i in (0, -1)),
                         f"{exponent:.2f}", f"{100 * off:.0f}%"])
    return table(["against", "time of", "from", "to", "at the first", "at the last",
                  "exponent", "farthest"], rows)


def plot_growth(growth, data, plots):
    """Of each quantity `plots`/scaling_QUANTITY.svg, from a CSV file that stays in `data`."""
    data.mkdir(parents=True, exist_ok=True)
    for quantity, series in growth.items():
        head, columns = [quantity], [[x for x, _ in next(iter(series.values()))]]
        for what, points in series.items():
            exponent, fitted = power(points)
            head += [what, f"power {exponent:.2f}"]
            columns += [[seconds for _, seconds in points], fitted]
        curves = data / f"{quantity}.csv"
        with curves.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows([head, *zip(*columns)])
        subprocess.run(["gnuplot", "-e", f"curves='{curves}'; quantity='{quantity}'; "
                        f"out='{plots / f'scaling_{quantity}.svg'}'",
                        ROOT / "docs" / "accuracy" / "style.gp", ROOT / "bench" / "scaling.gp"],
                       check=True)


# The page.

def measure_stages(program, wanted, quick):
    """Every table of stages whose names match `wanted`. One thread and all of them, and one OpenGL
    context a thread for what rasterises: each in a process of its own, since Mesa's rasteriser is
    set up once."""
    every_core = os.cpu_count()
    names = list_stages(program, wanted)

    def run(threads, workers, kinds):
        chosen = [name for name in names if name.split("/")[0] in kinds.split()]
        return run_stages(program, threads, workers, chosen, *(QUICK if quick else FULL))

    one = run(1, 1, "rays raster project splat")
    every = run(every_core, 1,
                "rays project build gbuffer placement triad splat compose estimate exr")
    workers = run(every_core, every_core, "raster")
    return {"rays": gather_table(one, every, "rays"),
            "raster": gather_table(one, workers, "raster"),
            "build": build_table(every),
            "project": project_table(one, every),
            "splat": splat_table(one, every),
            "placement": placement_table(every),
            "image": image_table(every)}


def measure_startup(program, sheen, quick):
    """(what, warm, cold), milliseconds: with shaders in Mesa's cache, and with none."""
    runs = 1 if quick else 5
    tiny = ["render", SCENES / "cornell_diffuse.glb", "--size", "16x16"]
    with tempfile.TemporaryDirectory() as folder:
        def first_gbuffer(cache):
            rows = run_stages(program, os.cpu_count(), 1, list_stages(program, "startup"), 0, 1,
                              cache)
            return rows["startup"]["real_time"]

        def command(arguments):
            return lambda cache: 1e3 * Run([sheen, *arguments], cache).seconds

        def measure(what, start):
            cold = [start(f"{folder}/{what}{i}") for i in range(runs)]
            warm = [start(f"{folder}/{what}0") for i in range(runs)]
            return what, statistics.median(warm), statistics.median(cold)
        return [measure("sheen --version", command(["--version"])),
                measure("in a process, to the first G-buffer", first_gbuffer),
                measure("sheen render, 16x16", command([*tiny, "-o", f"{folder}/image.exr"]))]


def measure_whole(sheen, sizes, runs, options, cold_runs=1):
    measured = []
    for scene, size in sizes.items():
        print(f"performance: rendering {scene} at {size}", file=sys.stderr)
        measured.append((scene, size, *run_whole(sheen, scene, size, runs, options, cold_runs)))
    return measured


def measure_records(sheen, size, accuracies, runs):
    """Warm runs by the number of records; --gather-size stays that of the default accuracy."""
    measured = []
    texels = run_whole(sheen, GROWN, size, 1, ())[1].stats["gather_size"]
    for accuracy in accuracies:
        print(f"performance: rendering {GROWN} at accuracy {accuracy}", file=sys.stderr)
        _, warm = run_whole(sheen, GROWN, size, runs,
                            [f"--accuracy={accuracy}", f"--gather-size={texels}"])
        measured.append((warm.stats["records"], warm))
    return measured


def measure_pixels(sheen, sides, runs):
    """Warm runs by the number of pixels."""
    return [(side ** 2, measure_whole(sheen, {GROWN: f"{side}x{side}"}, runs, ())[0][3])
            for side in sides]


def measure_triangles(program, boxes, quick):
    """The rows that triangle_growth() needs, on all threads."""
    names = list_stages(program, f"(rays/{boxes}/[0-9]+|build/(embree|cells)/{boxes})")
    return run_stages(program, os.cpu_count(), 1, names, *(QUICK if quick else FULL))


def main():
    parser = argparse.ArgumentParser(
        prog="bench/run", description="Measures stages, whole renders and how their times grow; "
                                      "prints Markdown tables.")
    parser.add_argument("stages_program", help=argparse.SUPPRESS)
    parser.add_argument("sheen_program", help=argparse.SUPPRESS)
    parser.add_argument("what", nargs="?", choices=["all", "stages", "whole", "scaling"],
                        default="all")
    parser.add_argument("--page", action="store_true",
                        help="also put the tables into docs/performance.md, its plots beside it")
    parser.add_argument("--quick", action="store_true", help="each stage once, to see that it works")
    parser.add_argument("--only", default=".*", metavar="REGEX",
                        help="stages: benchmarks whose whole names match, such as 'splat/.*|triad'")
    parser.add_argument("--runs", type=int, default=5, metavar="N",
                        help="whole renders are the median of N warm runs, or of as many as take a "
                             "minute (5)")
    parser.add_argument("--scene", action="append", metavar="NAME[=WxH]", dest="scenes", default=[],
                        help="whole: a scene of scenes/ instead of the default ones; repeatable")
    parser.add_argument("--option", action="append", dest="options", default=[],
                        metavar="OPTION", help="whole: of `sheen render`, as --option=--threads=1; "
                                               "repeatable")
    arguments = parser.parse_intermixed_args()
    if arguments.page and (arguments.quick or arguments.scenes or arguments.options or
                           arguments.only != parser.get_default("only")):
        parser.error("--page: its tables are of the defaults")
    sizes = {name: size or WHOLE.get(name, "512x512")
             for name, _, size in (s.partition("=") for s in arguments.scenes)} or WHOLE
    tables = {}
    renderer = ""
    if arguments.what in ("all", "whole"):
        whole = measure_whole(arguments.sheen_program, sizes, arguments.runs, arguments.options,
                              cold_runs=arguments.runs)
        renderer = whole[0][3].stats["gl_renderer"]
        tables["whole"] = whole_table(whole)
    if arguments.what in ("all", "stages"):
        tables.update(measure_stages(arguments.stages_program, arguments.only,
                                     arguments.quick))
        tables["startup"] = startup_table(measure_startup(
            arguments.stages_program, arguments.sheen_program, arguments.quick))
    if arguments.what in ("all", "scaling"):
        sheen, runs = arguments.sheen_program, arguments.runs
        by_records = measure_records(sheen, WHOLE[GROWN], ACCURACIES, runs)
        by_pixels = measure_pixels(sheen, SIDES, runs)
        by_triangles = measure_triangles(arguments.stages_program, BOXES, arguments.quick)
        renderer = by_records[0][1].stats["gl_renderer"]
        growth = {"records": render_growth(by_records), "triangles": triangle_growth(by_triangles),
                  "pixels": render_growth(by_pixels)}
        tables["scaling"] = growth_table(growth)
        data = ROOT / "build" / "scaling"
        plot_growth(growth, data, PLOTS if arguments.page else data)
    # The page says for all its tables once what they were measured on.
    tables["machine"] = machine(arguments.sheen_program, renderer)
    for name, lines in tables.items():
        print(f"\n{name}\n")
        print("\n".join(lines))
    if arguments.page:
        fill(PAGE, tables)


if __name__ == "__main__":
    main()
