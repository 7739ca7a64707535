"""The compiled module is that of the processor's level, or there is a word on it."""
import os
import pathlib
import subprocess
import sys
import tempfile
from unittest import mock

import viscobar
from support import Test, main
from viscobar import _level


class LevelTest(Test):
    def test_is_the_highest_that_the_processor_has(self):
        with tempfile.TemporaryDirectory() as package, mock.patch.dict(os.environ):
            os.environ.pop("VISCOBAR_LEVEL", None)
            self.assertRaises(ImportError, _level.folder, package)
            for name in ("x86-64", "x86-64-v2", "x86-64-v4"):
                (pathlib.Path(package) / name).mkdir()
            os.environ["VISCOBAR_LEVEL"] = "x86-64-v3"
            self.assertEqual(pathlib.Path(_level.folder(package)).name, "x86-64-v2" if _level._usable() else "x86-64")
            os.environ["VISCOBAR_LEVEL"] = "x86-64"
            self.assertEqual(pathlib.Path(_level.folder(package)).name, "x86-64")

    def test_a_processor_below_the_module_is_told_in_words(self):
        built = pathlib.Path(viscobar._core.__file__).parent.name
        if built in ("native", "x86-64"):
            self.skipTest(f"built for {built}")
        said = subprocess.run([sys.executable, "-c", "import viscobar"], env={**os.environ, "VISCOBAR_LEVEL": "x86-64"},
                              capture_output=True, text=True)
        self.assertEqual(said.returncode, 1)
        self.assertIn(f"ImportError: viscobar was built for processors of the level {built}, which this one has not", said.stderr)


if __name__ == "__main__":
    main()
