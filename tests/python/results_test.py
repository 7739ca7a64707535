"""Results that are opened, saved, pickled and copied, and read between output times."""
import copy
import io
import pathlib
import pickle
import tempfile
import warnings

import numpy as np

import viscobar
from support import SCENES, Test, main, program, thrown

warnings.simplefilter("ignore", viscobar.RunWarning)


def asked():
    """A scene with everything that a result may have."""
    return {**thrown(output__gauges=[0.25]), "sensitivity": {"of": ["left.gap"]}, "title": "A throw, and all of it"}


class KeptTest(Test):
    def same_field(self, one, other):
        for name in ("t", "x", "u", "v", "stress"):
            self.assertTrue(np.array_equal(getattr(one, name), getattr(other, name)), name)

    def check(self, one, other):
        self.same_field(one, other)
        for name in ("ends", "energy", "gauges", "joints"):
            ours, theirs = getattr(one, name), getattr(other, name)
            self.assertEqual(list(ours), list(theirs))
            for key in ours:
                self.assertTrue(np.array_equal(ours[key], theirs[key]), key)
        self.assertEqual(one.events.tolist(), other.events.tolist())
        self.assertEqual(one.summary, other.summary)
        self.assertEqual(one.page(), other.page())
        self.assertEqual((one.method, one.warnings, one.completed, one.error_estimate), (other.method, other.warnings, other.completed, other.error_estimate))  # fmt: skip
        for key, told in one.sensitivity.items():
            for name in ("u", "v", "contact_times"):
                self.assertTrue(np.array_equal(told[name], other.sensitivity[key][name], equal_nan=True))

    def test_a_result_comes_back_from_a_directory_that_the_program_takes_for_its_own(self):
        result = viscobar.run(asked())
        with tempfile.TemporaryDirectory() as directory:
            where = pathlib.Path(directory) / "kept"
            result.save(where)
            again = viscobar.open(where)
            self.check(result, again)
            self.assertTrue(np.array_equal(viscobar.run(again.scene).u, result.u))
            self.assertIn("sound", program("info", "--verify", where))
            viscobar.run(asked(), "rigid").save(f"{directory}/rigid")
            program("compare", where, f"{directory}/rigid", "-o", f"{directory}/compared")
            with self.assertRaisesRegex(FileExistsError, "not empty"):
                result.save(where)
            again.save(f"{directory}/twice")
            self.check(result, viscobar.open(f"{directory}/twice"))

    def test_a_directory_of_the_program_is_opened(self):
        with tempfile.TemporaryDirectory() as directory:
            for scene in ("chatter.toml", "hopkinson.toml"):
                out = pathlib.Path(directory) / scene
                program("run", SCENES / scene, "-o", out, "--quiet", "--no-estimate", "--figures")
                viscobar.open(out).save(f"{out}.copy")
                self.assertIn("sound", program("info", "--verify", f"{out}.copy"))
                opened, result = viscobar.open(out), viscobar.run(SCENES / scene)
                self.same_field(opened, result)
                ours, theirs = ({**one.ends, **one.joints, **one.gauges} for one in (result, opened))
                self.assertEqual(list(ours), list(theirs))
                for name, values in ours.items():
                    self.assertTrue(np.array_equal(theirs[name], values), name)
                self.assertEqual(opened.events.tolist(), result.events.tolist())

    def test_what_is_no_result_is_said(self):
        with tempfile.TemporaryDirectory() as directory:
            with self.assertRaisesRegex(ValueError, "holds no result of a run"):
                viscobar.open(directory)
            out = f"{directory}/out"
            viscobar.run(thrown()).save(out)
            with open(f"{out}/ends.csv", "a") as file:
                file.write("1,2\n")
            with self.assertRaisesRegex(OSError, "ends.csv.*damaged"):
                viscobar.open(out)

    def test_files_that_were_not_written_are_missed_when_they_are_asked_for(self):
        with tempfile.TemporaryDirectory() as directory:
            scene = viscobar.Scene(thrown(output__write=["ends"]))
            scene.save(f"{directory}/scene.toml")
            program("run", f"{directory}/scene.toml", "-o", f"{directory}/out", "--quiet", "--no-estimate")
            opened = viscobar.open(f"{directory}/out")
            self.assertTrue(np.array_equal(opened.ends["u_left"], viscobar.run(scene).ends["u_left"]))
            with self.assertRaisesRegex(ValueError, "no field.h5"):
                opened.u
            with self.assertRaisesRegex(ValueError, "no report.html"):
                opened.page()

    def test_a_result_is_pickled_and_copied(self):
        scene = asked()
        scene["initial"]["velocity"] = lambda x: -1.0  # cannot be pickled, and is told by its name
        result = viscobar.run(scene, set={"sensitivity": None})
        pickled = pickle.loads(pickle.dumps(result))
        self.check(result, pickled)
        self.assertIn("function", pickled.scene["initial"]["velocity"])
        self.check(result, pickle.loads(pickle.dumps(pickled)))
        for other in (copy.copy(result), copy.deepcopy(result)):
            self.check(result, other)
        self.assertIsNot(copy.deepcopy(result).scene["bar"], result.scene["bar"])
        compared = viscobar.compare(thrown(), ["rigid", "cvode"])
        for other in (pickle.loads(pickle.dumps(compared)), copy.deepcopy(compared)):
            self.assertEqual((list(other), other.summary, list(other.runs)), (list(compared), compared.summary, list(compared.runs)))
            self.assertTrue(np.array_equal(other.runs["cvode"].u, compared.runs["cvode"].u))
            self.assertEqual(other.runs["cvode"].events.tolist(), compared.runs["cvode"].events.tolist())

    def test_nothing_can_be_written_to_a_result(self):
        seen = []
        result = viscobar.run(asked(), observer=lambda t, u, v: seen.append((u, v)) and False)
        arrays = [result.t, result.x, result.u, result.v, result.stress, result.events, result.sensitivity["left.gap"]["u"], *seen[0]]
        for columns in (result.ends, result.energy, result.gauges, result.sensitivity["left.gap"]["ends"]):
            arrays += columns.values()
        for array in arrays:
            with self.assertRaisesRegex(ValueError, "read-only"):
                array[0] = array[1]
        self.assertTrue(result.u.copy().flags.writeable)


