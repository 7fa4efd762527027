#!/usr/bin/python3
"""bench_test.py STAGES SHEEN: runs a few small benchmarks of each kind, a tiny whole render, and
everything that makes tables of them. What anything takes decides nothing."""
import pathlib
import subprocess
import sys
import unittest

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
        small = "rays/cornell/20|raster/cornell/border_64|build/.*/cornell|gbuffer/cornell" \
                "|project/[04]|placement/0/1024|triad|splat/[04]|compose/0|estimate/0|exr/basic"
        cls.tables = performance.measure_stages(cls.stages, small, quick=True)

    def test_every_table_has_its_rows(self):
        rows = {name: len(cells(lines)) for name, lines in self.tables.items()}
        self.assertEqual(rows, {"rays": 1, "raster": 1, "build": 1, "project": 2, "splat": 2,
                                "placement": 1, "image": 5, "startup": 2})

    def test_figures_are_plausible(self):
        ray = cells(self.tables["rays"])[0]
        self.assertEqual(ray[:4], ["cornell", "30", "20", "1,200"])
        for row in cells(self.tables["splat"]):
            share = float(row[4].rstrip("%"))
            self.assertTrue(0 < share < 100, row)
        for row in cells(self.tables["placement"]):
            self.assertTrue(950 < int(row[1].replace(",", "")) < 1100, row)

    def test_whole_render(self):
        runs = performance.measure_whole(self.sheen, {"cornell_diffuse": "24x16"}, 1, ["--threads=1"])
        row = cells(performance.whole_table(runs))[0]
        self.assertEqual(row[:2], ["cornell_diffuse", "24x16"])
        self.assertGreater(int(row[2].replace(",", "")), 0)

    def test_page_has_a_place_for_every_table(self):
        page = performance.PAGE.read_text(encoding="utf-8")
        tables = {name: [f"new {name}"] for name in [*self.tables, "whole", "machine"]}
        filled = performance.fill(page, tables)
        for name in tables:
            self.assertIn(f"<!-- {name} -->\nnew {name}\n<!-- /{name} -->", filled)
        self.assertEqual(performance.fill(filled, tables), filled)
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
