"""Runs and their results."""

from __future__ import annotations

import copy
import html
import json
import os
import tempfile
import warnings
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from . import _core
from ._errors import Finding, IntegrationError, RunWarning, SceneError
from ._scene import FUNCTIONS, Scene, SceneLike, as_scene, function_name, is_row, is_sampled, parse
from ._store import Arrays, Directory, Stored


def fixed(array: np.ndarray) -> np.ndarray:
    """An array that nobody may write to: others are views of it, and the summary tells of it."""
    array.setflags(write=False)
    return array


def _all_fixed(columns: Mapping[str, Any]) -> dict[str, Any]:
    return {name: fixed(values) for name, values in columns.items()}


class Recorded:
    """Traces and field of a run: K output times, J elements, J+1 nodes. Units are those of the scene.

    The arrays are views of the memory that the library has filled; nothing is copied, and nothing can be written to them
    (array.copy() can).

    label  name of the method or scheme
    t      (K)       output times
    x      (J+1)     nodes
    u, v   (K, J+1)  displacement and velocity; v is None where a scheme does not know it
    """

    def __init__(self, core: _core.Kept):
        self._core = core

    @property
    def label(self) -> str:
        return self._core.label

    @cached_property
    def t(self) -> np.ndarray:
        return fixed(self._core.t)

    @cached_property
    def x(self) -> np.ndarray:
        return fixed(self._core.x)

    @cached_property
    def u(self) -> np.ndarray:
        return fixed(self._core.u)

    @cached_property
    def v(self) -> np.ndarray | None:
        v = self._core.v
        return v if v is None else fixed(v)

    def at(self, t: Any, x: Any = None) -> tuple[np.ndarray, np.ndarray]:
        """u and v at any times t, an array or a number, at the nodes, or at the places x: of the shape t.shape + x.shape.

        Between output times u is the cubic through u and v at both, and v its derivative: u is wrong by at most
        max|u_tttt| every^4 / 384, where no contact changes within the interval. Between nodes both are linear, and at a
        joint those of the bar on its left. Exact values at times of your own: viscobar.run(..., times=...).
        """
        t = np.asarray(t, dtype=float)
        places = self.x if x is None else np.asarray(x, dtype=float)
        for name, values, known in (("t", t, self.t), ("x", places, self.x)):
            if not np.all((values >= known[0]) & (values <= known[-1])):
                raise ValueError(f"at: {name} lies in [{known[0]:g}, {known[-1]:g}]")
        if self.v is None:
            raise ValueError(f"at: {self.label} has no velocities")
        if len(self.t) < 2:
            raise ValueError("at: there is one output time")
        k = np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, len(self.t) - 2)
        h = (self.t[k + 1] - self.t[k])[..., None]
        s = (t - self.t[k])[..., None] / h
        u0, u1, v0, v1 = self.u[k], self.u[k + 1], self.v[k], self.v[k + 1]
        u = u0 + s * s * (3 - 2 * s) * (u1 - u0) + h * s * (1 - s) * ((1 - s) * v0 - s * v1)
        v = 6 * s * (1 - s) * (u1 - u0) / h + (1 - s) * (1 - 3 * s) * v0 + s * (3 * s - 2) * v1
        if x is None:
            return u, v
        elements = np.flatnonzero(np.diff(self.x) > 0)  # without joints, where nodes share a place
        j = elements[np.clip(np.searchsorted(self.x[elements + 1], places), 0, len(elements) - 1)]
        share = (places - self.x[j]) / (self.x[j + 1] - self.x[j])
        return tuple(part[..., j] * (1 - share) + part[..., j + 1] * share for part in (u, v))  # type: ignore[return-value]

    def __reduce__(self) -> Any:
        return Recorded, (Arrays(self._core),)

    def __copy__(self) -> Recorded:
        return Recorded(self._core)  # whose arrays do not change

    def __deepcopy__(self, memo: dict[int, Any]) -> Recorded:
        return Recorded(self._core)

    @cached_property
    def ends(self) -> dict[str, np.ndarray]:
        """Columns of ends.csv, (K) each: t, u_left, v_left, reaction_left, u_right, v_right, reaction_right.

        Reactions are forces on the bar (per cross-section) in the direction of u: not negative at an obstacle below, not
        positive at one above.
        """
        columns = {"t": self.t}
        for side, node in (("left", 0), ("right", -1)):
            columns[f"u_{side}"] = self.u[:, node]
            if self.v is not None:
                columns[f"v_{side}"] = self.v[:, node]
            reaction = getattr(self._core, f"reaction_{side}")
            if reaction is not None:
                columns[f"reaction_{side}"] = fixed(reaction)
        return columns

    @cached_property
    def events(self) -> np.ndarray:
        """Contact changes, a structured array with the columns of events.csv: t, where, change, velocity.

        where is left, right or span:<node>; change is closing or opening; velocity is that of the node. events["t"] is
        the array of the times, events[0]["where"] the place of the first change.
        """
        columns = self._core.event_columns()
        width = max([5, *map(len, columns[1])])
        kind = [("t", "f8"), ("where", f"U{width}"), ("change", "U7"), ("velocity", "f8")]
        return fixed(np.array(list(zip(*columns)), dtype=kind))