class TimesTest(Test):
    def test_of_ones_own_have_the_motion_of_the_scene(self):
        scene = thrown(method__relative_tolerance=1e-8)
        whole = viscobar.run(scene)
        times = np.array([0.05, 0.1, 0.15, 1.0, 2.95])
        some = viscobar.run(scene, times=times)
        self.assertTrue(np.array_equal(some.t, times))
        self.assertEqual((some.completed, some.reached_time), (True, 3.0))
        self.assertEqual(some.events.tolist(), whole.events.tolist())
        for k, t in enumerate(times):
            for n in np.flatnonzero(whole.t == t):
                self.assertTrue(np.array_equal(some.u[k], whole.u[n]))
        self.assertEqual(some.summary["contact"], whole.summary["contact"])
        for wrong in ([], [0.2, 0.1], [0.0, 3.1], [np.nan], [[0.1]], np.ma.array([0.1, 0.2], mask=[0, 1]), "soon"):
            with self.assertRaisesRegex(ValueError, "^times: "):
                viscobar.run(scene, times=wrong)

    def test_between_have_the_cubic_of_the_fourth_order(self):
        # A free bar in its first mode: u = cos(pi x) cos(pi t), u_tttt at most pi^4.
        scene = {"bar": {"length": 1.0}, "initial": {"displacement": "cos(pi*x)"}, "time": {"end": 1.0}, "mesh": {"elements": 64}}
        for every in (0.1, 0.05):
            result = viscobar.run(scene, "characteristics", set={"output.every": every})
            t = np.linspace(0.0, 1.0, 101)
            u, v = result.at(t)
            self.assertEqual((u.shape, v.shape), ((101, 65), (101, 65)))
            error = np.abs(u - np.outer(np.cos(np.pi * t), np.cos(np.pi * result.x))).max()
            self.assertLess(error, 1.01 * np.pi**4 * every**4 / 384)
            self.assertGreater(error, 0.5 * np.pi**4 * every**4 / 384)
            k = 3
            self.assertLess(np.abs(result.at(result.t[k])[1] - result.v[k]).max(), 1e-12)
        u, _ = result.at(0.5, [0.25, 0.5])
        self.assertEqual(u.shape, (2,))
        self.assertEqual(result.at(0.05, result.x[7])[0], result.at(0.05)[0][7])
        for t, x in ((1.1, None), (np.nan, None), (0.1, 1.5)):
            with self.assertRaisesRegex(ValueError, "^at: "):
                result.at(t, x)


