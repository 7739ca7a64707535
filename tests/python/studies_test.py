"""Comparisons, studies, sweeps and schemes of one's own."""
import json
import math
import pathlib
import sys
import tempfile

import numpy as np

import viscobar
from support import ROOT, SCENES, Test, main, program, thrown

sys.path.insert(0, str(ROOT / "examples" / "python"))
import compare_schemes
from newmark import newmark
from nitsche import nitsche


def still(case):
    """A scheme that is right until the bar meets something: rigid flight."""
    t = np.linspace(0.0, case.end, 11)
    u = case.displacement + np.outer(t, case.velocity)
    return {"t": t}, (u, np.broadcast_to(case.velocity, u.shape))


class StudiesTest(Test):
    def program(self, command, *options):
        with tempfile.TemporaryDirectory() as directory:
            scene = pathlib.Path(directory) / "scene.toml"
            viscobar.Scene(thrown()).save(scene)
            out = [] if command == "check" else ["-o", f"{directory}/out"]
            return json.loads(program(command, scene, "--json", *out, *options))

    def test_compare_has_the_numbers_of_the_program(self):
        theirs = self.program("compare", "--methods", "ida,cvode,fully_discrete")
        ours = viscobar.compare(thrown(), ["ida", "cvode", "fully_discrete"])
        self.assertEqual(ours.reference, "ida")
        self.assertEqual(ours.summary["pairs"], theirs["pairs"])
        for row, entry, pair in zip(ours[1:], theirs["methods"][1:], theirs["pairs"]):
            self.assertEqual(row["steps"], entry["steps"])
            self.assertEqual((row["mass"], row["events"]), (entry["mass"], entry["events"]))
            self.assertEqual(row["end_trace"], pair["end_trace"])
        self.assertIsNone(ours[0]["end_trace"])
        self.assertEqual(viscobar.compare(thrown()).summary["skipped"], self.program("compare")["skipped"])

    def test_limit_has_the_numbers_of_the_program(self):
        theirs = self.program("limit", "--epsilon", "1e-2:1e-5")
        ours = viscobar.limit(thrown(), epsilon=[1e-2, 1e-3, 1e-4, 1e-5])
        self.assertEqual(ours.verdict, theirs["verdict"])
        for row, entry in zip(ours, theirs["rows"]):
            for key in ("epsilon", "events", "max_penetration", "difference_to_rigid"):
                self.assertEqual(row[key], entry[key])
        theirs = self.program("limit", "--set", "bar.modulus=1e6", "--set", "time.end=0.002")
        ours = viscobar.limit(thrown(bar__modulus=1e6, time__end=0.002))  # penalties of 1e-8 and less
        self.assertEqual(ours.column("epsilon"), [row["epsilon"] for row in theirs["rows"]])
        with self.assertRaisesRegex(viscobar.SceneError, "no obstacle"):
            viscobar.limit(thrown(left__kind="free", left__gap=None))

    def test_an_ensemble_has_the_axes_of_its_parameters(self):
        scene = viscobar.Scene(
            {
                "bar": {"length": 1.0, "viscosity": 0.1},
                "left": {"kind": "obstacle", "gap": 0.1},
                "initial": {"velocity": -1.0},
                "mesh": {"elements": 24},
                "time": {"end": 3.0},
            }
        )
        viscosity, gap = np.meshgrid([0.05, 0.1, 0.2], [0.1, 0.2], indexing="ij")
        outputs = ["u_left@0.5", "events:3", "impulse_left", "final", "gauge:0.25@1"]
        told = []
        many = viscobar.ensemble(
            scene, {"bar.viscosity": viscosity, "left.gap": gap}, outputs, error=1e-4, progress=lambda done, all: told.append((done, all))
        )
        self.assertEqual([many[one].shape for one in outputs], [(3, 2, 7), (3, 2, 3), (3, 2), (3, 2, 2, 25), (3, 2, 4, 4)])
        self.assertEqual(told[-1], (6, 6))
        self.assertTrue((many.status == viscobar.ensemble_statuses.index("kept")).all())
        self.assertTrue((many.error <= 1e-4).all())
        one = viscobar.run(
            scene,
            set={"bar.viscosity": 0.2, "left.gap": 0.1, "method.name": "rigid", "method.relative_tolerance": 1e-9, "output.every": 0.5},
        )
        self.assertLess(abs(many["u_left@0.5"][2, 0] - one.ends["u_left"]).max(), 3e-4 * abs(one.ends["u_left"]).max())
        np.testing.assert_array_equal(many.times["u_left@0.5"], one.t)
        with self.assertRaisesRegex(ValueError, "is not known"):
            viscobar.ensemble(scene, {"bar.viscosity": [0.1]}, ["u_middle@1"])

        def broken(done, all):
            raise ZeroDivisionError

        with self.assertRaises(ZeroDivisionError):
            viscobar.ensemble(scene, {"bar.viscosity": [0.1]}, ["final"], error=1e-2, progress=broken)

    def test_a_solution_is_judged_as_by_the_program(self):
        scene = thrown(output__gauges=[0.25, np.float64(0.5)])
        run = viscobar.run(scene, "fully_discrete")
        self.assertEqual(list(run.gauges), ["t"] + [f"{q}@{x}" for x in (0.25, 0.5) for q in ("u", "v", "strain", "stress")])
        np.testing.assert_allclose(run.gauges["u@0.25"], run.u[:, 5], rtol=0, atol=1e-14)  # a node
        theirs = viscobar.judge(
            scene, run.t, u_left=run.ends["u_left"], reaction_left=run.ends["reaction_left"],
            columns={"u@0.25": run.gauges["u@0.25"]},
        )  # fmt: skip
        self.assertEqual(theirs.column("quantity"), ["u_left", "reaction_left", "u@0.25"])
        self.assertEqual((theirs.missed, theirs.made_up), (0, 0))
        with tempfile.TemporaryDirectory() as directory:
            file, path = pathlib.Path(directory) / "scene.toml", pathlib.Path(directory) / "theirs.csv"
            viscobar.Scene(scene).save(file)
            np.savetxt(path, np.column_stack([run.t, run.ends["u_left"]]), delimiter=",", header="t,u_left", comments="", fmt="%.17g")
            told = json.loads(program("compare", file, "--json", "--with", path, "-o", f"{directory}/out"))
            both = viscobar.judge(scene, files=[[f"{path}=0.1"], [f"{path}=0.05"]])
            self.assertEqual(both.column("order"), [None, None])  # of two schemes
        self.assertEqual(theirs[0]["largest"], told["judged"][0]["columns"]["u_left"]["largest"])
        by_events = viscobar.judge(scene, run.t, u_left=run.ends["u_left"], events=run.events)
        self.assertEqual(by_events.contacts.column("verdict"), ["found"])
        self.assertEqual(by_events.contacts[0]["their_begin"], run.events["t"][0])
        alone = viscobar.judge(scene, events={"t": [0.5], "where": ["left"], "change": ["closing"]})
        self.assertEqual((len(alone), len(alone.contacts)), (0, 1))
        with self.assertRaisesRegex(ValueError, "no column"):
            viscobar.judge(scene, run.t, nonsense=run.t)
        with self.assertRaises(TypeError):
            viscobar.judge(scene)

    def test_precision_has_the_errors_of_the_program(self):
        options = {"methods": ["cvode"], "tolerances": [1e-3, 1e-4], "seconds": 0.3}
        ours = viscobar.precision(thrown(), **options)
        theirs = self.program("precision", "--methods", "cvode", "--tolerance", "1e-3:1e-4", "--seconds", "0.3")
        self.assertEqual([row["error"] for row in ours], [row["error"] for row in theirs["rows"]])

    def test_check_is_that_of_the_program(self):
        def timeless(value):
            if isinstance(value, dict):
                return {key: timeless(one) for key, one in value.items() if key != "seconds"}
            return [timeless(one) for one in value] if isinstance(value, list) else value

        self.assertEqual(timeless(viscobar.check(thrown())), timeless(self.program("check")))

    def test_sweep_has_the_rows_of_the_program(self):
        with tempfile.TemporaryDirectory() as directory:
            directory = pathlib.Path(directory)
            viscobar.Scene(thrown()).save(directory / "scene.toml")
            (directory / "sweep.toml").write_text(
                'scene = "scene.toml"\n[vary]\nbar.viscosity = [0.05, 0.1]\nmesh.elements = [10, 20]\n'
                'mesh.mass = ["consistent", "redistributed"]\n'
            )
            program("sweep", directory / "sweep.toml", "-o", directory / "out", "--quiet")
            lines = [line.split(",") for line in (directory / "out" / "sweep.csv").read_text().splitlines()]
            from_file = viscobar.sweep(directory / "sweep.toml")
        vary = {"bar.viscosity": [0.05, 0.1], "mesh.elements": [10, 20], "mesh.mass": ["consistent", "redistributed"]}
        for rows in (from_file, viscobar.sweep(thrown(), vary, threads=1), viscobar.sweep(thrown(), vary, threads=3)):
            self.assertEqual(len(rows), 8)
            for row, line in zip(rows, lines[1:]):
                for key, cell in zip(lines[0], line):
                    if key in ("completed", "error"):
                        continue
                    if isinstance(row[key], float):
                        same = row[key] == float(cell) if cell else math.isnan(row[key])
                    else:
                        same = str(row[key]) == cell
                    self.assertTrue(same, (key, row[key], cell))

    def test_sweep_has_the_derivatives_that_the_scene_asks_for(self):
        scene = {**thrown(), "sensitivity": {"of": ["left.gap"]}}
        for row in viscobar.sweep(scene, {"mesh.elements": [10, 20]}):
            told = viscobar.run(scene, set={"mesh.elements": row["mesh.elements"]}).summary["sensitivity"]["left.gap"]
            self.assertEqual(row["impulse_left/left.gap"], told["impulse_left"])
            self.assertEqual(row["first_closing/left.gap"], told["contact_times"][0])

    def test_fit_is_that_of_the_program(self):
        measured = viscobar.run(thrown(), set={"bar.viscosity": 0.12})
        traces = {key: measured.ends[key].copy() for key in ("t", "u_left")}
        traces["u_left"][3] = np.nan
        options = {"bounds": {"bar.viscosity": (0.01, 1.0)}, "deviations": {"u_left": 1e-3}}
        found = viscobar.fit(thrown(), ["bar.viscosity"], data=traces, **options)
        self.assertTrue(found.converged)
        self.assertAlmostEqual(found.estimates["bar.viscosity"], 0.12, 6)
        self.assertEqual(found.covariance.shape, (1, 1))
        with tempfile.TemporaryDirectory() as directory:
            file = pathlib.Path(directory) / "trace.csv"
            cells = [f"{t!r},{'' if math.isnan(u) else repr(float(u))}" for t, u in zip(map(float, traces["t"]), traces["u_left"])]
            file.write_text("t,u_left\n" + "\n".join(cells) + "\n")
            theirs = self.program(
                "fit", "--data", file, "--parameters", "bar.viscosity", "--bounds", "bar.viscosity=0.01:1.0",
                "--deviation", "u_left=0.001",
            )  # fmt: skip
            again = viscobar.fit(thrown(), ["bar.viscosity"], data=file, **options)
        for ours in (found, again):
            self.assertEqual(ours.summary["parameters"], theirs["parameters"])
            self.assertEqual(ours.summary["runs"], theirs["runs"])
        with self.assertRaisesRegex(ValueError, "there are no data"):
            viscobar.fit(thrown(), ["bar.viscosity"])
        alone = viscobar.fit(thrown(), "bar.viscosity", data=traces, **options)  # a text is one key, not its letters
        self.assertEqual(alone.summary["parameters"], found.summary["parameters"])

    def test_arrays_are_told_by_the_names_of_their_tables(self):
        run = viscobar.run(thrown())
        t, u = np.array(run.t), np.array(run.ends["u_left"])
        coded = {"t": t, "u_left": np.where(np.arange(len(t)) == 3, -9999.0, u)}
        found = viscobar.fit(thrown(), ["left.gap"], data=coded)
        for told in (found.summary["data"][0], found.summary["warnings"][0]):
            self.assertTrue(told.startswith("data.csv: "), told)
        self.assertNotIn(tempfile.gettempdir(), found.page)
        with self.assertRaisesRegex(ValueError, r"^data\.csv:\d+: the last time is"):
            viscobar.fit(thrown(), ["left.gap"], data={"t": 1e3 * t, "u_left": u})
        with self.assertRaisesRegex(viscobar.SceneError, r"^data\.csv:1:2: u_lefft: unknown column"):
            viscobar.fit(thrown(), ["left.gap"], data={"t": t, "u_lefft": u})
        with self.assertRaisesRegex(viscobar.SceneError, r"^solution\.csv:2:2: u_left: "):
            viscobar.judge(thrown(), t, u_left=np.where(t == 0, np.inf, u))
        judged = viscobar.judge(thrown(), **coded)
        self.assertNotIn(tempfile.gettempdir(), json.dumps(judged.summary))

    def test_sweep_says_what_is_wrong(self):
        rows = viscobar.sweep(thrown(), {"left.gap": np.array([0.1, -1.0])})
        self.assertEqual([row["completed"] for row in rows], [True, False])
        self.assertIn("must not be negative", rows[1]["error"])
        with self.assertRaisesRegex(viscobar.SceneError, "viscosity"):
            viscobar.sweep(thrown(), {"bar.viscosty": [0.1]})
        with self.assertRaisesRegex(ValueError, "different numbers"):
            viscobar.sweep(thrown(), {"bar.viscosity": [0.1], "left.gap": [0.1, 0.2]}, combine="zip")
        with self.assertRaisesRegex(ValueError, "initial.velocity"):
            viscobar.sweep(thrown(initial__velocity=lambda x: -1.0), {"bar.viscosity": [0.1]})

    def test_run_scenes_with_python_functions(self):
        scene = thrown(load__density=lambda x, t: 0.1 * x * t)
        rows = viscobar.compare(scene, ["cvode", "arkode"])
        # 100 times the tolerance is what each promises.
        self.assertLess(rows[1]["end_trace"], 2 * 100 * 1e-6 * 2.0)
        self.assertEqual(viscobar.limit(scene, epsilon=[1e-2, 1e-3]).column("epsilon"), [1e-2, 1e-3])


