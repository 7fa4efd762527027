#!/usr/bin/python3
"""window_test.py SHEEN SCENE.glb: uses the viewer in a real window, as a hand does, on an X server of its
own. Of Debian: xvfb, xdotool, python3-xlib, python3-pil."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

from PIL import Image, ImageChops, ImageStat

SIZE = "160x120"
DROP = pathlib.Path(__file__).with_name("drop_file.py")
LIMIT = 240  # seconds, of anything that is waited for


def difference(a, b):
    """Root mean square over pixels and channels, of 255."""
    with Image.open(a) as image, Image.open(b) as other:
        rms = ImageStat.Stat(ImageChops.difference(image.convert("RGB"), other.convert("RGB"))).rms
    return (sum(v * v for v in rms) / len(rms)) ** 0.5


class Window(unittest.TestCase):
    sheen = ""
    scene = ""

    @classmethod
    def setUpClass(cls):
        read, write = os.pipe()
        cls.server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", "640x480x24", "-nolisten", "tcp"],
            pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as number:
            cls.environment = {**os.environ, "DISPLAY": ":" + number.readline().strip()}
        cls.addClassCleanup(cls.server.wait)
        cls.addClassCleanup(cls.server.terminate)

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)

    def view(self, *options, environment=None):
        return subprocess.run([self.sheen, "view", self.scene, "--size", SIZE, "--bounces", "1", *options],
                              cwd=self.folder, env=environment or self.environment, capture_output=True,
                              text=True, timeout=LIMIT, check=False)

    def xdotool(self, *arguments):
        return subprocess.run(["xdotool", *map(str, arguments)], env=self.environment, check=True,
                              capture_output=True, text=True, timeout=LIMIT).stdout

    def waitFor(self, path):
        for _ in range(LIMIT * 20):
            if path.exists():
                return path
            time.sleep(0.05)
        self.fail(f"{path.name} was never written")

    def testWithoutADisplayItSaysSo(self):
        environment = {k: v for k, v in self.environment.items()
                       if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
        run = self.view(environment=environment)
        self.assertEqual(run.returncode, 4)
        self.assertIn("a window needs a display", run.stderr)
        self.assertEqual(run.stderr.count("\n"), 1)

    def testBadInputIsOneLine(self):
        run = subprocess.run([self.sheen, "view", "none.glb"], cwd=self.folder, env=self.environment,
                             capture_output=True, text=True, timeout=LIMIT, check=False)
        self.assertEqual(run.returncode, 3)
        self.assertEqual(run.stderr.count("\n"), 1)

    def testAScreenshotIsTheImageThatRenderMakes(self):
        self.assertEqual(self.view("--screenshot", "a.png").returncode, 0)
        subprocess.run([self.sheen, "render", self.scene, "--size", SIZE, "--bounces", "1", "--caustics",
                        "none", "-o", "b.png"], cwd=self.folder, check=True, timeout=LIMIT,
                       capture_output=True)
        # Records lie elsewhere: about 2% of the indirect light.
        self.assertLess(difference(self.folder / "a.png", self.folder / "b.png"), 4)

    def testABenchmarkMeasures(self):
        run = self.view("--benchmark", "4", "--json", "-")
        self.assertEqual(run.returncode, 0, run.stderr)
        figures = json.loads(run.stdout)
        for key in ("seconds_to_first", "seconds_to_full", "fps_fill", "fps_full",
                    "seconds_gbuffer_512", "records"):
            self.assertGreater(figures[key], 0, key)
        self.assertLessEqual(figures["seconds_to_first"], figures["seconds_to_full"])

    def open(self):
        """The window's process, and its name to xdotool; it has the keyboard."""
        window = subprocess.Popen([self.sheen, "view", self.scene, "--size", SIZE, "--bounces", "1"],
                                  cwd=self.folder, env=self.environment, stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE, text=True)
        self.addCleanup(window.kill)
        name = self.xdotool("search", "--sync", "--onlyvisible", "--name", "Sheen - ").split()[0]
        self.xdotool("windowfocus", "--sync", name)
        return window, name

    def close(self, window):
        self.xdotool("key", "Escape")
        out, err = window.communicate(timeout=LIMIT)
        self.assertEqual(window.returncode, 0, err)
        self.assertEqual(out, "")
        return err.splitlines()

    def testWhatIsDroppedIsOpenedOrSaysWhyNot(self):
        window, name = self.open()

        def drop(path):
            subprocess.run([DROP, name, path], env=self.environment, check=True, timeout=LIMIT)

        broken = self.folder / "broken.glb"
        broken.write_bytes(b"glTF")
        drop(broken)
        self.assertIn(pathlib.Path(self.scene).name, self.xdotool("getwindowname", name))
        other = self.folder / "another.glb"
        other.write_bytes(pathlib.Path(self.scene).read_bytes())
        drop(other)
        end = time.monotonic() + LIMIT
        while "another.glb" not in self.xdotool("getwindowname", name):
            self.assertLess(time.monotonic(), end, "the dropped scene is opened")
            time.sleep(0.2)
        said = self.close(window)
        self.assertEqual(len(said), 1, said)
        self.assertIn("broken.glb", said[0])

    def testKeysAndMouseChangeTheImage(self):
        window, name = self.open()
        stem = pathlib.Path(self.scene).stem
        saved = []

        def save():
            saved.append(self.folder / f"{stem}-{len(saved) + 1}.png")
            self.xdotool("key", "p")
            return self.waitFor(saved[-1])

        def until(holds, what):
            """Saves what is seen until that holds: the image follows as fast as the machine can."""
            end = time.monotonic() + LIMIT
            while time.monotonic() < end:
                if holds(save()):
                    return saved[-1]
                time.sleep(0.5)
            self.fail(what)

        self.xdotool("key", "Tab")  # the panel goes
        end = time.monotonic() + LIMIT
        while "refining" in self.xdotool("getwindowname", name):
            self.assertLess(time.monotonic(), end, "the image becomes complete")
            time.sleep(0.2)
        first = save()
        self.xdotool("mousemove", 80, 60, "mousedown", 1)
        for x in range(80, 130, 10):
            self.xdotool("mousemove", x, 60)
            time.sleep(0.05)
        self.xdotool("mouseup", 1)
        turned = until(lambda image: difference(image, first) > 8, "dragging turns the view")
        self.xdotool("keydown", "w")
        until(lambda image: difference(image, turned) > 8, "W flies ahead")
        self.xdotool("keyup", "w")
        self.xdotool("key", "1")
        until(lambda image: difference(image, first) < 4, "1 is the first camera")
        self.xdotool("key", "c")
        until(lambda image: difference(image, first) > 8, "C shows another channel")
        said = self.close(window)
        self.assertEqual(len(said), len(saved), said)  # what was saved, and nothing else


if __name__ == "__main__":
    Window.sheen, Window.scene = map(os.path.abspath, sys.argv[1:3])
    unittest.main(argv=sys.argv[:1])
