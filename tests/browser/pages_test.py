"""The pages that viscobar writes, used in a headless browser. pages_test.py VISCOBAR SCENES; exit code 77: no browser."""

import csv
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

import chromium

program, scenes = (os.path.abspath(path) for path in sys.argv[1:3])
if chromium.program() is None:
    print("skipped: no browser (Debian's package chromium)")
    sys.exit(77)

most_bytes = 2_000_000


def written(command, scene, directory, *options):
    subprocess.run([program, command, os.path.join(scenes, scene + ".toml"), "-o", directory, "--quiet", *options], check=True)
    return directory


def rows_of(directory, name):
    with open(os.path.join(directory, name), newline="") as file:
        return list(csv.DictReader(file))


class Browsed(unittest.TestCase):
    """One browser and one directory of results for all tests of a class."""

    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory(prefix="viscobar-pages-")
        cls.browser = chromium.Chromium()

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()
        cls.scratch.cleanup()

    def open(self, path, **how):
        self.browser.open(path, **how)
        self.page = path

    def tearDown(self):
        self.browser.media()

    def value(self, expression):
        return self.browser.evaluate(expression)

    def assertSound(self):
        """The page loaded nothing but itself and complained of nothing."""
        self.assertEqual(self.browser.messages, [])
        self.assertEqual([url for url in self.browser.requests if not url.startswith(("file://" + self.page, "data:"))], [])
        self.assertLess(os.path.getsize(self.page), most_bytes)

    def place(self, picture, x, y):
        """Where a point of a picture is in the window, after scrolling there."""
        return self.value(f"""(() => {{
            const chart = viscobar.charts.get("{picture}"), {{ over, frame }} = chart;
            over.scrollIntoView({{ block: "center", behavior: "instant" }});
            const box = over.getBoundingClientRect();
            return [box.left + chart.px({x}) - frame.left, box.top + chart.py({y}) - frame.top]; }})()""")


