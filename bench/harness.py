"""What programs of bench share: runs of a program, Markdown tables, pages that hold them."""
import json
import os
import pathlib
import re
import subprocess
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENES = ROOT / "scenes"


class Run:
    """One run of a program: wall-clock seconds, CPU seconds and peak memory of the whole command."""

    def __init__(self, command, cache=None):
        environment = dict(os.environ, **({"MESA_SHADER_CACHE_DIR": cache} if cache else {}))
        start = time.monotonic()
        child = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(child.pid, 0)
        self.seconds = time.monotonic() - start
        self.cpu = usage.ru_utime + usage.ru_stime
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode != 0:
            raise subprocess.CalledProcessError(child.returncode, command)
        self.memory = usage.ru_maxrss / 1024  # MiB
        self.stats = {}


# Tables: a list of lines, empty where nothing was measured.

def table(head, rows):
    if not rows:
        return []
    return ["| " + " | ".join(row) + " |" for row in [head, ["---"] * len(head), *rows]]


def compare(sheen, *arguments):
    """What compare says in figures, and whether it judges: not where they are mostly the reference's noise."""
    run = subprocess.run([sheen, "compare", *arguments, "--json", "-"], capture_output=True, text=True, check=False)
    if run.returncode not in (0, 3) or not run.stdout:  # 3: not judged, or input that cannot be read
        raise RuntimeError(run.stderr)
    return json.loads(run.stdout), run.returncode == 0


def publish(points, measured, path, head, cells):
    """Prints a table of points, and writes them where a file is asked for, for a panel of sheen chart."""
    if path:
        path.write_text(json.dumps({"measured": measured, "points": points}, indent=1) + "\n", encoding="utf-8")
    print()
    print(*table(head, [cells(point) for point in points]), sep="\n")


def count(number):
    return f"{round(number):,}"


def figure(number, digits=3):
    """With so many significant digits; nothing for 0."""
    if number == 0:
        return ""
    text = f"{number:.{digits}g}"
    return f"{float(text):,.0f}" if abs(float(text)) >= 10 ** digits else text


# Pages.

def fill(path, tables):
    """Replaces what stands between <!-- NAME --> and <!-- /NAME --> in the file at `path`."""
    page = path.read_text(encoding="utf-8")
    for name, lines in tables.items():
        pattern = re.compile(f"(<!-- {name} -->\n).*?(<!-- /{name} -->)", re.DOTALL)
        if not pattern.search(page):
            raise RuntimeError(f"{path}: has no place for {name}")
        page = pattern.sub(lambda m, lines=lines: m[1] + "\n".join([*lines, ""]) + m[2], page)
    path.write_text(page, encoding="utf-8")


def machine(sheen, renderer):
    with open("/proc/cpuinfo", encoding="utf-8") as info:
        models = [line.split(": ", 1)[1].strip() for line in info if line.startswith("model name")]
    version = subprocess.run([sheen, "--version"], check=True, capture_output=True, text=True)
    parts = [f"Version {version.stdout.split()[-1]}", f"{os.cpu_count()} threads", *models[:1]]
    return [", ".join(parts + ([renderer] if renderer else [])) + "."]
