"""Bars in line: their keys, their joints and their limit, as the program has them."""
import json
import pathlib
import tempfile

import numpy as np

import viscobar
from support import Test, main, program, thrown


def chain(**changes):
    """A bar that meets a second one and stays behind."""
    return viscobar.Scene(
        {
            "bar": [{"length": 1.0, "viscosity": 0.05, "velocity": 1.0}, {"length": 0.5, "viscosity": 0.05}],
            "joint": [{"kind": "contact", "gap": 0.05}],
            "time": {"end": 3.0},
            "mesh": {"elements": 24},
            **changes,
        },
        validate=False,
    )


class KeysTest(Test):
    def test_of_chains_are_set_as_by_the_program(self):
        settings = {"bar.2.modulus": 4.0, "joint.1.gap": 0.1, "bar.1.velocity": 0.5}
        with tempfile.TemporaryDirectory() as directory:
            file, out = pathlib.Path(directory) / "chain.toml", pathlib.Path(directory) / "out"
            chain().save(file)
            program("run", file, "-o", out, "--quiet", "--no-estimate", *(f"--set={key}={value}" for key, value in settings.items()))
            told = json.loads((out / "summary.json").read_text())["scene"]
            theirs = np.loadtxt(out / "ends.csv", delimiter=",", skiprows=1)
            ours = viscobar.run(file, set=settings)
            self.assertEqual(viscobar.load(file), chain())
        self.assertEqual(ours.summary["scene"], told)
        self.assertTrue(np.array_equal(np.array([*ours.ends.values()]).T, theirs))
        self.assertTrue(np.array_equal(ours.u, viscobar.run(chain().changed(settings)).u))
        self.assertEqual(chain()["bar"][1].get("modulus"), None)

    def test_of_chains_begin_at_nodes_where_a_run_has_ended(self):
        # Bonded, and a body and a bar that share a place and move apart.
        scene = chain(
            bar=[{"length": 1.0, "viscosity": 0.05}, {"length": 0.5, "viscosity": 0.05, "modulus": 2.0}, {"mass": 0.5}],
            joint=[{"kind": "bonded"}, {"kind": "spring", "stiffness": 2.0}],
            initial={"velocity": "cos(2*x)"},
            mesh={"elements": 60},
            method={"name": "rigid", "relative_tolerance": 1e-9},
        )
        whole = viscobar.run(scene, times=[1.5, 3.0])
        rest = scene.changed({"initial.displacement": whole.u[0], "initial.velocity": whole.v[0], "time.end": 1.5})
        second = viscobar.run(rest, times=[0.0, 1.5])
        self.assertLess(np.abs(second.u[0] - whole.u[0]).max(), 1e-15)
        self.assertLess(np.abs(second.u[-1] - whole.u[-1]).max(), 1e-5)

    def test_of_chains_begin_with_functions_of_the_whole_where_a_bar_has_none_of_its_own(self):
        bars = [{"length": 1.0, "viscosity": 0.1}, {"mass": 0.5, "velocity": 0.2}, {"length": 0.5, "viscosity": 0.1}]
        formulas = {"initial": {"velocity": "0.5+sin(x)", "displacement": "0.01*x"}}
        functions = {"initial": {"velocity": lambda x: 0.5 + np.sin(x), "displacement": lambda x: 0.01 * x}}
        one, other = (viscobar.run(chain(bar=bars, joint=[{"kind": "bonded"}, {"kind": "spring", "stiffness": 2.0}],
                                         mesh={"elements": 24}, **initial)) for initial in (formulas, functions))  # fmt: skip
        self.assertGreater(np.abs(one.v[0]).max(), 0.5)
        self.assertLess(np.abs(one.u - other.u).max(), 1e-6)
        with self.assertRaisesRegex(viscobar.SceneError, "bar: must be a table"):
            viscobar.run({"bar": [1, 2], **functions})

    def test_of_chains_take_a_profile_at_nodes(self):
        scene = chain(load={"profile": "1+x", "history": 1.0})
        run = viscobar.run(scene)
        self.assertLess(np.abs(viscobar.run(scene, set={"load.profile": 1 + run.x}).u - run.u).max(), 1e-9)

    def test_of_chains_are_told_wrong_in_the_words_of_the_program(self):
        for settings, words in (
            ({"bar.4.modulus": 2.0}, "bar.4: there are 2 tables [[bar]]"),
            ({"bar.modulus": 2.0}, "bar.modulus: says not which of 2 bars: write bar.1.modulus"),
            ({"bar.2.moduls": 2.0}, 'bar.2.moduls: unknown key; nearest is "modulus"'),
            ({"joint.2.gap": 0.1}, "joint.2.kind: is the joint behind bar 2, and there are 2 bars"),
        ):
            with self.subTest(words), self.assertRaises(viscobar.SceneError) as raised:
                viscobar.run(chain(), set=settings)
            self.assertEqual(str(raised.exception).splitlines()[0], words)
        with self.assertRaisesRegex(viscobar.SceneError, "bar.2: there are 0 tables"):
            viscobar.run(thrown(), set={"bar.2.modulus": 2.0})

    def test_of_chains_are_taken_by_fits_and_sensitivities(self):
        scene = chain(method={"name": "rigid"})
        measured = viscobar.run(scene, set={"bar.2.modulus": 1.3}).ends
        found = viscobar.fit(scene, ["bar.2.modulus"], data={key: measured[key] for key in ("t", "u_right")}, set={"bar.2.modulus": 1.2})
        self.assertAlmostEqual(found.estimates["bar.2.modulus"], 1.3, 4)
        rates = viscobar.run(scene, set={"sensitivity.of": ["joint.1.gap"], "joint.1.gap": 0.1}).sensitivity
        # The bars meet at t = gap / speed, and nothing else changes.
        self.assertAlmostEqual(rates["joint.1.gap"]["contact_times"][0], 1.0, 9)

    def test_of_a_bar_take_samples(self):
        x = np.linspace(0.0, 1.0, 11)
        formula, sampled = (viscobar.run(chain(), set={"bar.1.velocity": value}) for value in ("1+x", (x, 1 + x)))
        self.assertLess(np.abs(formula.u - sampled.u).max(), 1e-6)

    def test_of_chains_have_values_between_nodes_at_joints_too(self):
        bodies = [{"mass": 1.0, "velocity": 0.5}, *chain()["bar"], {"mass": 0.5, "velocity": -0.1}]
        result = viscobar.run(chain(bar=bodies, joint=[{"kind": "contact", "gap": 0.05}] * 3))
        k, (joint,) = len(result.t) // 2, np.flatnonzero(result.x == 1.0)[:1]
        ends = [result.u[k, 1], result.u[k, joint], result.u[k, -2]]
        self.assertTrue(np.array_equal(result.at(result.t[k], [0.0, 1.0, 1.5])[0], ends))

    def test_of_a_table_are_laid_over_it(self):
        scene = viscobar.Scene(thrown())
        other = scene.changed({"bar": {"viscosity": 0.2}, "left": {"contact": {"law": "hertz"}}})
        self.assertEqual(other["bar"], {"length": 1.0, "viscosity": 0.2})
        self.assertEqual(other.changed({"left.contact": {"stiffness": 9.0}})["left"]["contact"], {"law": "hertz", "stiffness": 9.0})
        self.assertEqual((scene, scene.changed({"bar": {"viscosity": None}})["bar"]), (thrown(), {"length": 1.0}))
        self.assertEqual(chain().changed({"bar.1": {"modulus": 2.0}})["bar"][0], {**chain()["bar"][0], "modulus": 2.0})
        self.assertNotIn("contact", scene.changed({"contact": None}))
        self.assertEqual(other.changed({"left.contact.law": None}), other.changed({"left.contact": None}))
        self.assertNotIn("load", viscobar.Scene(thrown(load__density="x")).changed({"load.density": None}))

    def test_of_an_end_go_with_its_kind(self):
        free = viscobar.run(thrown(), set={"left.kind": "free"})
        self.assertEqual(free.scene["left"], {"kind": "free"})
        self.assertTrue(np.array_equal(free.u, viscobar.run({**thrown(), "left": {"kind": "free"}}).u))
        with self.assertRaisesRegex(viscobar.SceneError, "left.gap: belongs to an obstacle"):
            viscobar.run(thrown(), set={"left.kind": "free", "left.gap": 0.1})
        with self.assertRaisesRegex(viscobar.SceneError, "left.gapp: unknown key"):
            viscobar.run(thrown(left__gapp=0.1), set={"left.kind": "free"})


