#!/usr/bin/python3
"""report_test.py MAKE_SAMPLE_REPORT [SCREENSHOT.png]: opens a chart's report in headless Chromium, by
file://, and uses it as a reader does: hovers, clicks, switches, drags. No console message, no request
beyond the file. Of Debian: chromium, chromium-driver, python3-selenium."""
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

from selenium import webdriver
from selenium.common.exceptions import TimeoutException
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.select import Select
from selenium.webdriver.support.wait import WebDriverWait

REFERENCE = "-1"


class Report(unittest.TestCase):
    make_report = ""
    screenshot = ""

    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.scratch.cleanup)
        subprocess.run([cls.make_report, cls.scratch.name], check=True)
        cls.url = (pathlib.Path(cls.scratch.name) / "chart.html").as_uri()
        cls.data = json.loads((pathlib.Path(cls.scratch.name) / "chart.json").read_text())
        options = webdriver.ChromeOptions()
        for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                         "--window-size=1500,1400", f"--user-data-dir={cls.scratch.name}/profile"):
            options.add_argument(argument)
        options.binary_location = "/usr/bin/chromium"
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        cls.driver = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
        cls.addClassCleanup(cls.driver.quit)
        cls.driver.get("about:blank")
        cls.driver.get_log("performance")  # of the browser's own first page

    def setUp(self):
        self.driver.get(self.url)
        # Charts take their sizes from the page some frames after it is there; what is pointed at
        # before that moves away.
        self.driver.execute_async_script("""const done = arguments[0];
            let still = 0, before = '';
            const look = () => {
                const boxes = JSON.stringify([...document.querySelectorAll('canvas')].map(
                    canvas => canvas.getBoundingClientRect()));
                still = boxes === before ? still + 1 : 0;
                before = boxes;
                still < 10 ? requestAnimationFrame(look) : done();
            };
            look();""")

    def tearDown(self):
        self.assertEqual(self.driver.get_log("browser"), [])
        for entry in self.driver.get_log("performance"):
            message = json.loads(entry["message"])["message"]
            if message["method"] == "Network.requestWillBeSent":
                url = message["params"]["request"]["url"]
                self.assertTrue(url.startswith(("file:", "data:")), url[:80])

    def js(self, script, *arguments):
        return self.driver.execute_script("return " + script, *arguments)

    def id(self, name):
        return self.driver.find_element(By.ID, name)

    def eventually(self, value, expected):
        """Fails unless value() becomes `expected`: Chart.js hands events on with the next frame."""
        try:
            WebDriverWait(self.driver, 10, 0.05).until(lambda _: value() == expected)
        except TimeoutException:
            self.assertEqual(value(), expected)

    def chosen(self):
        return tuple(self.id(side).get_attribute("value") for side in ("left", "right"))

    def pointer_to(self, panel, dataset, point):
        """An action chain that has moved to the middle of a drawn point."""
        canvas = self.driver.find_elements(By.CSS_SELECTOR, "#panels canvas")[panel]
        x, y = self.js("""((canvas, dataset, point) => {
            const box = canvas.getBoundingClientRect();
            const at = Chart.getChart(canvas).getDatasetMeta(dataset).data[point];
            return [at.x - box.width / 2, at.y - box.height / 2];
            })(...arguments)""", canvas, dataset, point)
        return ActionChains(self.driver, duration=50).move_to_element_with_offset(canvas, round(x), round(y))

    def image(self, side):
        """The image shown on a side, once it is decoded."""
        element = self.id("image-" + side)
        self.assertTrue(self.driver.execute_async_script(
            "const [image, done] = arguments; image.decode().then(() => done(true), () => done(false));",
            element))
        self.assertEqual(element.get_property("naturalWidth"), 8)
        return element.get_attribute("src")

    def embedded(self, scene, point, key="image"):
        return self.js("JSON.parse(document.getElementById('data').textContent)"
                       ".scenes[arguments[0]].points[arguments[1]][arguments[2]]", scene, point, key)

    def test_opens_on_the_reference_and_the_best_point(self):
        self.assertEqual(self.driver.title, "Sheen: error against time")
        self.assertEqual(len(self.driver.find_elements(By.CSS_SELECTOR, "#panels canvas")), 2)
        best = self.data["scenes"][0]["pareto"]["rel_rmse"][-1]
        self.eventually(self.chosen, (REFERENCE, str(best)))
        self.assertEqual(self.image("right"), self.embedded(0, best))
        caption = self.id("caption").text
        for part in ("1.2.3", "8 × 8", "A CPU", "2 threads", "64 paths a pixel", "2.00%"):
            self.assertIn(part, caption)
        if self.screenshot:
            self.driver.save_screenshot(self.screenshot)

    def test_hostile_names_are_text(self):
        heading = self.driver.find_elements(By.CSS_SELECTOR, "#panels h3")[1]
        self.assertIn("</script><script>document.title", heading.text)
        self.assertIn("room", self.driver.find_elements(By.CSS_SELECTOR, "#panels h3")[0].text)

    def test_hovering_shows_figures(self):
        self.pointer_to(0, 1, 2).perform()
        chart = "Chart.getChart(document.querySelector('#panels canvas'))"
        self.eventually(lambda: self.js(chart + ".tooltip.opacity"), 1)
        point = self.data["scenes"][0]["points"][5]
        self.assertEqual(self.js(chart + ".tooltip.title"), ["irradiance cache, " + point["setting"]])
        lines = " ".join(self.js(chart + ".tooltip.body[0].lines"))
        self.assertIn(f"rel_rmse {100 * point['errors']['rel_rmse']:.1f}%", lines)
        self.assertIn("100 records", lines)

    def test_clicks_choose_points(self):
        self.pointer_to(0, 2, 1).click().perform()
        self.eventually(self.chosen, (REFERENCE, "7"))
        self.assertEqual(self.image("right"), self.embedded(0, 7))
        self.assertEqual(self.id("heatmap-right").get_attribute("src"), self.embedded(0, 7, "heatmap"))
        self.assertFalse(self.id("heatmap-left").is_displayed())
        self.assertIn("path tracer, fine 2", self.id("tag-right").text)
        self.pointer_to(0, 0, 0).key_down(Keys.SHIFT).click().key_up(Keys.SHIFT).perform()
        self.eventually(self.chosen, ("0", "7"))
        self.assertEqual(self.image("left"), self.embedded(0, 0))
        self.assertTrue(self.id("heatmap-left").is_displayed())
        self.assertIn("cold", self.id("figures-left").text)
        self.id("swap").click()
        self.eventually(self.chosen, ("7", "0"))

    def test_clicking_another_scene_shows_it(self):
        self.pointer_to(1, 2, 2).click().perform()
        self.eventually(lambda: "document.title" in self.id("inspector-title").text, True)
        self.eventually(self.chosen, (REFERENCE, "8"))
        self.assertEqual(self.image("right"), self.embedded(1, 8))

    def test_lists_choose_points_by_keyboard(self):
        Select(self.id("left")).select_by_value("4")
        self.assertEqual(self.image("left"), self.embedded(0, 4))
        Select(self.id("left")).select_by_value(REFERENCE)
        self.assertNotEqual(self.image("left"), self.embedded(0, 4))

    def test_divider_follows_keys_and_pointer(self):
        split = self.id("split")
        before = self.id("image-left").value_of_css_property("clip-path")
        split.send_keys(Keys.ARROW_RIGHT * 4)
        self.assertEqual(split.get_attribute("value"), "52")
        self.assertNotEqual(self.id("image-left").value_of_css_property("clip-path"), before)
        ActionChains(self.driver, duration=50).move_to_element_with_offset(split, -split.size["width"] // 4, 0).click().perform()
        self.assertAlmostEqual(float(split.get_attribute("value")), 25, delta=2)

    def test_other_errors(self):
        drawn = "Chart.getChart(document.querySelector('#panels canvas')).data.datasets[0].data[0].y"
        self.assertAlmostEqual(self.js(drawn), 30)
        for error, value in (("median", 15), ("tile_max", 120), ("rel_rmse", 30)):
            self.driver.find_element(By.CSS_SELECTOR, f"input[value={error}]").click()
            self.assertAlmostEqual(self.js(drawn), value)
            self.assertTrue(self.id("error-meaning").text)

    def test_what_cannot_be_drawn_is_counted(self):
        notes = self.driver.find_elements(By.CSS_SELECTOR, "#panels .left-out")
        self.assertEqual(notes[0].text, "")
        self.assertIn("2 points not drawn", notes[1].text)

    def test_time_to_equal_error(self):
        def table():
            return [[cell.text for cell in row.find_elements(By.CSS_SELECTOR, "td, th")]
                    for row in self.driver.find_elements(By.CSS_SELECTOR, "#equal-table tr")]

        def enter(level):
            self.id("level").clear()
            self.id("level").send_keys(level)

        # The room's radiance cache: 20% in 0.4 s, 5% in 1.1 s; 30% in 0.5 s is no point of its front.
        enter("10")
        self.assertEqual([row[1] for row in table()[1:]], [f"{0.4 * (1.1 / 0.4) ** 0.5:.3f} s", "20.0% at best", "35.0% at best"])
        # It is better than 30% at once; the irradiance cache has 80% in 1.6 s, 20% in 4.4 s. In the
        # other scene the radiance cache has no error in 0.4 s.
        enter("30")
        along = math.log(0.3 / 0.8) / math.log(0.2 / 0.8)
        time = 1.6 * (4.4 / 1.6) ** along
        self.assertEqual(table()[1:], [
            ["radiance cache", "< 0.400 s", "< 0.400 s"],
            ["irradiance cache"] + [f"{time:.2f} s (> {time / 0.4:.2f}×)"] * 2,
            ["path tracer", "35.0% at best", "35.0% at best"]])
        # The error of a point itself is no bound: the fastest has no ratio, the others have theirs
        # over it; two bounds have none.
        enter("20")
        self.assertEqual([row[1] for row in table()[1:]], ["0.400 s", "4.40 s (11.0×)", "35.0% at best"])
        enter("200")
        self.assertEqual([row[1] for row in table()[1:]], ["< 0.400 s", "< 1.60 s", "< 2.80 s"])
        # The error is the one that is chosen: tile_max is four times rel_rmse.
        enter("40")
        self.driver.find_element(By.CSS_SELECTOR, "input[value=tile_max]").click()
        self.assertEqual(table()[1][1], f"{0.4 * (1.1 / 0.4) ** 0.5:.3f} s")
        for nothing in ("0", "-1", ""):
            enter(nothing)
            self.assertEqual([row[1] for row in table()[1:]],
                             ["20.0% at best", "80.0% at best", "140% at best"])
        # Of the other scene's radiance cache a point is not judged; of the median it has 10% and 2.5%.
        self.driver.find_element(By.CSS_SELECTOR, "input[value=median]").click()
        enter("1")
        self.assertEqual([row[2] for row in table()[1:]],
                         ["not judged below 2.50%", "10.0% at best", "17.5% at best"])

    def test_stages(self):
        stages = self.js("Chart.getChart('stages-canvas').data.datasets.map(set => [set.label, set.data[0]])")
        self.assertEqual([stage for stage, _ in stages], ["load", "gather", "other"])
        self.assertAlmostEqual(sum(share for _, share in stages), 100)

    def test_table(self):
        rows = lambda: self.driver.find_elements(By.CSS_SELECTOR, "#table tbody tr")
        seconds = lambda: [float(row.find_elements(By.TAG_NAME, "td")[3].text) for row in rows()]
        self.assertEqual(len(rows()), 18)
        header = self.driver.find_elements(By.CSS_SELECTOR, "#table th button")[3]
        header.click()
        self.assertEqual(seconds(), sorted(seconds()))
        header.click()
        self.assertEqual(seconds(), sorted(seconds(), reverse=True))
        rows()[0].click()
        self.assertEqual(self.chosen()[1], "8")

    def test_scenes_that_move(self):
        rows = [[cell.text for cell in row.find_elements(By.TAG_NAME, "td")]
                for row in self.driver.find_elements(By.CSS_SELECTOR, "#sequences-table tbody tr")]
        self.assertEqual(rows[0], ["kite", "anew", "2.00%", "3.00%", "4.00 s"])
        self.assertEqual(rows[1][3], "< 0.100%")  # what the reference's noise hides
        self.assertEqual(rows[2][0][:9], "</script>")
        self.assertTrue(self.id("sequences-measured").text.startswith("By hand."))

    def test_bakes(self):
        rows = [[cell.text for cell in row.find_elements(By.TAG_NAME, "td")]
                for row in self.driver.find_elements(By.CSS_SELECTOR, "#bakes-table tbody tr")]
        self.assertEqual(rows[1], ["cornell", "records", "accuracy 0.4", "13.0%", "1.00%", "5.00 s"])
        self.assertEqual(rows[2][3:5], ["–", "8.00% (not judged)"])
        self.assertTrue(self.id("bakes-measured").text.startswith("Baked by hand."))
        headings = [heading.text for heading in self.driver.find_elements(By.CSS_SELECTOR, "#bakes-panels h3")]
        self.assertEqual(headings[0], "cornell")
        self.assertIn("</script>", headings[1])
        sets = self.js("Chart.getChart(document.querySelector('#bakes-panels canvas')).data.datasets.map("
                       "set => [set.label, set.data, set.pointBackgroundColor[0] === set.borderColor])")
        self.assertEqual(sets, [["records", [{"x": 3, "y": 2}, {"x": 5, "y": 1}], True],
                                ["paths", [{"x": 2, "y": 8}], False]])

    def test_dark(self):
        drawn = lambda: self.js("Chart.getChart(document.querySelector('#panels canvas')).data.datasets[0].borderColor")
        light = drawn()
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {
            "features": [{"name": "prefers-color-scheme", "value": "dark"}]})
        self.addCleanup(self.driver.execute_cdp_cmd, "Emulation.setEmulatedMedia", {"features": []})
        self.eventually(lambda: drawn() != light, True)

    def test_still(self):
        self.driver.get("about:blank")
        self.driver.get(self.url + "#charts")
        self.assertTrue(self.id("panels").is_displayed())
        for part in ("inspector", "equal", "stages", "sequences", "bakes", "figures", "errors"):
            self.assertFalse(self.id(part).is_displayed(), part)


if __name__ == "__main__":
    Report.make_report = sys.argv[1]
    Report.screenshot = sys.argv[2] if len(sys.argv) > 2 else ""
    unittest.main(argv=sys.argv[:1])