class ARunsReport(Browsed):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.run_directory = written("run", "unit-both-ends", os.path.join(cls.scratch.name, "run"), "--figures")

    def setUp(self):
        self.open(os.path.join(self.run_directory, "report.html"))

    def time(self):
        return self.value("viscobar.player.time")

    def test_loads_without_errors_or_requests_and_is_small(self):
        self.assertSound()
        self.assertTrue(self.value("document.documentElement.classList.contains('scripted')"))

    def test_map_has_the_colours_of_the_displacement(self):
        # Independent of the page's data: u from the field by `viscobar export`, the scale as report/plot/colours.hpp says.
        # Half a pixel off in x and t, u changes by less than 0.5 % of the scale, which is 0.1 of the distance of two anchors,
        # and so does a step of the 255 of the palette; anchors are at most 40 apart: 2 * 0.1 * 40. The image has half as many
        # pixels as the screen, with straight lines of colour between them.
        tolerance = 8
        scale = self.value("JSON.parse(document.getElementById('data').textContent).field.colours")
        anchors = [[int(hex[i:i + 2], 16) for i in (1, 3, 5)] for hex in scale["anchors"]]

        def expected(u):
            scaled = (u - scale["low"]) / (scale["high"] - scale["low"]) * (len(anchors) - 1)
            at = min(int(scaled), len(anchors) - 2)
            return [a + (scaled - at) * (b - a) for a, b in zip(anchors[at], anchors[at + 1])]

        subprocess.run([program, "export", self.run_directory, "--quiet"], check=True)
        with open(os.path.join(self.run_directory, "csv", "u.csv"), newline="") as file:
            (_, *nodes), *rows = csv.reader(file)
        for part in (0.03, 0.1, 0.2, 0.5, 0.9):
            time, *row = rows[int(part * len(rows))]
            for node in (3, 9, 14, 22):
                seen = self.browser.pixel(*self.place("displacement", time, nodes[node]))
                wanted = expected(float(row[node]))
                self.assertLess(max(abs(a - b) for a, b in zip(seen, wanted)), tolerance, (time, nodes[node], seen, wanted))

    def test_slider_moves_the_bar(self):
        # The bar is 9 pixels thick, upwards from u: 5 pixels above u it has the colour of u, 7 below it has not. At both times
        # and this x it is between its envelope's edges and clear of the obstacles.
        seen = []
        for time in (0.2, 3.0):
            self.value(f"""(() => {{ const slider = document.querySelector("input[type=range]");
                slider.value = {time}; slider.dispatchEvent(new Event("input")); }})()""")
            self.browser.settle()
            self.assertAlmostEqual(self.time(), time, places=9)
            x, y = self.place("bar", 0.3, "viscobar.field.value(viscobar.player.time, 0.3)")
            shade = self.shade("viscobar.field.shade(viscobar.field.value(viscobar.player.time, 0.3))")
            self.assertAlike(self.browser.pixel(x, y - 5), shade)
            self.assertNotAlike(self.browser.pixel(x, y + 7), shade)
            seen.append(y)
        self.assertGreater(abs(seen[0] - seen[1]), 10)

    def shade(self, expression):
        """Red, green and blue of a colour of the page."""
        return [int(channel) for channel in re.findall(r"\d+", self.value(expression))]

    def assertAlike(self, pixel, shade):
        # A gradient between stops of neighbouring shades: a step or two of 255 in each channel, and rounding.
        self.assertLess(max(abs(a - b) for a, b in zip(pixel, shade)), 6, (pixel, shade))

    def assertNotAlike(self, pixel, shade):
        self.assertGreater(max(abs(a - b) for a, b in zip(pixel, shade)), 15, (pixel, shade))

    def test_data_are_those_of_the_files(self):
        rows = rows_of(self.run_directory, "ends.csv")
        size = self.value("viscobar.field.high - viscobar.field.low")
        for row in rows[:: len(rows) // 7]:
            for column, node in (("u_left", "0"), ("u_right", "viscobar.field.x.length - 1")):
                seen = self.value(f"viscobar.field.profile({row['t']})[{node}]")
                self.assertAlmostEqual(seen, float(row[column]), delta=size / 65535)  # rounding is half of it

    def test_keys_move_in_time(self):
        stops = self.value("viscobar.field.t")
        self.value("document.querySelector('input[type=range]').focus()")
        for key, at in (("ArrowRight", 1), ("ArrowRight", 2), ("PageUp", 12), ("ArrowLeft", 11), ("PageDown", 1), ("End", -1),
                        ("Home", 0)):
            self.browser.key(key)
            self.assertEqual(self.time(), stops[at], key)
        self.value("viscobar.charts.get('energy').host.focus()")
        self.browser.key("ArrowRight")
        self.assertEqual(self.time(), stops[1])
        self.browser.key(" ")
        self.assertIn("Pause", self.value("document.querySelector('.play').ariaLabel"))
        self.browser.key(" ")
        self.assertIn("Play", self.value("document.querySelector('.play').ariaLabel"))
        self.assertGreaterEqual(self.time(), stops[1])

    def test_contact_changes_can_be_visited(self):
        changes = rows_of(self.run_directory, "events.csv")
        self.value("document.querySelector('input[type=range]').focus()")
        self.browser.key("n")
        first = changes[0]
        self.assertAlmostEqual(self.time(), float(first["t"]), places=7)
        detail = self.value("document.querySelector('.detail').textContent")
        self.assertIn(first["where"], detail)
        self.assertIn("closes" if first["change"] == "closing" else "opens", detail)
        self.assertIn("velocity", detail)
        # By its mark in a picture, which is at the frame's upper edge; the pointer may be five pixels beside it.
        last = changes[-1]
        x, _ = self.place("energy", last["t"], 0)
        top = self.value("viscobar.charts.get('energy').over.getBoundingClientRect().top")
        self.browser.click(x + 3, top + 6)
        self.assertAlmostEqual(self.time(), float(last["t"]), places=7)
        # By its row in the table.
        self.value("document.querySelectorAll('.scroller tbody tr')[0].focus()")
        self.browser.key("ArrowDown")
        self.browser.key("Enter")
        self.assertAlmostEqual(self.time(), float(changes[1]["t"]), places=7)
        self.assertEqual(self.value("document.querySelectorAll('.scroller tbody tr')[1].getAttribute('aria-selected')"), "true")

    def test_pictures_follow_the_pointer_and_return_to_the_slider(self):
        end = self.value("viscobar.field.t.at(-1)")
        self.browser.move(*self.place("left-end", end / 2, 0))
        for name in ("displacement", "energy", "reactions"):
            shown = self.value(f"""(() => {{ const chart = viscobar.charts.get("{name}");
                return chart.view.x.value(new DOMMatrix(getComputedStyle(chart.cursor.x).transform).e + chart.frame.left); }})()""")
            self.assertAlmostEqual(shown, end / 2, delta=end / 500)  # a pixel or two
        self.assertAlmostEqual(self.value("viscobar.links.t.place"), end / 2, delta=end / 500)
        self.assertEqual(self.time(), 0)
        self.browser.move(2, 2)
        self.assertEqual(self.value("viscobar.links.t.place"), 0)

    def test_map_and_bar_say_the_displacement_under_the_pointer(self):
        self.browser.move(*self.place("displacement", 3.0, 0.5))
        for picture in ("displacement", "bar"):
            text = self.value(f"document.querySelector('[data-picture={picture}] .legend .value').textContent")
            x, t, u = (float(number.replace("−", "-")) for number in re.match(r"u\((.*), (.*)\) = (.*)$", text).groups())
            self.assertAlmostEqual(x, 0.5, delta=0.01)  # a pixel or two
            self.assertAlmostEqual(t, 3.0, delta=0.02)
            self.assertAlmostEqual(u, self.value("viscobar.field.value(3.0, 0.5)"), delta=1e-3)

    def test_stress_map_says_the_stress_under_the_pointer(self):
        subprocess.run([program, "export", self.run_directory, "--quiet"], check=True)
        with open(os.path.join(self.run_directory, "csv", "stress.csv"), newline="") as file:
            (_, *middles), *rows = csv.reader(file)
        time, *row = rows[len(rows) // 3]
        self.browser.move(*self.place("stress", time, middles[7]))
        text = self.value("document.querySelector('[data-picture=stress] .legend .value').textContent")
        s = float(re.match(r"s\(.*\) = (.*)$", text).group(1).replace("−", "-").split("\u202f")[0])
        largest = max(abs(float(value)) for one in rows for value in one[1:])
        self.assertAlmostEqual(s, float(row[7]), delta=0.02 * largest)  # a pixel or two

    def test_the_bar_as_it_lies_moves_between_its_walls(self):
        # At x + s u of the ends the frame of the bar, and its colour beside it.
        for time in (0.5, 2.0):
            self.value(f"viscobar.player.go({time})")
            self.browser.settle()
            place = "viscobar.axial.magnification * viscobar.field.value(viscobar.player.time, 0)"
            x, y = self.place("axial", place, "(chart.view.y.low + chart.view.y.high) / 2")
            inside = self.shade("viscobar.stress.shade(viscobar.stress.value(viscobar.player.time, 0))")
            self.assertAlike(self.browser.pixel(x + 4, y), inside)
        self.assertEqual(self.value("viscobar.charts.get('axial').inner.querySelectorAll('.fixed .surface').length"), 2)

    def test_dragging_zooms_all_pictures_over_time_and_a_double_click_shows_the_whole(self):
        end = self.value("viscobar.field.t.at(-1)")
        begin, stop = self.place("energy", end / 4, 0), self.place("energy", end / 2, 0)
        self.browser.drag((begin[0], begin[1] - 40), (stop[0], stop[1] - 40))
        for name in ("displacement", "energy", "left-end", "reactions"):
            low, high = self.value(f"(s => [s.low, s.high])(viscobar.charts.get('{name}').view.x)")
            self.assertAlmostEqual(low, end / 4, delta=end / 300)
            self.assertAlmostEqual(high, end / 2, delta=end / 300)
        self.value("""viscobar.charts.get("energy").over.dispatchEvent(new MouseEvent("dblclick", { bubbles: true }))""")
        self.browser.settle()
        self.assertEqual(self.value("viscobar.charts.get('left-end').view.x.high"), end)

    def test_is_dark_where_the_system_or_the_reader_wants_it(self):
        corner = (3, 3)
        self.assertGreater(min(self.browser.pixel(*corner)), 200)
        self.browser.media(scheme="dark")
        self.assertLess(max(self.browser.pixel(*corner)), 60)
        # Inside of a picture, too: the paper in the lower left corner of a frame.
        x, y = self.place("energy", "viscobar.field.t.at(-1)", "viscobar.charts.get('energy').y.high")
        self.assertLess(max(self.browser.pixel(x - 5, y + 25)), 70)
        self.value("document.querySelector('[aria-label=\"Light or dark\"]').click()")
        self.browser.settle()
        self.assertGreater(min(self.browser.pixel(*corner)), 200)
        self.assertGreater(min(self.browser.pixel(x - 5, y + 25)), 200)

    def shown(self, selector):
        return self.value(f"[...document.querySelectorAll('{selector}')].filter((node) => node.checkVisibility()).length")

    def test_prints_the_still_pictures_alone_in_light_colours(self):
        self.browser.media(kind="print", scheme="dark")
        self.assertEqual(self.shown(".panel > svg"), self.value("document.querySelectorAll('.panel').length"))
        self.assertEqual(self.shown(".chart, .player, .scroller, button, input"), 0)
        self.assertEqual(self.value("getComputedStyle(document.documentElement).getPropertyValue('--paper').trim()"), "#ffffff")

    def test_has_its_still_pictures_without_scripts(self):
        self.open(self.page, scripts=False)
        self.assertEqual(self.shown(".panel > svg"), 9)
        self.assertEqual(self.shown(".live"), 0)
        self.assertSound()

    def test_everything_that_acts_has_a_name_and_takes_the_focus(self):
        self.assertEqual(self.value("""[...document.querySelectorAll("button, input, select, .chart")].filter((node) =>
            !(node.ariaLabel || node.textContent.trim()) || node.tabIndex < 0).length"""), 0)

    def test_figures_are_svg_files_without_anything_from_the_page(self):
        folder = os.path.join(self.run_directory, "figures")
        names = sorted(os.listdir(folder))
        self.assertEqual(names, ["axial.svg", "bar.svg", "displacement.svg", "end-stress.svg", "energy.svg", "left-end.svg",
                                 "reactions.svg", "right-end.svg", "stress.svg"])
        for name in names:
            tree = xml.etree.ElementTree.parse(os.path.join(folder, name)).getroot()
            self.assertEqual(tree.tag, "{http://www.w3.org/2000/svg}svg")
            self.assertIsNotNone(tree.find("{http://www.w3.org/2000/svg}title"))
            with open(os.path.join(folder, name)) as file:
                self.assertNotRegex(file.read(), r"var\(|color-mix|(href|src)=\"(?!data:)")


class OtherReports(Browsed):
    def report(self, scene, *options):
        directory = written("run", scene, os.path.join(self.scratch.name, os.path.basename(scene) + ".out"), *options)
        self.open(os.path.join(directory, "report.html"))
        self.assertSound()

    def test_a_wall_that_moves_stands_where_it_is_at_the_time_shown(self):
        self.report("shaken-stop")
        for time in (0.0, 0.0005, 0.0012):
            self.value(f"viscobar.player.go({time})")
            self.browser.settle()
            gap = 1e-4 - 1e-4 * (1 - math.cos(2 * math.pi * 400 * time))
            # Above the bar, where nothing else is drawn: a line as dark as the ink, hatches on the left, none on the right.
            x, y = self.place("axial", f"-viscobar.axial.magnification * {gap}", "chart.view.y.high + 0.1")
            self.assertLess(min(sum(self.browser.pixel(x + k, y)) for k in (-1, 0, 1)), 3 * 110, time)
            self.assertGreater(min(sum(self.browser.pixel(x + k, y)) for k in (3, 4, 5, 6)), 3 * 200, time)

    def test_labels_of_axes_are_whole_and_clear_of_their_name(self):
        for width in (1280, 400):
            self.browser.resize(width, 900)
            for scene in ("steel-bar", "shaken-stop"):
                self.report(scene)
                room = self.value("""[...document.querySelectorAll(".chart > svg")].flatMap((svg) => {
                    const box = (node) => node.getBoundingClientRect(), name = box(svg.querySelector(":scope > g > text.axis[transform]"));
                    const labels = [...svg.querySelectorAll(":scope > g > text[text-anchor=end]")];
                    return labels.map((label) => box(label).left - Math.max(name.right, box(svg).left)); })""")
                self.assertGreater(len(room), 20)
                self.assertGreater(min(room), 0, (width, scene))
        self.browser.resize(1100, 900)

    def test_of_bars_in_line_draws_each_member_and_joint_by_itself(self):
        self.report("hopkinson")
        bars = self.value("document.querySelectorAll('[data-picture=axial] .chart rect.solid').length")
        joints = self.value("document.querySelectorAll('[data-picture=axial] .chart path.joint').length")
        self.assertEqual((bars, joints), (4, 3))
        # The striker leaves the bar after the wave has come back through it, and does not come again.
        force, parts = self.value("[viscobar.charts.get('joints').curves[0].y.length, viscobar.axial.joints[0].contact]")
        self.assertGreater(force, 10)
        self.assertEqual(self.value("document.querySelectorAll('[data-picture=axial] .chart rect.touching').length"), 1)
        self.value(f"viscobar.player.go({parts[1]} + 0.5)")
        self.browser.settle()
        self.assertEqual(self.value("document.querySelectorAll('[data-picture=axial] .chart rect.touching').length"), 0)

    def test_a_gap_of_nothing_is_told_as_nothing(self):
        # Displacements in the page are rounded to 1/65535 of their range.
        self.report("unit-both-ends", "--set", "left.gap=0.1", "--set", "initial.displacement=-0.1", "--set", "left.kind=obstacle")
        for text in self.value("[...document.querySelectorAll('[data-picture=bar] .said')].map((node) => node.textContent)"):
            self.assertNotIn("10⁻", text)

    def test_of_a_chattering_bar_visits_each_of_many_changes(self):
        self.report("chatter", "--set", "contact.epsilon=1e-8")
        self.assertGreater(self.value("viscobar.events.list.length"), 100)
        self.assertEqual(self.value("document.querySelectorAll('.scroller tbody tr').length"),
                         self.value("viscobar.events.list.length"))

    def test_of_a_bar_under_a_span_obstacle_shows_where_it_touches(self):
        for scene, touches in (("unit-span", True), ("unit-span-loaded", False)):
            self.report(scene)
            scales = self.value("[...document.querySelectorAll('.live .legend')].map(one => one.textContent).join(' ')")
            self.assertIn("u from", scales)
            self.assertEqual("in contact" in scales, touches, scene)

    def test_of_a_bar_without_contact_has_no_controls_for_contact_changes(self):
        with open(os.path.join(scenes, "unit-both-ends.toml")) as file:
            text = re.sub(r'kind *= *"obstacle"\n(gap.*\n)', 'kind = "free"\n', file.read())
        scene = os.path.join(self.scratch.name, "free")
        with open(scene + ".toml", "w") as file:
            file.write(text)
        self.report(scene)
        self.assertEqual(self.value("document.querySelectorAll('[aria-label*=\"contact change\"], .scroller').length"), 0)
        self.assertEqual(self.value("viscobar.charts.has('reactions')"), False)

    def test_of_a_bar_at_rest_is_drawn(self):
        self.report("unit-both-ends", "--set", "initial.displacement=0", "--set", "initial.velocity=0")

    def test_of_a_long_run_on_a_fine_mesh_stays_small_and_says_what_it_thinned(self):
        self.report("unit-both-ends", "--set", "mesh.elements=1000", "--set", "output.every=1e-3")
        self.assertIn("every 16th output time and every 3rd node",
                      self.value("document.querySelector('[data-picture=displacement]').parentElement.innerText"))


class Studies(Browsed):
    def study(self, command, scene, *options):
        directory = written(command, scene, os.path.join(self.scratch.name, command), "--figures", *options)
        self.open(os.path.join(directory, command + ".html"))
        self.assertSound()
        figures = self.value("[...viscobar.charts.keys()]")
        self.assertEqual(sorted(os.listdir(os.path.join(directory, "figures"))), sorted(name + ".svg" for name in figures))
        for name in figures:
            xml.etree.ElementTree.parse(os.path.join(directory, "figures", name + ".svg"))
        return directory

    def tip(self, picture):
        """What is said of the point in a picture, if anything."""
        return self.value(f"(tip => tip.hidden ? '' : tip.innerText)(document.querySelector('[data-picture={picture}] .tip'))")

    def test_limit_says_the_numbers_of_a_point_and_hides_lines(self):
        directory = self.study("limit", "chatter", "--set", "contact.restitution=0")
        with open(os.path.join(directory, "limit.json")) as file:
            row = json.load(file)["rows"][3]
        self.browser.move(*self.place("penetration", row["epsilon"], row["max_penetration"]))
        tip = self.tip("penetration")
        self.assertIn("10⁻⁵", tip)
        mantissa = re.search(r"largest penetration = ([\d.]+)", tip).group(1)
        self.assertAlmostEqual(float(mantissa), float(f"{row['max_penetration']:.4e}".split("e")[0]), delta=1e-3)
        # The same place on the other pictures over epsilon.
        self.assertAlmostEqual(self.value("viscobar.links.epsilon.place") / row["epsilon"], 1, delta=0.1)
        self.assertIn("slope 1/2", self.value("document.querySelector('[data-picture=penetration] .legend').textContent"))
        # A line that is hidden is no longer there to be pointed at.
        self.value("document.querySelector('[data-picture=penetration] .legend button').click()")
        self.browser.move(2, 2)
        self.browser.move(*self.place("penetration", row["epsilon"], row["max_penetration"]))
        self.assertNotIn("10⁻⁵", self.tip("penetration"))

    def assertSame(self, told, cell):
        """A value of JSON and a cell of CSV."""
        self.assertEqual(told, None if cell == "" else type(told)(cell))

    def test_precision_is_read_by_arrow_keys(self):
        directory = self.study("precision", "unit-both-ends", "--methods", "rigid,fully_discrete", "--halvings", "3", "--tolerance",
                               "1e-3:1e-6")
        with open(os.path.join(directory, "precision.json")) as file:
            told = json.load(file)["rows"]
        rows = rows_of(directory, "precision.csv")
        self.assertEqual(len(rows), len(told))
        for row, values in zip(rows, told):
            for key, value in values.items():
                self.assertSame(value, row[key])
        self.value("viscobar.charts.get('error').host.focus()")
        self.browser.key("ArrowRight")
        first = self.tip("error")
        self.assertRegex(first, r"^(rigid|fully_discrete)\s+seconds = ")
        self.browser.key("ArrowRight")
        self.assertNotEqual(self.tip("error"), first)

    def test_compare_points_at_one_time_in_all_pictures(self):
        directory = self.study("compare", "unit-both-ends", "--methods", "cvode,rigid")
        with open(os.path.join(directory, "compare.json")) as file:
            told = json.load(file)
        for row, method in zip(rows_of(directory, "compare.csv"), told["methods"], strict=True):
            for key in ("method", "mass", "steps", "events", "max_penetration", "relative_tolerance"):
                self.assertSame(method[key], row[key])
            for pair in told["pairs"]:
                if row["method"] == pair["other"]:
                    self.assertSame(pair["displacement_l2"], row["displacement_l2"])
                    self.assertSame(pair["energy_final"], row["energy_difference"])
        self.browser.move(*self.place("displacement-left", 3.0, 0))
        self.assertAlmostEqual(self.value("viscobar.links.t.place"), 3.0, delta=0.02)
        self.assertNotEqual(self.value("document.querySelector('[data-picture=displacement-left] .value').textContent"), "")
        self.browser.move(2, 2)
        self.value("viscobar.charts.get('displacement-right').host.focus()")
        self.browser.key("End")
        self.assertEqual(self.value("viscobar.links.t.place"), 6.0)


class ASweepsPage(Browsed):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        with open(os.path.join(cls.scratch.name, "sweep.toml"), "w") as file:
            file.write(f"""title = "A sweep"
scene = "{os.path.join(scenes, 'unit-both-ends.toml')}"
[set]
time.end = 2.0
[vary]
bar.viscosity = [0.01, 0.1, 1.0]
left.gap = [0.1, 0.2]
mesh.elements = [10, 20]
""")
        cls.directory = os.path.join(cls.scratch.name, "out")
        subprocess.run([program, "sweep", os.path.join(cls.scratch.name, "sweep.toml"), "-o", cls.directory, "--quiet"], check=True)

    def setUp(self):
        self.open(os.path.join(self.directory, "sweep.html"))

    def count(self, selector):
        return self.value(f"document.querySelectorAll('{selector}').length")

    def choose(self, label, option):
        self.value(f"""(() => {{ const menu = document.querySelector("select[aria-label='{label}']");
            menu.value = {option!r}; menu.dispatchEvent(new Event("change")); }})()""")

    def test_draws_a_mark_for_each_case_that_the_filters_leave(self):
        self.assertSound()
        self.assertEqual(self.count(".sweep .mark"), 6)  # three viscosities for two gaps, on the first mesh
        self.choose("for each", "")
        self.assertEqual(self.count(".sweep .mark"), 3)

    def test_a_map_has_a_cell_for_each_pair(self):
        self.choose("as", "1")
        self.assertEqual(self.count(".sweep .cell"), 6)

    def test_a_click_shows_the_run_behind_a_point(self):
        rows = rows_of(self.directory, "sweep.csv")
        self.value("document.querySelectorAll('#sweep tbody tr')[1].click()")
        text = self.value("document.querySelector('.case').textContent")
        number = int(re.search(r"Case (\d+)", text).group(1))
        self.assertIn(f"--set 'bar.viscosity={float(rows[number]['bar.viscosity']):g}'", text)
        self.assertIn("viscobar run", text)

    def test_without_scripts_is_a_table(self):
        self.open(self.page, scripts=False)
        self.assertEqual(self.count("table tbody tr"), 12)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