class JointsTest(Test):
    def test_have_the_columns_of_the_program(self):
        with tempfile.TemporaryDirectory() as directory:
            file, out = pathlib.Path(directory) / "chain.toml", pathlib.Path(directory) / "out"
            chain().save(file)
            program("run", file, "-o", out, "--quiet", "--no-estimate")
            head, *rows = (out / "joints.csv").read_text().splitlines()
        ours = viscobar.run(chain()).joints
        self.assertEqual(list(ours), head.split(","))
        self.assertTrue(np.array_equal(np.array([*ours.values()]).T, [[float(cell) for cell in row.split(",")] for row in rows]))
        self.assertGreater(ours["force:1"].max(), 0.0)
        self.assertEqual(list(viscobar.run(thrown()).joints), ["t"])


class LimitTest(Test):
    def test_of_a_chain_is_that_of_the_program(self):
        epsilon = [1e-2, 1e-3, 1e-4]
        told = []
        ours = viscobar.limit(chain(), epsilon=epsilon, budget=0.0, progress=lambda done, of: told.append((done, of)))
        with tempfile.TemporaryDirectory() as directory:
            file = pathlib.Path(directory) / "chain.toml"
            chain().save(file)
            theirs = json.loads(program("limit", file, "--epsilon", "1e-2:1e-4", "--budget", "0", "--json", "-o", f"{directory}/out"))
        self.assertEqual(ours.verdict, theirs["verdict"])
        self.assertEqual(ours.column("max_penetration"), [row["max_penetration"] for row in theirs["rows"]])
        self.assertEqual(told[-1][0], told[-1][1])

    def test_refuses_what_has_none(self):
        free = chain(joint=[{"kind": "bonded"}])
        law = chain(joint=[{"kind": "contact", "gap": 0.05, "law": "hertz", "stiffness": 50.0}])
        for scene, words in ((free, "the scene has no obstacle"), (law, "joint.1.law: limit studies the penalty")):
            with self.assertRaises(viscobar.SceneError) as raised:
                viscobar.limit(scene, epsilon=[1e-2])
            self.assertIn(words, str(raised.exception))


if __name__ == "__main__":
    main()