class StartTest(Test):
    def test_values_at_the_nodes_are_initial_data(self):
        # A free bar goes on as it was: the wave equation is the same from any time on.
        scene = {"bar": {"length": 1.0, "viscosity": 0.1}, "initial": {"displacement": "cos(pi*x)"}, "time": {"end": 1.0},
                 "mesh": {"elements": 20, "mass": "consistent"}, "method": {"name": "cvode", "relative_tolerance": 1e-9}}  # fmt: skip
        whole = viscobar.run(scene)
        half = len(whole.t) // 2
        rest = viscobar.run(scene, set={"initial": {"displacement": whole.u[half], "velocity": whole.v[half]}, "time.end": 0.5})
        self.assertTrue(np.array_equal(rest.u[0], whole.u[half]))
        self.assertLess(np.abs(rest.u[-1] - whole.u[-1]).max(), 100 * 1e-9)
        self.assertEqual(rest.summary["scene"]["initial"]["velocity"], "21 values at the nodes")
        graded = viscobar.run({**scene, "mesh": {"nodes": [0.0, 0.1, 0.3, 0.6, 1.0]}})
        again = viscobar.run(graded.scene, set={"initial.displacement": np.cos(np.pi * graded.x).tolist()})
        self.assertLess(np.abs(again.u[0] - graded.u[0]).max(), 4 * np.finfo(float).eps)
        with self.assertRaisesRegex(viscobar.SceneError, "initial.displacement: has 21 values for the 31 nodes of the mesh"):
            viscobar.run(scene, set={"initial.displacement": whole.u[0], "mesh.elements": 30})


class NotebookTest(Test):
    def test_a_result_shows_itself_in_few_words_and_one_picture(self):
        long = viscobar.run(SCENES / "chatter.toml", set={"output.every": 1e-3})
        shown = long._repr_html_()
        self.assertLess(len(shown), 10_000)
        self.assertIn("<svg", shown)
        self.assertIn(f"<td>{len(long.events)}</td>", shown)
        rows = viscobar.Table([{"n": n} for n in range(1000)])
        self.assertIn("970 more rows", rows._repr_html_())
        self.assertLess(len(viscobar.limit(thrown(), epsilon=[1e-2, 1e-3])._repr_html_()), 10_000)


class PictureTest(Test):
    def setUp(self):
        try:
            import matplotlib
        except ImportError:
            self.skipTest("python3-matplotlib is not installed")
        matplotlib.use("Agg")

    def test_is_drawn_alone_and_on_axes_of_ones_own(self):
        from matplotlib import pyplot

        result, compared = viscobar.run(thrown()), viscobar.compare(thrown(), ["rigid", "cvode"])
        for kind in ("displacement", "ends", "reactions", "energy"):
            figure, (left, right) = pyplot.subplots(1, 2)
            self.assertIs(result.plot(kind, ax=right), figure)
            self.assertTrue(right.has_data() and not left.has_data())
            result.plot(kind).savefig(io.BytesIO())
        line = viscobar.run(
            {
                "bar": [{"length": 1.0, "velocity": 1.0}, {"length": 1.0, "velocity": 0.0}],
                "joint": [{"kind": "contact", "gap": 0.1}],
                "time": {"end": 1.0},
                "mesh": {"elements": 20},
            }
        )
        figure, axis = pyplot.subplots()
        line.plot("reactions", ax=axis)
        self.assertEqual([one.get_label() for one in axis.lines], ["joint 1"])
        self.assertGreater(axis.lines[0].get_ydata().max(), 0.0)
        figure, (left, right) = pyplot.subplots(1, 2)
        self.assertIs(viscobar.plot(result, ax=left), figure)
        self.assertIs(compared.plot("right", ax=left), figure)
        self.assertIs(viscobar.limit(thrown(), epsilon=[1e-2, 1e-3]).plot(ax=left), figure)
        for what in (result, compared):
            with self.assertRaisesRegex(ValueError, '"energies" is none of '):
                what.plot("energies")
        pyplot.close("all")


if __name__ == "__main__":
    main()
