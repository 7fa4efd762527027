#!/usr/bin/python3
"""bench_test.py STAGES SHEEN: runs a few small benchmarks of each kind, tiny whole renders, and
everything that makes tables and plots of them. What anything takes decides nothing."""
import pathlib
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "bench"))
sys.dont_write_bytecode = True
import performance  # noqa: E402


def cells(lines):
    """The table's rows below its head, which must all be as long as the head."""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    for row in rows[2:]:
        assert len(row) == len(rows[0]), row
    return rows[2:]


class Bench(unittest.TestCase):
    stages = ""
    sheen = ""

    @classmethod
    def setUpClass(cls):
        small = "rays/cornell/18|raster/cornell/border_64|build/.*/cornell|gbuffer/cornell" \
                "|project/[04]|placement/0/1024|triad|splat/[04]|compose/0|estimate/0|exr/basic"
        cls.tables = performance.measure_stages(cls.stages, small, quick=True)

    def test_every_table_has_its_rows(self):
        rows = {name: len(cells(lines)) for name, lines in self.tables.items()}
        self.assertEqual(rows, {"rays": 1, "raster": 1, "build": 1, "project": 2, "splat": 2,
                                "placement": 1, "image": 5})

    def test_figures_are_plausible(self):
        ray = cells(self.tables["rays"])[0]
        self.assertEqual(ray[:4], ["cornell", "30", "18", "972"])
        for row in cells(self.tables["splat"]):
            share = float(row[4].rstrip("%"))
            self.assertTrue(0 < share < 100, row)
        for row in cells(self.tables["placement"]):
            self.assertTrue(950 < int(row[1].replace(",", "")) < 1100, row)

    def test_startup(self):
        starts = performance.measure_startup(self.stages, self.sheen, quick=True)
        for what, warm, cold in starts:
            self.assertGreater(min(warm, cold), 0, what)
        self.assertEqual(len(cells(performance.startup_table(starts))), 3)

    def test_whole_render(self):
        runs = performance.measure_whole(self.sheen, {"cornell_diffuse": "24x16"}, 1, ["--threads=1"])
        row = cells(performance.whole_table(runs))[0]
        self.assertEqual(row[:2], ["cornell_diffuse", "24x16"])
        self.assertGreater(int(row[2].replace(",", "")), 0)

    def test_power_of_points_on_a_line_is_its_slope(self):
        points = [(x, 3 * x ** 0.7) for x in (10, 50, 1000)]
        exponent, fitted = performance.power(points)
        self.assertAlmostEqual(exponent, 0.7)
        for (_, y), fit in zip(points, fitted):
            self.assertAlmostEqual(fit / y, 1)

    def test_power_goes_between_points_off_the_line(self):
        exponent, fitted = performance.power([(1, 1), (10, 100), (100, 100)])
        self.assertAlmostEqual(exponent, 1)
        self.assertLess(fitted[1], 100)
        self.assertGreater(fitted[2], 100)

    def test_growth_of_small_renders_and_boxes(self):
        records = performance.measure_records(self.sheen, "32x32", [1.6, 0.4], 1)
        pixels = performance.measure_pixels(self.sheen, [16, 32], 1)
        rows = performance.measure_triangles(self.stages, "cornell_[15]K", quick=True)
        growth = {"records": performance.render_growth(records),
                  "triangles": performance.triangle_growth(rows),
                  "pixels": performance.render_growth(pixels)}
        ends = [row[:1] + row[2:4] for row in cells(performance.growth_table(growth))]
        self.assertEqual(ends[2:], 2 * [["triangles", "1,080", "5,070"]] +
                         2 * [["pixels", "256", "1,024"]])
        for series in growth.values():
            part, whole = series.values()
            self.assertLess(part[0][0], part[-1][0])
            for (x, less), (same, more) in zip(part, whole):
                self.assertEqual(x, same)
                self.assertLess(less, more)
        with tempfile.TemporaryDirectory() as folder:
            performance.plot_growth(growth, pathlib.Path(folder), pathlib.Path(folder))
            for quantity, series in growth.items():
                plot = pathlib.Path(folder) / f"scaling_{quantity}.svg"
                text = "".join(xml.etree.ElementTree.parse(plot).getroot().itertext())
                for what, points in series.items():
                    self.assertIn(what, text)
                    self.assertIn(f"power {performance.power(points)[0]:.2f}", text)

    def test_page_has_a_place_for_every_table(self):
        names = [*self.tables, "startup", "whole", "scaling", "machine"]
        tables = {name: [f"new {name}"] for name in names}
        with tempfile.TemporaryDirectory() as folder:
            page = pathlib.Path(folder) / "page.md"
            page.write_text(performance.PAGE.read_text(encoding="utf-8"), encoding="utf-8")
            performance.fill(page, tables)
            filled = page.read_text(encoding="utf-8")
            for name in tables:
                self.assertIn(f"<!-- {name} -->\nnew {name}\n<!-- /{name} -->", filled)
            performance.fill(page, tables)
            self.assertEqual(page.read_text(encoding="utf-8"), filled)
            with self.assertRaises(RuntimeError):
                performance.fill(page, {"nowhere": []})

    def test_program_refuses_what_it_does_not_know(self):
        for arguments in ([], ["scenes", "--threads"], ["scenes", "--threads", "0"],
                          ["scenes", "--no-such"], ["scenes", "--benchmark_filter=no such name"]):
            run = subprocess.run([self.stages, *arguments], capture_output=True, check=False)
            self.assertEqual(run.returncode, 2, arguments)


if __name__ == "__main__":
    Bench.stages, Bench.sheen = sys.argv[1:3]
    unittest.main(argv=sys.argv[:1])
