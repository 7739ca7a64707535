"""Pictures, pages and tables."""
import io

import viscobar
from support import Test, main, thrown

try:
    import matplotlib

    matplotlib.use("Agg")
except ImportError:
    matplotlib = None
try:
    import pandas
except ImportError:
    pandas = None


class PicturesTest(Test):
    def setUp(self):
        if matplotlib is None:
            self.skipTest("python3-matplotlib is not installed")

    def test_are_one_call_away(self):
        for what in (
            viscobar.run(thrown()),
            viscobar.run(thrown(), "rigid"),
            viscobar.compare(thrown(), ["cvode", "rigid"]),
            viscobar.limit(thrown(), epsilon=[1e-2, 1e-3, 1e-4]),
            viscobar.precision(thrown(), methods=["cvode"], tolerances=[1e-3, 1e-4], seconds=0.1),
        ):
            file = io.BytesIO()
            viscobar.plot(what).savefig(file)
            self.assertGreater(len(file.getvalue()), 10000)
        matplotlib.pyplot.close("all")


class PagesTest(Test):
    def test_of_a_run_are_those_of_the_program(self):
        page = viscobar.run(thrown()).page()
        for title in ("Displacement over space and time", "Ends", "Reactions", "Energy", "Contact changes"):
            self.assertTrue(f"<h2>{title}</h2>" in page, title)
        self.assertIn("<svg", page)

    def test_of_studies_stand_beside_their_rows(self):
        for what in (viscobar.compare(thrown(), ["cvode", "rigid"]), viscobar.limit(thrown(), epsilon=[1e-2, 1e-3])):
            self.assertRegex(what.page, "^<!DOCTYPE html>")


class TablesTest(Test):
    def test_are_data_frames_where_pandas_is(self):
        if pandas is None:
            self.skipTest("python3-pandas is not installed")
        rows = viscobar.sweep(thrown(), {"left.gap": [0.1, 0.2]})
        self.assertEqual(list(rows.frame()["left.gap"]), [0.1, 0.2])
        result = viscobar.run(thrown())
        self.assertEqual(list(result.frame().columns), list(result.ends))
        self.assertEqual(len(pandas.DataFrame(result.events)), len(result.events))
        self.assertEqual(list(viscobar.Table().frame().columns), [])

    def test_are_read_as_text(self):
        lines = str(viscobar.Table([{"a": 1, "b": 0.5}, {"a": 10, "b": None}])).splitlines()
        self.assertEqual(lines, [" a    b", " 1  0.5", "10"])


if __name__ == "__main__":
    main()