class Result(Recorded):
    """What viscobar.run() and viscobar.open() return; see Recorded for label, t, x, u, v, ends, events and at().

    stress    (K, J)  E u_x + eta u_xt, the mean of each element
    joints    mapping of (K) arrays, as joints.csv of bars in line: t and, for each joint that is not bonded, u_left:1,
              u_right:1, force:1
    gauges    mapping of (K) arrays, as gauges.csv: t and, for each place of output.gauges, "u@0.25", v, strain, stress
    energy    mapping of (K) arrays, as energy.csv: t, kinetic, elastic, contact, dissipated, work, total
    summary   as summary.json: method, counts, energy, contact, scene as understood, ...
    warnings  what the run has to say about itself, in sentences
    method    name of the method that ran
    completed whether it reached the end; reached_time says how far it came otherwise

    It can be saved, pickled and copied.
    """

    _core: _core.Run | Stored

    def __init__(self, core: _core.Run | Stored, scene: Scene):
        super().__init__(core)
        self.scene = scene

    method = property(lambda self: self._core.method, doc="Name of the method that ran.")
    warnings = property(lambda self: self._core.warnings, doc="Sentences, such as on chatter.")
    completed = property(lambda self: self._core.ending == "completed", doc="Whether the run reached its end.")
    reached_time = property(lambda self: self._core.reached_time, doc="How far the run came.")

    @cached_property
    def ends(self) -> dict[str, np.ndarray]:
        """As Recorded.ends."""
        return _all_fixed(self._core.columns("ends")) if isinstance(self._core, Stored) else super().ends

    @cached_property
    def sensitivity(self) -> dict[str, dict[str, Any]]:
        """Derivatives by the keys of [sensitivity], NaN or None where there are none (docs/sensitivity.md): for each key
        u and v (K, J+1), ends (as ends, without t), contact_times and contact_velocities (one for each of events),
        impulse_left, impulse_right, energy_final, and until."""
        keys = {}
        for key, told in self._core.sensitivity.items():
            told, ends = _all_fixed(told), {}
            for side, node in (("left", 0), ("right", -1)):
                ends[f"u_{side}"] = told["u"][:, node]
                ends[f"v_{side}"] = told["v"][:, node]
                ends[f"reaction_{side}"] = told[f"reaction_{side}"]
            account = dict(self.summary["sensitivity"][key])
            for name in ("contact_times", "contact_velocities"):
                account[name] = fixed(np.array(account[name], dtype=float))
            keys[key] = {"u": told["u"], "v": told["v"], "ends": ends, **account}
        return keys

    @cached_property
    def stress(self) -> np.ndarray:
        """E u_x + eta u_xt, the mean of each element, (K, J)."""
        return fixed(self._core.stress)

    @cached_property
    def gauges(self) -> dict[str, np.ndarray]:
        """The columns of gauges.csv, (K) each: t and, for each place x of output.gauges, "u@x", "v@x", "strain@x", "stress@x"."""
        return {"t": self.t, **_all_fixed(self._core.gauges())}

    @cached_property
    def joints(self) -> dict[str, np.ndarray]:
        """The columns of joints.csv, (K) each: t and, for each joint of bars in line that is not bonded, by its number from the
        left, u on both sides, u_left:1 and u_right:1, and the force that pushes them apart, force:1. Else t alone."""
        return {"t": self.t, **_all_fixed(self._core.joints())}

    @cached_property
    def energy(self) -> dict[str, np.ndarray]:
        """The columns of energy.csv, (K) each: t, kinetic, elastic, contact (in their springs), dissipated, work, total.

        total + dissipated - work keeps its value, up to the error of the time integration.
        """
        names = ("kinetic", "elastic", "contact", "dissipated", "work", "total")
        return {"t": self.t, **_all_fixed(dict(zip(names, self._core.energies())))}

    @cached_property
    def summary(self) -> dict[str, Any]:
        """summary.json of the run, as a dictionary; without the checksums of files, which there are none of."""
        summary = json.loads(self._core.summary())
        for of_files in ("files", "crc64"):
            summary.pop(of_files, None)
        for key in FUNCTIONS:
            table, leaf = key.split(".")
            function = self.scene.get(table, {}).get(leaf)
            if callable(function) or is_sampled(function) or (is_row(function) and key != "load.density"):
                summary["scene"][table][leaf] = function_name(function)
        return summary

    @property
    def error_estimate(self) -> dict[str, Any] | None:
        """How far the result is from the bar itself, as in summary.json; None where no error was asked for."""
        return self.summary["error_estimate"]

    def page(self) -> str:
        """report.html of the run: a self-contained page with the pictures."""
        return self._core.page()

    def frame(self) -> Any:
        """The columns of ends.csv as a pandas DataFrame. Needs pandas."""
        import pandas

        return pandas.DataFrame(self.ends)

    def plot(self, kind: str | None = None, *, ax: Any = None) -> Any:
        """A matplotlib figure: displacement over space and time, end traces, reactions and forces of joints,
        energies; or one of them.

        kind  "displacement", "ends", "reactions" or "energy" alone
        ax    axes of matplotlib to draw on; of the ends where no kind is given
        """
        from . import _plots

        return _plots.plot_run(self, kind, ax)

    def save(self, directory: str | os.PathLike[str]) -> None:
        """Writes the files of `viscobar run` into a directory, which is new or empty: viscobar.open() gives the result again,
        `viscobar info` and `viscobar compare` read it. A Python function of the scene is told by its name."""
        directory = os.fspath(directory)
        if os.path.isdir(directory) and os.listdir(directory):
            raise FileExistsError(f"{directory}: is not empty, and nothing in it is overwritten")
        self._core.save(directory, json.dumps(self.summary))

    def _files(self) -> dict[str, bytes]:
        if isinstance(self._core, Stored):
            return dict(self._core.files)
        with tempfile.TemporaryDirectory() as directory:
            self._core.save(directory, json.dumps(self.summary))
            return dict(Directory(directory))

    def __reduce__(self) -> Any:
        return _stored, (self._files(),)

    def __copy__(self) -> Result:
        return Result(self._core, self.scene)

    def __deepcopy__(self, memo: dict[int, Any]) -> Result:
        return Result(self._core, copy.deepcopy(self.scene, memo))

    def _repr_html_(self) -> str:
        from . import _plots

        told: dict[str, Any] = {"method": self.method, "output times": len(self.t), "contact changes": len(self.events)}
        for where, contact in (self.summary["contact"] or {}).items():
            if isinstance(contact, Mapping) and contact.get("impulse") is not None:
                told[f"impulse, {where}"] = f"{contact['impulse']:.6g}"
        if not self.completed:
            told["stopped at t"] = f"{self.reached_time:g}"
        rows = "".join(f"<tr><th>{html.escape(name)}</th><td>{html.escape(str(value))}</td></tr>" for name, value in told.items())
        return f"<table>{rows}</table>{_plots.small_picture(self)}"

    def __repr__(self) -> str:
        end = "" if self.completed else f", stopped at t = {self.reached_time:g}"
        return (
            f"<viscobar.Result by {self.method}: {len(self.t)} output times, {len(self.x)} nodes, "
            f"{len(self.events)} contact changes{end}>"
        )


