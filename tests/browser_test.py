#!/usr/bin/python3
"""browser_test.py SHEEN FOLDER: what is baked, as three.js shows it in headless Chromium, against what Sheen renders without any
lightmap. Needs the Debian packages chromium and python3-numpy, and three.js, which npm installs into FOLDER where it is not there
yet; exits with 77, which stands for skipped, where one of these is missing."""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "bench"))
sys.dont_write_bytecode = True
SKIPPED = 77
try:
    import numpy
    import three_js
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(SKIPPED)

SIDE = 256


def diffuse(path):
    """What leaves surfaces by their diffuse part, and which pixels are covered."""
    image = three_js.read_exr(path)
    return numpy.stack([image[f"direct.{c}"] + image[f"indirect_diffuse.{c}"] for c in "RGB"], axis=-1), image["A"] > 0.5


class Browser(unittest.TestCase):
    sheen = ""
    three = None

    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = pathlib.Path(self.temporary.name)

    def run_sheen(self, *arguments):
        subprocess.run([self.sheen, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def test_lightmap_agrees_with_an_ordinary_render(self):
        scene = ROOT / "scenes" / "cornell_diffuse.glb"
        baked = self.folder / "models" / "baked.glb"
        baked.parent.mkdir()
        self.run_sheen("bake", scene, "--size", SIDE, "-q", "-o", baked)
        seen, = three_js.render_by_three(self.three, [baked], (SIDE, SIDE), self.folder)
        self.assertNotIsInstance(seen, str, seen)
        info = json.loads(subprocess.run([self.sheen, "info", "--json", "-", baked], check=True, capture_output=True).stdout)
        last = len(info["cameras"]) - 1  # that the page shows
        view = ["--size", f"{SIDE}x{SIDE}", "--aa", 1, "--layers", "all", "--camera", last]
        for name, file in (("records", scene), ("lightmap", baked)):
            out = self.folder / f"{name}.exr"
            self.run_sheen("render", file, *view, "-o", out)
            light, covered = diffuse(out)
            errors, means, _, _ = three_js.compare(light, covered, seen)
            print(f"{name}: off by {errors}, means {means}")
            self.assertLess(errors.max(), 0.03, name)


if __name__ == "__main__":
    Browser.sheen, three_folder = sys.argv[1], pathlib.Path(sys.argv[2])
    if not shutil.which("chromium"):
        print("skipped: there is no chromium")
        sys.exit(SKIPPED)
    try:
        three_folder.mkdir(parents=True, exist_ok=True)
        Browser.three = three_js.fetch_three(three_folder)
    except (OSError, subprocess.CalledProcessError) as failure:
        print(f"skipped: three.js: {failure}")
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1])
