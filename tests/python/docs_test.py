"""docs/python.md runs as it stands, help() is enough to work, the stubs say what is there."""
import ast
import contextlib
import inspect
import io
import os
import pathlib
import re
import tempfile

import viscobar
from support import ROOT, Test, main

os.environ.setdefault("MPLBACKEND", "Agg")


class TutorialTest(Test):
    def test_runs_as_it_stands_and_prints_what_it_says(self):
        page = (ROOT / "docs" / "python.md").read_text()
        blocks = re.findall(r"```python\n(.*?)```(?:\n\n```text\n(.*?)```)?", page, re.S)
        self.assertGreater(len(blocks), 10)
        names = {}
        with tempfile.TemporaryDirectory() as directory:
            os.symlink(ROOT / "examples", pathlib.Path(directory) / "examples")
            before = os.getcwd()
            os.chdir(directory)
            try:
                for code, expected in blocks:
                    out = io.StringIO()
                    with contextlib.redirect_stdout(out):
                        exec(compile(code, "docs/python.md", "exec"), names)
                    if expected:
                        self.assertEqual(out.getvalue(), expected, code)
            finally:
                os.chdir(before)


class HelpTest(Test):
    def test_names_every_argument_of_every_function(self):
        for name in viscobar.__all__:
            function = getattr(viscobar, name)
            self.assertTrue(inspect.getdoc(function), name)
            if not inspect.isfunction(function) or name in ("plot",):
                continue
            for argument in [*inspect.signature(function).parameters][1:]:  # the first is what the function is about
                self.assertRegex(inspect.getdoc(function), rf"\b{argument}\b", f"{name}: {argument}")

    def test_of_arrays_has_their_shapes(self):
        for words in ("K output times", "(K, J+1)", "(K, J)", "SceneError", "KeyboardInterrupt"):
            self.assertIn(words, viscobar.run.__doc__)


class StubsTest(Test):
    def test_name_what_the_extension_has(self):
        core = viscobar._core
        tree = ast.parse((ROOT / "python" / "viscobar" / "_core.pyi").read_text())
        stubs = {node.name: node for node in tree.body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
        there = {name for name in dir(core) if callable(getattr(core, name)) and not name.startswith("_")}
        self.assertEqual(set(stubs), there)
        for name, node in stubs.items():
            if isinstance(node, ast.ClassDef):
                members = {one.name for one in node.body if isinstance(one, ast.FunctionDef)} - {"__init__"}
                own = {member for member in vars(getattr(core, name)) if not member.startswith("_")}
                self.assertEqual(members, own, name)

    def test_are_marked_as_such(self):
        self.assertTrue((ROOT / "python" / "viscobar" / "py.typed").exists())
        package = pathlib.Path(viscobar.__file__).parent
        self.assertTrue((package / "py.typed").exists() and (package / "_core.pyi").exists())


if __name__ == "__main__":
    main()