def _stored(files: Mapping[str, bytes]) -> Result:
    stored = Stored(files)
    return Result(stored, Scene(stored.told["scene"], validate=False))


def open(directory: str | os.PathLike[str]) -> Result:
    """The result in a directory that `viscobar run` or Result.save() has written. Its files are checked against their sums.

    Raises ValueError where there is none, OSError where a file is damaged. Files that output.write left out are missed where
    they are asked for.
    """
    _core.stored_summary(os.fspath(directory))
    return _stored(Directory(directory))


def _times(times: Any, end: float) -> list[float]:
    """Output times of one's own."""
    if np.ma.is_masked(times) or np.iscomplexobj(times):
        raise ValueError("times: masked or complex numbers")
    try:
        values = np.asarray(times, dtype=float)
    except (TypeError, ValueError) as error:
        raise ValueError(f"times: no numbers: {error}") from None
    if values.ndim != 1 or values.size == 0:
        raise ValueError(f"times: a row of numbers is wanted, not an array of shape {values.shape}")
    if not np.all(np.diff(values) > 0.0) or not (values[0] >= 0.0 and values[-1] <= end):
        raise ValueError(f"times: must rise, from 0 to time.end = {end:g} at most")
    return list(values.tolist())


def run(
    scene: SceneLike,
    method: str | None = None,
    *,
    set: Mapping[str, Any] | None = None,
    error: float | str | None = None,
    times: Any = None,
    observer: Callable[[float, np.ndarray, np.ndarray], Any] | None = None,
    on_event: Callable[[dict[str, Any]], Any] | None = None,
) -> Result:
    """Runs a scene and keeps the result in memory; the numbers are those of `viscobar run`, bit for bit.

    scene     a viscobar.Scene, a dictionary with the same tables and keys, or the path or the text of a scene file
    method    name of the method in place of the scene's own: "automatic", "cvode", "ida", "arkode", "odeint", "rigid",
              "exponential", "characteristics", "fully_discrete", "finite_difference"; absent: the scene's, and automatic
              where it names none
    set       further values in place of the scene's, as --set has them: {"contact.restitution": 0, "bar.2.modulus": 4.0}; a
              table, {"bar": {"viscosity": 0.1}}, changes the keys that it has; None removes a key
    error     the error that is bearable, a number or a percentage such as "0.01 %", of what accuracy.of names in the
              scene (displacements): what the scene leaves open is chosen for it, and .error_estimate tells what is left
    times     output times of your own in place of every output.every, an array that rises; the run itself does not change
    observer  called as observer(t, u, v) at each output time, u and v arrays of J+1 nodes; a true value stops the run
    on_event  called with each contact change, a dictionary with t, where, change, velocity; a true value stops the run

    Returns a viscobar.Result:

        .t (K)  .x (J+1)  .u .v (K, J+1)  .stress (K, J)      arrays, K output times, J elements
        .ends .joints .gauges .energy                          mappings of arrays (K), as ends.csv
        .events                                                structured array: t, where, change, velocity
        .summary                                               as summary.json
        .error_estimate                                        with error=...: total, space, penalty, time, kept, ...
        .at(t, x)                                              u and v between output times and nodes
        .plot()  .page()  .frame()  .save(directory)           matplotlib figure, HTML page, pandas DataFrame of the ends

    A run that an observer stopped has completed = False and the rows that it reached. Other threads of Python go on
    meanwhile. Warnings, such as on chatter, are viscobar.RunWarning.

    Raises SceneError for a scene that cannot be run (all errors at once, each with key and hint), IntegrationError when the
    method gives up, and whatever a function of the scene or an observer raises. KeyboardInterrupt stops a run after the
    step at hand. The exception then has the part that was reached as its attribute `result`.
    """
    if error is not None:
        set = {**(set or {}), "accuracy.error": error}
    scene = as_scene(scene, method, set)
    case = parse(scene)
    kept = [] if times is None else _times(times, case.end)
    core = _core.Run(case)
    result = Result(core, scene)
    try:
        core.go(observer, on_event, kept)
    except BaseException as error:
        error.result = result  # type: ignore[attr-defined]
        raise
    for warning in core.warnings:
        warnings.warn(warning, RunWarning, stacklevel=2)
    if core.ending == "failed":
        failed = IntegrationError(core.error)
        failed.result = result
        raise failed
    if core.ending == "refused":
        raise SceneError([Finding("method.name", core.error)])
    return result
