"""Results on the disk and in pickles: the files of a directory that `viscobar run` writes."""

from __future__ import annotations

import json
import os
import pathlib
import tempfile
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from . import _core


class Directory(Mapping[str, bytes]):
    """The files of a directory, and of its folders, by their names, read when they are asked for."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = pathlib.Path(path).absolute()

    def __getitem__(self, name: str) -> bytes:
        try:
            return (self.path / name).read_bytes()
        except FileNotFoundError:
            raise KeyError(name) from None

    def __contains__(self, name: object) -> bool:
        return (self.path / str(name)).is_file()

    def __iter__(self) -> Iterator[str]:
        return (one.relative_to(self.path).as_posix() for one in sorted(self.path.rglob("*")) if one.is_file())

    def __len__(self) -> int:
        return sum(1 for _ in self)


class Stored:
    """A finished run as its files tell it; what _core.Run tells of one in memory."""

    def __init__(self, files: Mapping[str, bytes]) -> None:
        self.files = files
        self.told: dict[str, Any] = json.loads(files["summary.json"])

    label = property(lambda self: self.told["method"])
    method = property(lambda self: self.told["method"])
    warnings = property(lambda self: list(self.told["warnings"]))
    ending = property(lambda self: self.told["ending"])
    error = property(lambda self: self.told["error"])
    reached_time = property(lambda self: self.told["reached_time"])
    x = property(lambda self: self._field["x"])
    u = property(lambda self: self._field["u"])
    v = property(lambda self: self._field["v"])
    stress = property(lambda self: self._field["stress"])

    @property
    def t(self) -> np.ndarray:
        return self._field["t"] if "field.h5" in self.files else self.columns("ends")["t"]

    @cached_property
    def _field(self) -> dict[str, np.ndarray]:
        names = ["t", "x", "u", "v", "stress"]
        names += [f"sensitivity/{key}/{name}" for key in self.told.get("sensitivity") or () for name in SENSITIVITIES]
        if "field.h5" not in self.files:
            raise ValueError("this result has no field.h5: output.write of its scene left it out")
        if isinstance(self.files, Directory):
            return self._datasets(str(self.files.path / "field.h5"), names)
        with tempfile.TemporaryDirectory() as directory:
            file = pathlib.Path(directory) / "field.h5"
            file.write_bytes(self.files["field.h5"])
            return self._datasets(str(file), names)

    @staticmethod
    def _datasets(file: str, names: list[str]) -> dict[str, np.ndarray]:
        return {name: _core.dataset(file, name) for name in names}

    def columns(self, table: str) -> dict[str, np.ndarray]:
        """The columns of a table, NaN where a cell is empty; none where the result does not have it."""
        if f"{table}.csv" not in self.files:
            return {}
        head, *rows = [line.split(",") for line in self.files[f"{table}.csv"].decode().splitlines()]
        columns: dict[str, np.ndarray] = {}
        for k, name in enumerate(head):
            cells = [row[k] for row in rows]
            columns[name] = np.array(cells if name in ("where", "change") else [float(cell or "nan") for cell in cells])
        return columns

    def event_columns(self) -> tuple[Any, ...]:
        columns = self.columns("events")
        return tuple(columns.get(name, np.empty(0)).tolist() for name in ("t", "where", "change", "velocity"))

    def energies(self) -> list[np.ndarray]:
        columns = self.columns("energy")
        return [columns[name] for name in columns if name != "t"]

    def _without_times(self, table: str) -> dict[str, np.ndarray]:
        return {name: values for name, values in self.columns(table).items() if name != "t"}

    def gauges(self) -> dict[str, np.ndarray]:
        return self._without_times("gauges")

    def joints(self) -> dict[str, np.ndarray]:
        return self._without_times("joints")

    @property
    def sensitivity(self) -> dict[str, dict[str, np.ndarray]]:
        keys = self.told.get("sensitivity") or ()
        return {key: {name: self._field[f"sensitivity/{key}/{name}"] for name in SENSITIVITIES} for key in keys}

    def summary(self) -> str:
        return self.files["summary.json"].decode()

    def page(self) -> str:
        if "report.html" not in self.files:
            raise ValueError("this result has no report.html: output.write of its scene left it out")
        return self.files["report.html"].decode()

    def save(self, directory: str, _: str) -> None:
        for name, content in self.files.items():
            file = pathlib.Path(directory) / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(content)


SENSITIVITIES = ("u", "v", "reaction_left", "reaction_right")


class Arrays:
    """Traces and field of a run that is none of the library any more: what _core.Kept tells, in a pickle."""

    def __init__(self, core: Any) -> None:
        self.label = core.label
        self.t, self.x, self.u, self.v = core.t, core.x, core.u, core.v
        self.reaction_left, self.reaction_right = core.reaction_left, core.reaction_right
        self._events = core.event_columns()

    def event_columns(self) -> tuple[Any, ...]:
        return self._events
