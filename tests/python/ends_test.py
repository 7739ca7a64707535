"""What is done to the ends of a bar, by Python functions and by samples."""
import math
import tempfile
import warnings

import numpy as np

import viscobar
from support import Test, main, thrown

warnings.simplefilter("ignore", viscobar.RunWarning)

METHODS = ("cvode", "ida", "arkode", "odeint", "rigid", "exponential", "fully_discrete")


def bar(left, method="cvode", **changes):
    scene = thrown(mesh__mass="consistent", mesh__elements=8, method__relative_tolerance=1e-9, **changes)
    return viscobar.run({**scene, "left": left}, method)


class EndsTest(Test):
    def test_a_force_that_is_a_function_gives_the_digits_of_the_formula(self):
        for method in METHODS:
            with self.subTest(method):
                left = {"kind": "obstacle", "gap": 0.1}
                formula = bar({**left, "force": "0.3*sin(2*t)"}, method)
                function = bar({**left, "force": lambda t: 0.3 * math.sin(2 * t)}, method)
                self.assertTrue(np.array_equal(formula.u, function.u))
                self.assertIn("function", function.summary["scene"]["left"]["force"])

    def test_a_stop_has_a_law_of_its_own_whose_numbers_are_set_one_by_one(self):
        left = {"kind": "obstacle", "gap": 0.1, "contact": {"law": "hertz", "stiffness": 50.0}}
        for method in METHODS[:4]:
            with self.subTest(method):
                soft, hard = bar(left, method), bar({**left, "contact": {"law": "hertz", "stiffness": 100}}, method)
                again = viscobar.run(soft.scene, set={"left.contact.stiffness": 100.0})
                self.assertTrue(np.array_equal(hard.u, again.u))
                self.assertFalse(np.array_equal(hard.u, soft.u))
                self.assertEqual(soft.summary["scene"]["left"]["contact"], {"law": "hertz", "stiffness": 50.0})
        with self.assertRaises(viscobar.SceneError) as caught:
            bar(left, "rigid")
        self.assertIn('"hertz" is no law for rigid', str(caught.exception))

    def test_a_motion_that_is_a_function_is_differentiated(self):
        # To within 1e-10 of its second derivative, far below the tolerance.
        for method in METHODS:
            with self.subTest(method):
                formula = bar({"kind": "fixed", "motion": "0.1*(1-cos(3*t))"}, method)
                function = bar({"kind": "fixed", "motion": lambda t: 0.1 * (1 - np.cos(3 * t))}, method)
                self.assertLess(np.abs(formula.u - function.u).max(), 100 * 1e-9 * np.abs(formula.u).max())

    def test_a_gap_that_is_a_function_moves_the_obstacle(self):
        for side in ("below", "above"):
            for method in METHODS:
                with self.subTest(side=side, method=method):
                    left = {"kind": "obstacle", "side": side}
                    moves = {"initial__velocity": -1.0 if side == "below" else 1.0}
                    formula = bar({**left, "gap": "0.1-0.02*sin(9*t)"}, method, **moves)
                    function = bar({**left, "gap": lambda t: 0.1 - 0.02 * math.sin(9 * t)}, method, **moves)
                    self.assertEqual(len(formula.events["t"]), len(function.events["t"]))
                    self.assertGreater(len(formula.events["t"]), 0)
                    # An impact on a mesh of eight elements answers to a shift of its time by the velocity times it.
                    self.assertLess(np.abs(formula.u - function.u).max(), 1000 * 1e-9 * np.abs(formula.u).max())

    def test_characteristics_take_functions_to_rounding(self):
        scene = thrown(bar__viscosity=0.0)
        del scene["contact"]
        for key, formula, function in (
            ("gap", "0.1-0.02*sin(9*t)", lambda t: 0.1 - 0.02 * math.sin(9 * t)),
            ("force", "0.3*sin(2*t)", lambda t: 0.3 * math.sin(2 * t)),
        ):
            left = {"kind": "obstacle", "gap": 0.1}
            one, other = (viscobar.run({**scene, "left": {**left, key: value}}, "characteristics") for value in (formula, function))
            self.assertLess(np.abs(one.u - other.u).max(), 1e-10)

    def test_a_kink_of_a_function_that_moves_an_end_is_found(self):
        formula = bar({"kind": "fixed", "motion": "min(0.4*t, 0.2)"}, initial__velocity=0.0)
        function = bar({"kind": "fixed", "motion": lambda t: min(0.4 * t, 0.2)}, initial__velocity=0.0)
        self.assertLess(np.abs(formula.u - function.u).max(), 100 * 1e-9 * np.abs(formula.u).max())

    def test_samples_are_taken_through_a_spline(self):
        # Its error falls with the fourth power of their distance, for a force and for what moves an end.
        t = lambda n: np.linspace(0.0, 3.0, n + 1)
        force, motion = lambda t: 0.3 * np.sin(2 * t), lambda t: 0.1 * (1 - np.cos(3 * t))
        for left, function in (({"kind": "free", "force": None}, force), ({"kind": "fixed", "motion": None}, motion)):
            key = list(left)[-1]
            exact = bar({**left, key: function})
            errors = [np.abs(bar({**left, key: (t(n), function(t(n)))}).u - exact.u).max() for n in (15, 30)]
            self.assertLess(errors[1], errors[0] / 8)
            self.assertLess(errors[1], 1e-4)
        self.assertEqual(bar({"kind": "free", "force": [t(15), t(15)]}).summary["scene"]["left"]["force"], "16 samples")

    def test_samples_are_initial_data_and_are_saved(self):
        x, t = np.linspace(0.0, 1.0, 41), np.linspace(0.0, 3.0, 41)
        formula = bar({"kind": "free"}, initial__displacement="0.1*cos(3*x)", initial__velocity="-x")
        scene = viscobar.Scene(thrown(), validate=False).changed({"left": {"kind": "free"}, "initial.displacement": (x, 0.1 * np.cos(3 * x)),
                                                                  "initial.velocity": (x, -x), "right": {"kind": "free", "force": (t, np.sin(t))}})  # fmt: skip
        sampled = bar({"kind": "free"}, initial__displacement=(x, 0.1 * np.cos(3 * x)), initial__velocity=(x, -x))
        self.assertLess(np.abs(formula.u - sampled.u).max(), 1e-6)
        with tempfile.TemporaryDirectory() as folder:
            scene.save(f"{folder}/scene.toml")
            again = viscobar.load(f"{folder}/scene.toml")
            self.assertTrue(np.array_equal(viscobar.run(again).u, viscobar.run(scene).u))
            with open(f"{folder}/record.csv", "w") as file:
                file.write("t,F\n" + "".join(f"{a!r},{b!r}\n" for a, b in zip(t.tolist(), np.sin(t).tolist())))
            named = scene.changed({"right.force": {"file": f"{folder}/record.csv", "column": "F"}})
            self.assertTrue(np.array_equal(viscobar.run(named).u, viscobar.run(scene).u))

    def test_samples_beside_a_jump_do_not_swing(self):
        # A free bar of mass 1: its mean is int int F, a ramp of 0.001 and then 1, so 0.5 (2 - 0.0005)^2 and a little.
        jump = ([0, 0.5, 1, 1.001, 2, 2.5, 3], [0, 0, 0, 1, 1, 1, 1])
        far = bar({"kind": "free", "force": jump}, right__kind="free", initial__velocity=0.0)
        self.assertLess(abs(np.mean(0.5 * (far.u[-1][1:] + far.u[-1][:-1])) - 1.999), 1e-3)

    def test_what_a_mask_hides_is_left_out_and_complex_numbers_are_refused(self):
        t, hidden = np.linspace(0.0, 3.0, 16), np.arange(16) == 7
        values = np.ma.array(np.where(hidden, 1e9, np.sin(t)), mask=hidden)
        masked, short = (bar({"kind": "free", "force": force}) for force in ((t, values), (t[~hidden], np.sin(t)[~hidden])))
        self.assertTrue(np.array_equal(masked.u, short.u))
        table = bar({"kind": "free", "force": {"t": np.ma.array(t, mask=hidden), "values": np.sin(t)}})
        self.assertTrue(np.array_equal(table.u, short.u))
        for force, words in (
            ((t, np.exp(1j * t)), "samples that are no numbers: complex numbers"),
            ({"t": t, "values": np.exp(1j * t)}, "samples that are no numbers: complex numbers"),
            ((t, [np.zeros(2), *np.sin(t[1:])]), "samples that are no numbers"),
            ({"t": t, "values": np.zeros((16, 1))}, "samples of the shape (16, 1)"),
            ((t, np.zeros((16, 1))), "samples of the shape (16, 1)"),
        ):
            with self.assertRaises(viscobar.SceneError) as caught:
                viscobar.Scene({**thrown(), "left": {"kind": "free", "force": force}})
            self.assertIn("left.force: has " + words, str(caught.exception))

    def test_what_is_wrong_is_said_with_the_key(self):
        good = np.linspace(0.0, 3.0, 7)
        for left, words in (
            ({"kind": "free", "force": (good[:5], good[:5])}, "left.force: has values from t = 0 to 2, and the run goes from 0 to 3"),
            ({"kind": "free", "force": (good[::-1], good)}, "left.force: t must not decrease"),
            ({"kind": "free", "force": (good[:3], good[:3])}, "left.force: has values from t = 0 to 1, and"),
            ({"kind": "free", "force": (good, good[:5])}, "left.force: t has 7 numbers and values 5"),
            ({"kind": "free", "force": (good, 0 * good + np.nan)}, "left.force: a series is finite, and one is nan"),
            ({"kind": "fixed", "motion": lambda t: 1.0 + t}, "left.motion: must be 0 at t = 0"),
            ({"kind": "fixed", "motion": lambda t: 1 / (1 - t) if t != 1 else np.inf}, "left.motion: "),
            ({"kind": "obstacle", "gap": lambda t: t - 0.1}, "left.gap: must be finite and >= 0, is -0."),
            ({"kind": "obstacle", "gap": 0.1, "stiffness": lambda t: t}, "left.stiffness: is a Python function"),
            ({"kind": "obstacle", "gap": 0.1, "dashpot": (good, good)}, "left.dashpot: is given by samples"),
            ({"kind": "free", "motion": lambda t: t}, "left.motion: belongs to a fixed end"),
        ):
            with self.subTest(words), self.assertRaises(viscobar.SceneError) as caught:
                viscobar.Scene({**thrown(), "left": left})
            self.assertIn(words, str(caught.exception))

    def test_a_function_that_raises_is_heard(self):
        for left in ({"kind": "fixed", "motion": lambda t: t / 0}, {"kind": "free", "force": lambda t: t / 0}):
            with self.assertRaises(ZeroDivisionError):
                bar(left)


if __name__ == "__main__":
    main()
