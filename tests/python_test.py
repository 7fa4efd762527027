#!/usr/bin/python3
"""python_test.py SCENES: the module `sheen`, on PYTHONPATH, as its users have it."""
import pathlib
import subprocess
import sys
import tempfile
import unittest
import warnings

import numpy

import sheen

SCENES = pathlib.Path()
SMALL = {"width": 24, "height": 20, "aa": 1, "accuracy": 2, "bounces": 1}
FLOOR = {"positions": numpy.array([[-5, 0, -5], [-5, 0, 5], [5, 0, 5], [5, 0, -5]], numpy.float32),
         "indices": numpy.array([[0, 1, 2], [0, 2, 3]]), "material": 0}
ABOVE = {"position": (0, 3, 0), "up": (0, 0, -1), "fov": 30}


class Module(unittest.TestCase):
    def test_a_file_to_an_array(self):
        frame = sheen.render(SCENES / "cornell_glossy.glb", **SMALL)
        beauty = frame["beauty"]
        self.assertEqual((beauty.shape, beauty.dtype), ((20, 24, 3), numpy.float32))
        lit = frame["direct"] + frame["indirect"]
        if "caustic" in frame.layers:
            lit = lit + frame["caustic"]
        numpy.testing.assert_allclose(beauty, lit, rtol=1e-5, atol=1e-6)
        self.assertGreater(beauty.max(), 0)
        self.assertEqual(frame["primitive"].dtype, numpy.uint32)
        self.assertEqual(frame["alpha"].shape, (20, 24))
        self.assertGreater(frame.figures["records"], 0)
        self.assertIn("total", frame.figures["seconds"])

    def test_arrays_outlive_their_frame_and_are_not_written(self):
        beauty = sheen.render(str(SCENES / "cornell_glossy.glb"), **SMALL)["beauty"]
        again = sheen.render(str(SCENES / "cornell_glossy.glb"), **SMALL)["beauty"]
        self.assertTrue((beauty == again).all())
        with self.assertRaises(ValueError):
            beauty[0, 0, 0] = 1

    def test_a_session_is_faster_company_for_several_frames(self):
        scene = sheen.Scene((SCENES / "cornell_diffuse.glb").read_bytes())
        session = sheen.Session(scene)
        first = session.render(**SMALL)
        other = session.render(**SMALL, camera_at=(0.1, 0.25, -0.4), look_at=numpy.array([0.3, 0.2, 0.3]))
        self.assertFalse((first["beauty"] == other["beauty"]).all())
        self.assertTrue((sheen.render(scene, **SMALL)["beauty"] == first["beauty"]).all())

    def test_records_are_kept_where_asked_for(self):
        session = sheen.Session(sheen.Scene(SCENES / "cornell_glossy.glb"), keep_records=True)
        session.render(**SMALL)
        self.assertGreater(session.render(**SMALL).figures["records_reused"], 0)

    def test_scenes_of_arrays(self):
        light = {"kind": "directional", "direction": (0, -1, 0), "intensity": (2, 2, 2)}
        scene = sheen.Scene.from_arrays([FLOOR], [{"base_color": (0.5, 0.4, 0.3), "roughness": 0.7}],
                                        [light], [ABOVE], environment="none")
        self.assertEqual(scene.triangle_count, 2)
        self.assertEqual(scene.bounds, ((-5, 0, -5), (5, 0, 5)))
        frame = sheen.render(scene, width=25, height=25, aa=1, layers="all")
        self.assertAlmostEqual(frame["depth"][12, 12], 3, places=4)
        # Nearly b E / pi: most of the light is scattered diffusely.
        numpy.testing.assert_allclose(frame["direct"][12, 12], numpy.array([0.5, 0.4, 0.3]) * 2 / numpy.pi,
                                      rtol=0.2)
        self.assertEqual(len(scene.cameras), 1)

    def test_light_at_points(self):
        scene = sheen.Scene.from_arrays([FLOOR], [{}], [{"kind": "directional", "direction": (0, -1, 0),
                                                         "intensity": (2, 2, 2)}], environment="none")
        positions = numpy.array([[x, 0, z] for x in range(-2, 3) for z in range(-2, 3)])
        direct, indirect = scene.irradiance(positions, numpy.tile([0, 1, 0], (25, 1)), width=1, accuracy=1)
        self.assertEqual((direct.shape, direct.dtype), ((25, 3), numpy.float32))
        numpy.testing.assert_allclose(direct, 2, rtol=1e-5)
        numpy.testing.assert_array_equal(indirect, 0)
        with self.assertRaises(sheen.UsageError):
            scene.irradiance(positions, positions[:3], width=1)

    def test_images_of_arrays(self):
        red = numpy.zeros((1, 2, 4), numpy.uint8)
        red[..., 0] = 255
        mesh = dict(FLOOR, uvs=[[0, 0], [0, 1], [1, 1], [1, 0]])
        scene = sheen.Scene.from_arrays([mesh], [{"base_color": (1, 1, 1), "color_image": red}],
                                        [{"position": (0, 4, 0)}], [ABOVE])
        albedo = sheen.render(scene, **SMALL, layers="all")["albedo"]
        self.assertEqual(albedo[..., 1].max(), 0)
        self.assertGreater(albedo[..., 0].min(), 0.8)

    def test_warnings_are_pythons(self):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            scene = sheen.Scene.from_arrays([dict(FLOOR, material=-1)], cameras=[ABOVE])
            self.assertEqual(len(caught), 1)
            self.assertIn("no light", str(caught[0].message))
            warnings.simplefilter("error")
            with self.assertRaises(UserWarning):
                sheen.Scene.from_arrays([dict(FLOOR, material=-1)], cameras=[ABOVE])
        self.assertEqual(scene.triangle_count, 2)

    def test_errors_are_of_their_kinds(self):
        scene = sheen.Scene(SCENES / "cornell_diffuse.glb")
        light = [{"position": (0, 4, 0)}]
        for error, part, call in (
                (sheen.InputError, "no such file", lambda: sheen.render("/nowhere.glb")),
                (sheen.InputError, "bytes: is empty", lambda: sheen.Scene(b"")),
                (sheen.UsageError, "option acuracy", lambda: sheen.render(scene, acuracy=1)),
                (sheen.UsageError, "--accuracy: 7 is not", lambda: sheen.render(scene, accuracy=7)),
                (sheen.UsageError, "--target-error", lambda: sheen.render(scene, target_error="x")),
                (sheen.UsageError, "layer colour", lambda: sheen.render(scene, **SMALL)["colour"]),
                (sheen.UsageError, "mesh 0: has no 'position'",
                 lambda: sheen.Scene.from_arrays([{"position": []}])),
                (sheen.UsageError, "mesh 0: positions must have rows of 3",
                 lambda: sheen.Scene.from_arrays([{"positions": [[1, 2]]}])),
                (sheen.UsageError, "mesh 0: indices must not be negative",
                 lambda: sheen.Scene.from_arrays([dict(FLOOR, indices=[[0, 1, -1]])])),
                (sheen.UsageError, "mesh 0: indices must be integers",
                 lambda: sheen.Scene.from_arrays([dict(FLOOR, indices=[[0.5, 1, 2]])])),
                (sheen.UsageError, "mesh 0: must be a dict", lambda: sheen.Scene.from_arrays([3])),
                (sheen.UsageError, "must be point, spot or directional",
                 lambda: sheen.Scene.from_arrays([], lights=[{"kind": "sun"}])),
                (sheen.UsageError, "color_image must be an array of uint8",
                 lambda: sheen.Scene.from_arrays([], [{"color_image": numpy.zeros((2, 2, 4))}])),
                (sheen.InputError, "refers to vertex 9",
                 lambda: sheen.Scene.from_arrays([dict(FLOOR, indices=[[0, 1, 9]], material=-1)], [], light)),
                (sheen.EnvironmentError, "/nowhere/a.png",
                 lambda: sheen.render(scene, **SMALL).write("/nowhere/a.png"))):
            with self.assertRaises(error) as caught:
                call()
            self.assertIn(part, str(caught.exception))
            self.assertIsInstance(caught.exception, sheen.Error)

    def test_progress_cancels_and_may_raise(self):
        session = sheen.Session(sheen.Scene(SCENES / "cornell_glossy.glb"))
        heard = []
        session.render(**SMALL, progress=lambda what, done: heard.append((what, done)))
        self.assertTrue(all(0 <= done <= 1 for _, done in heard) and heard)
        with self.assertRaises(sheen.CancelledError):
            session.render(**SMALL, progress=lambda what, done: False)

        def fail(what, done):
            raise KeyError("mine")
        with self.assertRaises(KeyError):
            session.render(**SMALL, progress=fail)
        session.render(**SMALL)

    def test_files_and_no_word(self):
        with tempfile.TemporaryDirectory() as folder:
            code = (f"import sheen; f = sheen.render({str(SCENES / 'cornell_diffuse.glb')!r}, width=48, height=40);"
                    f"f.write({folder + '/a.png'!r}, exposure=1, tone='none'); f.write({folder + '/a.exr'!r})")
            run = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)
            self.assertEqual((run.stdout, run.stderr), (b"", b""))
            self.assertEqual(sorted(p.name for p in pathlib.Path(folder).iterdir()), ["a.exr", "a.png"])


if __name__ == "__main__":
    SCENES = pathlib.Path(sys.argv.pop(1))
    unittest.main()
