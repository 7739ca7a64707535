"""The package by CMake: its library is the one of the program, from the folder above, or that a source distribution holds."""
import os
import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.sdist import sdist

HERE = pathlib.Path(__file__).resolve().parent
SOURCE = HERE / "source" if (HERE / "source").exists() else HERE.parent  # "source" in a source distribution
NEEDED = ("CMakeLists.txt", "LICENSE", "cmake", "include", "src", "python", "examples/scenes", "examples/data")


class ByCMake(build_ext):
    def build_extension(self, extension):
        package = pathlib.Path(self.get_ext_fullpath(extension.name)).resolve().parent
        build = SOURCE / "build" / "pip"  # as deep as other builds of the tree: a cache of compiled files knows them
        ninja = ["-G", "Ninja"] if any(os.access(pathlib.Path(place, "ninja"), os.X_OK) for place in os.get_exec_path()) else []
        subprocess.run(
            ["cmake", "-S", SOURCE, "-B", build, *ninja, "-DCMAKE_BUILD_TYPE=Release", "-DVISCOBAR_TESTS=OFF",
             f"-DVISCOBAR_PYTHON_EXECUTABLE={sys.executable}", f"-DVISCOBAR_PYTHON_DIR={package.parent}"], check=True)  # fmt: skip
        jobs = os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count()))
        subprocess.run(["cmake", "--build", build, "--target", "viscobar_python", "--parallel", jobs], check=True)


class WithSource(sdist):
    def make_release_tree(self, base_dir, files):
        super().make_release_tree(base_dir, files)
        leave_out = shutil.ignore_patterns("build", "dist", "source", "*.egg-info", "__pycache__", ".venv")
        for name in NEEDED:
            place = pathlib.Path(base_dir, "source", name)
            place.parent.mkdir(parents=True, exist_ok=True)
            if (SOURCE / name).is_dir():
                shutil.copytree(SOURCE / name, place, ignore=leave_out)
            else:
                shutil.copy2(SOURCE / name, place)


version = re.search(r"project\(viscobar VERSION ([\d.]+)", (SOURCE / "CMakeLists.txt").read_text()).group(1)
setup(version=version, ext_modules=[Extension("viscobar._core", [])], cmdclass={"build_ext": ByCMake, "sdist": WithSource})
