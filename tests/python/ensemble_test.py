"""Arguments of viscobar.ensemble() and of other studies: what they take, and what is said of the rest."""
import numpy as np

import viscobar
from support import Test, main, thrown


def scene():
    tables = thrown(mesh__elements=12)
    del tables["contact"], tables["method"], tables["mesh"]["mass"]
    return tables


class EnsembleTest(Test):
    def test_hidden_values_are_faulty_bars(self):
        gap = np.ma.array([0.1, 1e9, 0.2], mask=[False, True, False])
        many = viscobar.ensemble(scene(), {"left.gap": gap}, "impulse_left", error="1 %")
        faulty = viscobar.ensemble_statuses.index("faulty")
        self.assertEqual((many.status == faulty).tolist(), [False, True, False])
        self.assertIn("left.gap: must be", many.messages[1])
        self.assertTrue(np.isnan(many["impulse_left"][1]))
        short = viscobar.ensemble(scene(), {"left.gap": [0.1, 0.2]}, ["impulse_left"], error=0.01)
        self.assertEqual(many["impulse_left"][[0, 2]].tolist(), short["impulse_left"].tolist())

    def test_numbers_alone_are_one_bar_without_an_axis(self):
        one = viscobar.ensemble(scene(), {"left.gap": 0.1}, ["impulse_left", "u_left@1"], error=0.01)
        self.assertEqual((one["impulse_left"].shape, one["u_left@1"].shape, one.status.shape), ((), (4,), ()))
        row = viscobar.ensemble(scene(), {"left.gap": [0.1]}, ["impulse_left", "u_left@1"], error=0.01)
        self.assertEqual(row["impulse_left"].shape, (1,))
        self.assertEqual(one["impulse_left"], row["impulse_left"][0])

    def test_what_is_wrong_is_said_in_the_words_of_the_parameter(self):
        for keys, options, kind, words in (
            ({"left.gap": 0.1}, {"threads": -1}, ValueError, "^threads: must not be negative, is -1"),
            ({"left.gap": 0.1}, {"threads": 1.5}, TypeError, "^threads: a whole number is wanted.*not 1.5"),
            ({"left.gap": 0.1}, {"progress": 3}, TypeError, "^progress: a function"),
            ({"left.gap": 0.1}, {"error": "much"}, ValueError, '^error: "much" is neither a number nor a percentage'),
            ({"left.gap": 0.1}, {"error": -1.0}, ValueError, "^error: a positive number"),
            ({"left.gap": [0.1j]}, {}, ValueError, "^left.gap: complex numbers"),
            ({"left.gap": "wide"}, {}, ValueError, "^left.gap: no numbers"),
            ({"left.gap": [0.1, 0.2], "bar.viscosity": [0.1] * 3}, {}, ValueError, r"left.gap \(2,\), bar.viscosity \(3,\)"),
            ({"left.gap": []}, {}, ValueError, "^left.gap: no values"),
            ({"left.gapp": [0.1]}, {}, ValueError, 'left.gapp: unknown key; nearest is "gap"'),
        ):
            with self.subTest(words), self.assertRaisesRegex(kind, words):
                viscobar.ensemble(scene(), keys, ["impulse_left"], **options)
        with self.assertRaisesRegex(TypeError, "^outputs: texts .* not 3"):
            viscobar.ensemble(scene(), {"left.gap": 0.1}, ["final", 3])
        with self.assertRaisesRegex(ValueError, "^parameters: the scene gives no number for left.stiffness"):
            viscobar.fit(scene(), ["left.stiffness"], data={"t": [0.0, 1.0], "u_left": [0.0, 0.0]})
        said = viscobar.ensemble(scene(), {"left.gap": [0.1, -1.0]}, ["impulse_left"]).messages[1]
        self.assertEqual(said, "left.gap: must not be negative, is -1")

    def test_other_studies_take_threads_alike(self):
        for study in (lambda threads: viscobar.compare(thrown(), ["rigid"], threads=threads),
                      lambda threads: viscobar.limit(thrown(), epsilon=[1e-2], threads=threads),
                      lambda threads: viscobar.precision(thrown(), methods=["rigid"], threads=threads),
                      lambda threads: viscobar.sweep(thrown(), {"left.gap": [0.1]}, threads=threads)):  # fmt: skip
            for threads, kind in ((-1, ValueError), (1.5, TypeError)):
                with self.assertRaisesRegex(kind, "^threads: "):
                    study(threads)


class ErrorsOnRequestTest(Test):
    def test_are_taken_by_limit_and_sweep(self):
        study = viscobar.limit(scene(), error="1 %", epsilon=[1e-2, 1e-3], budget=0.0, set={"mesh.elements": None})
        self.assertTrue(study.summary["error_estimate"]["kept"])
        with self.assertRaisesRegex(ValueError, "elements: error chooses the mesh"):
            viscobar.limit(scene(), error=1e-2, elements=[10])
        rows = viscobar.sweep(scene(), {"left.gap": [0.1, 0.2]}, error=1e-3, set={"mesh.elements": None})
        for row in rows:
            exact = viscobar.run(scene(), set={"left.gap": row["left.gap"], "mesh.elements": None}, error=1e-3)
            self.assertEqual(row["impulse_left"], exact.summary["contact"]["left"]["impulse"])
        self.assertEqual(viscobar.sweep(thrown(), {"left.gap": [0.1, -1.0]})[1]["error"], "left.gap: must not be negative, is -1")


if __name__ == "__main__":
    main()