class SchemesTest(Test):
    def test_in_python_stand_beside_the_built_in_ones(self):
        rows = viscobar.compare(thrown(), ["rigid", "fully_discrete", newmark], schemes={"mine": nitsche})
        self.assertEqual(rows.column("method"), ["rigid", "fully_discrete", "newmark", "mine"])
        self.assertEqual([row["events_matched"] for row in rows[1:]], [2, 2, 2])
        for row in rows[2:]:
            self.assertLess(row["end_trace"], 0.02)  # of order h = 1/20, of the impact; dt = 1/100 is smaller
            self.assertLess(row["largest_event_shift"], 0.05)
        self.assertEqual({row["method"] for row in rows.contacts}, {"fully_discrete", "newmark", "mine"})
        self.assertEqual(rows.runs["mine"].u.shape, (31, 21))

    def test_of_examples_find_contact_time_and_rebound_of_a_viscous_bar(self):
        rows = {row["method"]: row for row in compare_schemes.rows()}
        # Contacts of a scheme last whole steps, 1e-3, from either end; the end node's momentum, h / 2 = 1/100, is taken from it
        # when the contact begins, which is not in the reaction.
        for name in ("newmark", "nitsche"):
            self.assertLess(abs(rows[name]["its error"]), 2e-3)
            self.assertLess(abs(rows[name]["error of it"]), 2e-2)

    def test_of_examples_converge_on_the_period_3_bar(self):
        for scheme in (newmark, nitsche):
            orders = viscobar.orders(scheme, SCENES / "period-3.toml", levels=3,
                                     set={"mesh.elements": 20, "method.step": 0.01, "time.end": 3.0,
                                          "contact.epsilon": 1e-3})  # fmt: skip
            errors = orders.column("displacement_l2")
            self.assertEqual(orders.column("elements"), [20, 40, 80])
            # The step resolves the penalty; where it does not, roundings decide how the node bounces.
            # Waves with corners: P1 elements have less than order 1, and more than 1/2.
            self.assertGreater(orders.order["displacement_l2"], 0.5)
            self.assertLess(orders.order["displacement_l2"], 1.5)
            self.assertEqual(errors, sorted(errors, reverse=True))

    def test_orders_of_a_built_in_method_are_those_of_a_smooth_motion(self):
        # Rigid flight until the contact at t = 0.1 is exact on any mesh.
        flight = {"u": lambda x, t: -t}
        orders = viscobar.orders(still, thrown(time__end=0.09, output__every=0.03), refine="mesh", levels=3, exact=flight)
        rounding = 10 * np.finfo(float).eps
        self.assertLess(max(orders.column("displacement_l2")), rounding)
        # (2.8) on a free bar with u_0 = cos(pi x): order 2 in dt and h, here against the exact solution.
        scene = thrown(left__kind="free", left__gap=None, bar__viscosity=0.0, initial__displacement="cos(pi*x)",
                       initial__velocity=0.0, time__end=1.0, mesh__mass="consistent", method__start="second_order")  # fmt: skip
        wave = {"u": lambda x, t: math.cos(math.pi * x) * math.cos(math.pi * t)}
        orders = viscobar.orders("fully_discrete", scene, levels=4, exact=wave)
        self.assertAlmostEqual(orders.order["displacement_l2"], 2.0, delta=0.1)
        scene["bar"]["viscosity"] = 1e-12  # no exact solution is known: each step beside the next finer one
        self.assertAlmostEqual(
            viscobar.orders("fully_discrete", scene, levels=4, refine="step").order["end_trace"], 2.0, delta=0.1)  # fmt: skip
        with self.assertRaisesRegex(ValueError, "no exact solution"):
            viscobar.orders("fully_discrete", thrown(), refine="mesh")

    def test_levels_of_compare_add_orders_where_they_settle(self):
        def rows(levels):
            scene = viscobar.load(SCENES / "period-3.toml")
            return viscobar.compare(scene, ["fully_discrete", nitsche], levels=levels,
                                    set={"mesh.elements": 10, "method.step": 0.02, "time.end": 3.0})  # fmt: skip

        # Waves with corners: less than order 1. Two levels show none, and contacts on the grid of (2.8) hide it on four.
        self.assertGreater(rows(4)[1]["order_displacement_l2"], 0.3)
        for row in rows(2):
            self.assertIsNone(row["order_displacement_l2"])

    def test_that_give_their_ends_only_are_compared_by_end_traces(self):
        def ends_only(case):
            ends, (u, v) = newmark(case)
            sides = {"u_left": u[:, 0], "v_left": v[:, 0], "u_right": u[:, -1], "v_right": v[:, -1]}
            return {**ends, **sides}, None

        both = viscobar.compare(thrown(), ["rigid", newmark, ends_only])
        self.assertEqual(both[1]["end_trace"], both[2]["end_trace"])
        self.assertIsNone(both[2]["displacement_l2"])

    def test_that_are_wrong_are_told_so(self):
        def raises(case):
            raise KeyError("mine")

        with self.assertRaisesRegex(KeyError, "mine"):
            viscobar.compare(thrown(), ["rigid", raises])
        for wrong, message in (
            (lambda case: 42, "returns"),
            (lambda case: ({}, None), '"t"'),
            (lambda case: ({"t": case.t}, (np.zeros((3, 3)), np.zeros((3, 3)))), r"u has the shape \(3, 3\), not \(31, 21\)"),
            (lambda case: ({"t": case.t[1:]}, (np.zeros((30, 21)),) * 2), "t = 0"),
            (lambda case: ({"t": case.t[:-1]}, (np.zeros((30, 21)),) * 2), "steps end before"),
            (lambda case: ({"t": case.t}, (np.full((31, 21), np.nan),) * 2), "not finite"),
        ):
            with self.assertRaisesRegex((ValueError, RuntimeError), message):
                viscobar.compare(thrown(), ["rigid"], schemes={"wrong": wrong})
        with self.assertRaisesRegex(viscobar.SceneError, 'nearest is "rigid"'):
            viscobar.compare(thrown(), ["rigit"])

    def test_are_given_what_the_scene_says(self):
        seen = []

        def look(case):
            seen.append(case)
            return still(case)

        viscobar.compare(thrown(load__profile="x", load__history="t", left__gap=5.0), [look])
        (case,) = seen
        self.assertEqual((case.elements, case.left, case.right, case.left_gap, case.right_gap), (20, "obstacle", "free", 5.0, None))
        self.assertEqual((case.length, case.density, case.modulus, case.viscosity), (1.0, 1.0, 1.0, 0.1))
        self.assertEqual((case.epsilon, case.restitution, case.step, case.end), (1e-3, None, 1e-2, 3.0))
        self.assertTrue(np.array_equal(case.load(2.0), 2.0 * case.x))
        self.assertTrue(np.array_equal(case.velocity, -np.ones(21)))
        self.assertEqual(len(case.t), 31)


if __name__ == "__main__":
    main()
