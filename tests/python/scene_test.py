"""Scenes as dictionaries: the keys, the values and the errors of scene files."""
import copy
import json
import pathlib
import pickle
import tempfile
import tomllib

import numpy as np

import viscobar
from support import SCENES, Test, main, program, thrown


class SceneTest(Test):
    def test_of_a_file_is_what_the_file_says(self):
        for path in sorted(SCENES.glob("*.toml")):
            said = tomllib.loads(path.read_text())
            for table in (said.get("left", {}), said.get("right", {})):
                if isinstance(table.get("force"), dict):  # a file is named from where the scene lies
                    table["force"]["file"] = str((path.parent / table["force"]["file"]).resolve())
            self.assertEqual(viscobar.load(path), said, path)

    def test_of_several_lines_is_the_text_of_a_scene(self):
        text = "[bar]\nlength = 2.0\n[initial]\nvelocity = 1.0\n[time]\nend = 1.0\n"
        self.assertEqual(viscobar.load(text)["bar"]["length"], 2.0)
        self.assertEqual(viscobar.run(text).summary["scene"]["bar"]["length"], 2.0)
        with self.assertRaisesRegex(viscobar.SceneError, "bar.length: must be positive"):
            viscobar.load(text.replace("2.0", "-2.0"))

    def test_comes_back_from_its_own_text(self):
        scene = viscobar.Scene(thrown(), title='a "quoted" \\ title\x7f\n with é and 😀')
        self.assertEqual(tomllib.loads(scene.toml()), scene)
        with tempfile.TemporaryDirectory() as directory:
            path = pathlib.Path(directory) / "scene.toml"
            scene.save(path)
            self.assertEqual(viscobar.load(path), scene)
            self.assertIn("sound", program("check", path))

    def test_has_tables_as_arguments_and_takes_numbers_of_numpy(self):
        tables = thrown()
        scene = viscobar.Scene(tables, bar={"viscosity": np.float64(0.2)}, mesh={"elements": np.int64(30)})
        self.assertEqual(scene["bar"], {"length": 1.0, "viscosity": 0.2})
        self.assertEqual(tables["bar"]["viscosity"], 0.1)
        self.assertEqual(viscobar.check(scene)["nodes"], 31)

    def test_changed_is_a_copy(self):
        scene = viscobar.Scene(thrown())
        other = scene.changed({"contact.restitution": 0, "contact.epsilon": None, "title": "other"})
        self.assertEqual(other["contact"], {"restitution": 0})
        self.assertEqual((other["title"], "title" in scene), ("other", False))
        self.assertEqual(scene, thrown())
        for clone in (copy.deepcopy(scene), copy.copy(scene), pickle.loads(pickle.dumps(scene))):
            self.assertEqual(clone, scene)

    def test_errors_come_all_at_once_each_with_key_and_hint(self):
        wrong = thrown(bar__viscosty=0.1, left__gap=-1.0, mesh__elements="many", initial__velocity="sinn(x)")
        for attempt in (viscobar.Scene, viscobar.run, viscobar.check, viscobar.compare, viscobar.limit):
            with self.assertRaises(viscobar.SceneError) as raised:
                attempt(wrong)
            findings = {one.key: one for one in raised.exception.findings}
            self.assertEqual(set(findings), {"bar.viscosty", "left.gap", "mesh.elements", "initial.velocity"})
            self.assertEqual(findings["bar.viscosty"].hint, 'nearest is "viscosity"')
            self.assertIn("must not be negative", findings["left.gap"].problem)
            self.assertIn('bar.viscosty: unknown key; nearest is "viscosity"', str(raised.exception))
        self.assertEqual(raised.exception.key, raised.exception.findings[0].key)

    def test_errors_of_a_file_are_those_of_the_program(self):
        with tempfile.TemporaryDirectory() as directory:
            path = pathlib.Path(directory) / "wrong.toml"
            path.write_text((SCENES / "chatter.toml").read_text().replace("viscosity", "viscosty"))
            with self.assertRaises(viscobar.SceneError) as raised:
                viscobar.load(path)
            self.assertEqual((raised.exception.findings[0].line, raised.exception.findings[0].column), (9, 1))
            import subprocess

            from support import PROGRAM

            said = subprocess.run([PROGRAM, "check", path], capture_output=True, text=True).stderr
            self.assertIn(str(raised.exception), said)
            self.assertEqual(viscobar.load(path, validate=False)["bar"]["viscosty"], 0.01)
        with self.assertRaises(viscobar.SceneError) as raised:
            viscobar.load("no such file.toml")
        self.assertEqual(str(raised.exception), "no such file.toml: does not exist")

    def test_errors_of_python_name_the_key(self):
        for changes, key in (({"left__gap": None}, "left.gap"), ({"bar__length": [1.0]}, "bar.length"),
                             ({"bar__length": lambda: 1.0}, "bar.length"), ({"bar__length": float("nan")}, "bar.length"),
                             ({"bar__length": 10**30}, ""), ({"mesh__elements": True}, "mesh.elements")):  # fmt: skip
            with self.subTest(changes), self.assertRaises(viscobar.SceneError) as raised:
                viscobar.run(thrown(**changes))
            self.assertEqual(raised.exception.key, key)
        with self.assertRaises(TypeError):
            viscobar.run(42)
        with self.assertRaises(viscobar.SceneError) as raised:
            viscobar.run(thrown(), "cvod")
        self.assertEqual(raised.exception.key, "method.name")
        with self.assertRaisesRegex(ValueError, "initial.velocity"):
            viscobar.Scene(thrown(initial__velocity=lambda x: -1.0)).toml()

    def test_error_can_be_pickled(self):
        with self.assertRaises(viscobar.SceneError) as raised:
            viscobar.run(thrown(left__gap=-1.0))
        self.assertEqual(pickle.loads(pickle.dumps(raised.exception)).findings, raised.exception.findings)


if __name__ == "__main__":
    main()
