"""Scenes: dictionaries with the tables and keys of a scene file."""

from __future__ import annotations

import copy
import json
import math
import os
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Union

import numpy as np

from . import _core
from ._errors import Finding, SceneError

# Formulas that a Python function may stand for, and what stands for the function in the text that the library reads: a
# formula of the same variables.
FUNCTIONS = {
    "initial.displacement": "0.0",
    "initial.velocity": "0.0",
    "load.density": "0.0",
    "load.profile": "1.0",
    "load.history": '"t"',
    **{f"{end}.{key}": formula for end in ("left", "right")
       for key, formula in {"force": '"t"', "motion": '"t"', "gap": '"1+t"'}.items()},
}  # fmt: skip
# Those that may be given by samples, too: places or times, and values.
SAMPLED = tuple(key for key in FUNCTIONS if key != "load.density")
# Those of which values at the nodes may stand alone.
NODAL = ("initial.displacement", "initial.velocity", "load.profile")


class Scene(dict):
    """A scene: tables and keys as in a scene file (docs/scene-file.md), as nested dictionaries.

    Scene({"bar": {"length": 1.0}, ...}), Scene(bar={"length": 1.0}, ...) or both; the dictionaries are copied. The scene
    is checked unless validate=False: SceneError has all its errors, each with key and hint.

    initial.displacement, initial.velocity and load.profile may be Python functions f(x), load.history f(t), load.density
    f(x, t), instead of formulas. x, t and the value are numbers; a density that takes an array of nodes (J+1) and gives an
    array is called once a time, not once a node.

    force, motion and gap of an end may be functions f(t), too. A motion and a gap are differentiated twice.

    All of them but load.density may be samples: a pair of arrays (times or places, values), over the whole run or bar, through
    which a cubic spline is laid, twice differentiable but beside jumps and kinks of the samples, where it rises, falls and
    stays as they do. What a mask hides is left out. They are short for the table of a series, {"t": times, "values": values},
    which may as well name a file (docs/scene-file.md).

    Wherever a scene is wanted, a plain dictionary, the path of a scene file or its text may be given as well.
    """

    def __init__(self, scene: Mapping[str, Any] | None = None, /, *, validate: bool = True, **tables: Any):
        super().__init__()
        for source in (scene or {}, tables):
            for name, table in source.items():
                if isinstance(table, Mapping) and isinstance(self.get(name), dict):
                    self[name].update(table)
                else:
                    self[name] = _copied(table)
        if validate:
            parse(self)

    def changed(self, values: Mapping[str, Any] | None = None, /) -> Scene:
        """A copy with other values, as --set has them: scene.changed({"contact.restitution": 0}). Not checked.

        "bar.2.modulus" and "joint.1.gap" are keys of bars in line. A table, {"bar": {"modulus": 4.0}}, changes the keys that
        it has. None removes a key, or a table. An end that becomes of another kind loses the keys of the old one.
        """
        scene = Scene(self, validate=False)
        settings = dict(_settings(values or {}))
        for key, value in settings.items():
            scene._set(key, value)
        for end in ("left", "right"):
            kind = settings.get(f"{end}.kind")
            if isinstance(kind, str) and kind in _core.end_kinds:
                for leaf, value in list(scene[end].items()):
                    name = f"{leaf}." if isinstance(value, Mapping) and leaf == "contact" else leaf
                    known = any(_core.belongs_to_end(one, name) for one in _core.end_kinds)
                    given = any(f"{key}.".startswith(f"{end}.{leaf}.") for key in settings)
                    if known and not given and not _core.belongs_to_end(kind, name):
                        del scene[end][leaf]
        return scene

    def _set(self, key: str, value: Any) -> None:
        """One value. What has no place in the scene stays beside it under its own name, for the library to judge."""
        name, *rest = key.split(".")
        if not rest:
            _put(self, name, _copied(value))
            return
        if _is_member(key):
            table, rest = self._member(name, int(rest[0])), rest[1:]
        else:
            if isinstance(self.get(name), list) and value is not None and len(self[name]) > 1:
                self.update({f"{name}.{k}": one for k, one in enumerate(self.pop(name), 1)})
            table = self.setdefault(name, {})
            if isinstance(table, list) and len(table) == 1:
                (table,) = table
            if name in ("left", "right") and len(rest) > 1 and isinstance(table.get(rest[0], {}), dict):
                table[rest[0]] = table = dict(table.get(rest[0], {}))  # left.contact.law: a table of the end
                rest = rest[1:]
        if isinstance(table, list):
            return  # nothing to take away from bars in line
        if not isinstance(table, dict) or not rest:
            raise SceneError([Finding(key, f"is {table!r}, not a table" if rest else "is a table; its keys are set one by one")])
        _put(table, ".".join(rest), value)
        # A table without keys is none.
        if name in ("left", "right") and self[name].get("contact") == {}:
            del self[name]["contact"]
        if not self.get(name, True):
            del self[name]

    def _member(self, name: str, k: int) -> Any:
        """The table of bar k, or joint k, of several."""
        tables = self.get(name, [] if name == "joint" else None)
        alone = f"{name}.{k}"
        if alone in self or not isinstance(tables, list) or (name == "bar" and len(tables) < 2):
            return self.setdefault(alone, {})
        if name == "joint" and k == len(tables) + 1:
            self[name] = [*tables, {}]
        elif not 1 <= k <= len(tables):
            return self.setdefault(alone, {})
        return self[name][k - 1]

    def __deepcopy__(self, memo: dict[int, Any]) -> Scene:
        return Scene({name: copy.deepcopy(value, memo) for name, value in self.items()}, validate=False)

    def toml(self) -> str:
        """The scene as the text of a scene file. Scenes with Python functions have none."""
        text, functions = to_toml(self)
        if functions:
            raise ValueError(f"{', '.join(functions)}: a Python function has no place in a scene file; give a formula or samples")
        return text

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the scene as a file for the program."""
        text = self.toml()
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)

    def __repr__(self) -> str:
        return f"Scene({dict(self)!r})"


def _put(table: dict[str, Any], key: str, value: Any) -> None:
    if value is None:
        table.pop(key, None)
    else:
        table[key] = value


def _copied(value: Any) -> Any:
    """A table, or the tables of several bars, copied."""
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, (list, tuple)) and any(isinstance(one, Mapping) for one in value):
        return [dict(one) if isinstance(one, Mapping) else one for one in value]
    return value


def _is_member(key: str) -> bool:
    """Whether it is of one of several bars or joints: bar.2, bar.2.modulus, joint.1.gap."""
    return re.match(r"(bar|joint)\.[1-9][0-9]*(\.|$)", key) is not None


def _settings(values: Mapping[str, Any], table: str = "") -> Iterator[tuple[str, Any]]:
    """Keys and values, those of tables one by one."""
    for leaf, value in values.items():
        key = f"{table}.{leaf}" if table else str(leaf)
        is_table = not table and "." not in key or re.fullmatch(r"(left|right)\.contact|(bar|joint)\.[1-9][0-9]*", key)
        if isinstance(value, Mapping) and is_table:
            yield from _settings(value, key)
        else:
            yield key, value


SceneLike = Union[Scene, Mapping[str, Any], str, "os.PathLike[str]"]


def load(path: str | os.PathLike[str], *, validate: bool = True) -> Scene:
    """The scene of a file (TOML, docs/scene-file.md) as a Scene: tables and keys as they stand there.

    Errors of the file are raised as SceneError, with line, column, key and hint. validate=False leaves a scene that lacks
    something to be completed. A string of several lines is the text of a scene itself.
    """
    source = os.fspath(path)
    if "\n" in source:
        text, source = source, ""
    else:
        text = _core.text_of(source)
    if validate:
        _core.parse(text, source, {})
    try:
        scene = Scene(tomllib.loads(text), validate=False)
        # Files of measured series lie beside the scene, and not where it is changed.
        for table in (one for tables in scene.values() for one in (tables if isinstance(tables, list) else [tables])):
            for key, value in table.items() if isinstance(table, dict) else ():
                if isinstance(value, dict) and isinstance(value.get("file"), str):
                    table[key] = {**value, "file": os.path.abspath(os.path.join(os.path.dirname(source), value["file"]))}
        return scene
    except tomllib.TOMLDecodeError as error:
        raise SceneError([Finding("", str(error), source=source, line=1, column=1)]) from None


def as_scene(scene: SceneLike, method: str | None = None, set: Mapping[str, Any] | None = None) -> Scene:
    """A copy of what stands for a scene, changed."""
    if isinstance(scene, (str, os.PathLike)):
        scene = load(scene, validate=False)
    elif not isinstance(scene, Mapping):
        raise TypeError(f"a scene is a dictionary, a viscobar.Scene, or the path or text of a scene file, not {type(scene).__name__}")
    changes = dict(set or {})
    if method is not None:
        changes["method.name"] = method
    return Scene.changed(scene if isinstance(scene, Scene) else Scene(scene, validate=False), changes)


def parse(scene: Scene, study: str = "run") -> _core.Case:
    """The scene as the library understands it. Raises SceneError."""
    text, functions = to_toml(scene)
    return _core.parse(text, "", functions, study)


def takes_arrays(function: Callable[..., Any], x: np.ndarray) -> bool:
    """Whether f(x, 0) takes an array of nodes and gives what it gives for each, up to roundings."""
    try:
        values = np.asarray(function(x, 0.0), dtype=float)
        if values.shape not in ((), x.shape):
            return False
        values = np.broadcast_to(values, x.shape)
        some = [0, len(x) // 2, len(x) - 1]
        alone = [float(function(float(x[j]), 0.0)) for j in some]
        return bool(np.allclose(values[some], alone, rtol=1e-12, atol=0.0, equal_nan=True))
    except Exception:  # whatever it is that an array does to it; its own faults come to light node by node
        return False


def function_name(function: Any) -> str:
    if is_sampled(function):
        return f"{len(function[0])} samples"
    if is_row(function):
        return f"{len(function)} values at the nodes"
    return f"function {getattr(function, '__qualname__', type(function).__name__)}"


def is_sampled(value: Any) -> bool:
    """Whether that is a pair of arrays."""

    def is_array(part: Any) -> bool:
        try:
            return np.ndim(part) >= 1
        except ValueError:  # a list of lists of several lengths
            return True

    return isinstance(value, (tuple, list, np.ndarray)) and len(value) == 2 and all(map(is_array, value))


def is_row(value: Any) -> bool:
    """Whether that is one array."""
    return isinstance(value, (tuple, list, np.ndarray)) and not is_sampled(value)


def _may_be_sampled(name: str) -> bool:
    return name in SAMPLED or re.fullmatch(r"bar\.[1-9][0-9]*\.(displacement|velocity)", name) is not None


def samples(name: str, places: Any, values: Any) -> dict[str, np.ndarray]:
    """The table of a series of places, or times, and values."""
    if not _may_be_sampled(name):
        raise SceneError([Finding(name, "is given by samples", "only " + ", ".join(SAMPLED) + " may be")])
    try:
        parts = [np.ma.asarray(part) for part in (places, values)]
        if any(map(np.iscomplexobj, parts)):
            raise TypeError("complex numbers")
        parts = [part.astype(float) for part in parts]
    except (TypeError, ValueError) as error:
        raise SceneError([Finding(name, f"has samples that are no numbers: {error}")]) from None
    if any(part.ndim != 1 for part in parts):
        raise SceneError([Finding(name, f"has samples of the shape {parts[1].shape}", "a row of numbers is meant")])
    # What a mask hides was not measured, at the time of it, too.
    hidden = [np.ma.getmaskarray(part) for part in parts]
    if hidden[0].shape == hidden[1].shape:
        parts = [np.ma.getdata(part)[~(hidden[0] | hidden[1])] for part in parts]
    return {_place_of(name): parts[0], "values": parts[1]}


def _once(nodes: np.ndarray, values: Any) -> tuple[Any, Any]:
    """Places and values without those that the next node of a joint has as well."""
    values = np.ma.asarray(values)
    if values.ndim != 1 or np.all(np.diff(nodes)):
        return nodes, values
    once = np.r_[True, (np.diff(nodes) != 0) | (values[1:] != values[:-1]).filled(True)]
    return nodes[once], values[once]


def _place_of(name: str) -> str:
    return "x" if name.startswith(("initial.", "bar.")) or name == "load.profile" else "t"


def to_toml(scene: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    """The text of a scene, and its Python functions by their keys."""
    text, functions, nodal = _text_and_functions(scene, None)
    if nodal:  # the mesh is that of the scene without them
        case = _core.parse(text, "", functions)
        text, functions, _ = _text_and_functions(_by_members(scene, case), case.x)
    return text, functions


def _by_members(scene: Mapping[str, Any], case: _core.Case) -> Mapping[str, Any]:
    """The scene with its initial values at nodes given to each bar in line by itself: nodes of a joint share a place."""
    if len(case.members) < 2 or "initial" not in scene:
        return scene
    bars, initial = [dict(bar) for bar in scene["bar"]], dict(scene["initial"])
    for leaf, row in scene["initial"].items():
        if not is_row(row) or len(row) != len(case.x):
            continue
        del initial[leaf]
        for bar, (first, last) in zip(bars, case.members):
            own = {"x": case.x[first : last + 1] - case.x[first], "values": row[first : last + 1], "outside": "hold"}
            if bar.get(leaf) is None:
                bar[leaf] = row[first] if first == last else own
    return {**scene, "bar": bars, "initial": initial}


def _text_and_functions(scene: Mapping[str, Any], nodes: np.ndarray | None) -> tuple[str, dict[str, Any], bool]:
    """The same, and whether it has values at nodes; without the places of these a formula stands for them."""
    functions: dict[str, Any] = {}
    nodal = False

    def line(key: str, value: Any, table: str = "") -> str:
        nonlocal nodal
        name = f"{table}.{key}" if table else key
        if is_row(value) and name in NODAL:
            nodal = True
            if nodes is None:
                return f"{_key(key)} = {FUNCTIONS[name]}\n"
            if len(value) != len(nodes):
                raise SceneError([Finding(name, f"has {len(value)} values for the {len(nodes)} nodes of the mesh",
                                          "places of its own are given as a pair of arrays, (places, values)")])  # fmt: skip
            value = _once(nodes, value)
        if is_sampled(value) and (_may_be_sampled(name) or not all(isinstance(part, str) for part in value)):
            return f"{_key(key)} = {_value(name, samples(name, *value))}\n"
        if isinstance(value, Mapping) and _may_be_sampled(name) and {_place_of(name), "values"} <= value.keys():
            value = {**value, **samples(name, value[_place_of(name)], value["values"])}
        if callable(value):
            if name not in FUNCTIONS:
                raise SceneError([Finding(name, "is a Python function", "only " + ", ".join(FUNCTIONS) + " may be one")])
            functions[name] = value
            return f"{_key(key)} = {FUNCTIONS[name]}\n"
        return f"{_key(key)} = {_value(name, value)}\n"

    def lines(table: Mapping[str, Any], name: str) -> str:
        return "".join(line(key, value, name) for key, value in table.items() if value is not None)

    top, tables = "", ""
    for name, table in scene.items():
        if isinstance(table, Mapping):
            tables += f"[{_key(name)}]\n{lines(table, name)}"
        elif isinstance(table, (list, tuple)) and table and all(isinstance(one, Mapping) for one in table):
            tables += "".join(f"[[{_key(name)}]]\n{lines(one, f'{name}.{k}')}" for k, one in enumerate(table, 1))
        elif table is not None:
            top += line(name, table)
    bars = scene.get("bar")
    for leaf in ("displacement", "velocity"):
        if f"initial.{leaf}" in functions and isinstance(bars, (list, tuple)):
            own = functions[f"initial.{leaf}"]
            functions |= {f"bar.{k}.{leaf}": own for k, bar in enumerate(bars, 1)
                          if isinstance(bar, Mapping) and bar.get(leaf) is None}
    return top + tables, functions, nodal


def _key(name: Any) -> str:
    if not isinstance(name, str):
        raise SceneError([Finding(str(name), f"is a key of type {type(name).__name__}, not a string")])
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _text(name)


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")


def _value(name: str, value: Any) -> str:
    if isinstance(value, (np.generic, np.ndarray)) and np.ndim(value) < 2:
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else str(value)
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(_value(name, entry) for entry in value)}]"
    if isinstance(value, Mapping):
        if isinstance(value.get("file"), (str, os.PathLike)):  # wherever the scene is saved
            value = {**value, "file": os.path.abspath(value["file"])}
        return f"{{ {', '.join(f'{_key(key)} = {_value(name, entry)}' for key, entry in value.items())} }}"
    raise SceneError([Finding(name, f"is of type {type(value).__name__}", "a number or a text is meant")])
