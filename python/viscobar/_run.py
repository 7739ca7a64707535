"""Runs and their results."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from . import _core
from ._errors import Finding, IntegrationError, RunWarning, SceneError
from ._scene import FUNCTIONS, Scene, SceneLike, as_scene, function_name, is_sampled, parse
from ._table import framed


class Recorded:
    """Traces and field of a run: K output times, J elements, J+1 nodes. Units are those of the scene.

    The arrays are views of the memory that the library has filled; nothing is copied.

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
        return self._core.t

    @cached_property
    def x(self) -> np.ndarray:
        return self._core.x

    @cached_property
    def u(self) -> np.ndarray:
        return self._core.u

    @cached_property
    def v(self) -> np.ndarray | None:
        return self._core.v

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
                columns[f"reaction_{side}"] = reaction
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
        return np.array(list(zip(*columns)), dtype=kind)


class Result(Recorded):
    """What viscobar.run() returns; see Recorded for label, t, x, u, v, ends and events.

    stress    (K, J)  E u_x + eta u_xt, the mean of each element
    gauges    mapping of (K) arrays, as gauges.csv: t and, for each place of output.gauges, "u@0.25", v, strain, stress
    energy    mapping of (K) arrays, as energy.csv: t, kinetic, elastic, contact, dissipated, work, total
    summary   as summary.json: method, counts, energy, contact, scene as understood, ...
    warnings  what the run has to say about itself, in sentences
    method    name of the method that ran
    completed whether it reached the end; reached_time says how far it came otherwise
    """

    _core: _core.Run

    def __init__(self, core: _core.Run, scene: Scene):
        super().__init__(core)
        self.scene = scene

    method = property(lambda self: self._core.method, doc="Name of the method that ran.")
    warnings = property(lambda self: self._core.warnings, doc="Sentences, such as on chatter.")
    completed = property(lambda self: self._core.ending == "completed", doc="Whether the run reached its end.")
    reached_time = property(lambda self: self._core.reached_time, doc="How far the run came.")

    @cached_property
    def sensitivity(self) -> dict[str, dict[str, Any]]:
        """Derivatives by the keys of [sensitivity], NaN or None where there are none (docs/sensitivity.md): for each key
        u and v (K, J+1), ends (as ends, without t), contact_times and contact_velocities (one for each of events),
        impulse_left, impulse_right, energy_final, and until."""
        keys = {}
        for key, told in self._core.sensitivity.items():
            ends = {}
            for side, node in (("left", 0), ("right", -1)):
                ends[f"u_{side}"] = told["u"][:, node]
                ends[f"v_{side}"] = told["v"][:, node]
                ends[f"reaction_{side}"] = told[f"reaction_{side}"]
            account = dict(self.summary["sensitivity"][key])
            for name in ("contact_times", "contact_velocities"):
                account[name] = np.array(account[name], dtype=float)
            keys[key] = {"u": told["u"], "v": told["v"], "ends": ends, **account}
        return keys

    @cached_property
    def stress(self) -> np.ndarray:
        """E u_x + eta u_xt, the mean of each element, (K, J)."""
        modulus, viscosity = self._core.material
        size = np.diff(self.x)  # 0 at a joint of bars in line, where there is no stress
        stress = modulus * np.diff(self.u)
        if np.any(np.greater(viscosity, 0.0)):
            stress += viscosity * np.diff(self.v)
        return np.divide(stress, size, out=np.zeros_like(stress), where=size > 0.0)

    @cached_property
    def gauges(self) -> dict[str, np.ndarray]:
        """The columns of gauges.csv, (K) each: t and, for each place x of output.gauges, "u@x", "v@x", "strain@x", "stress@x"."""
        return {"t": self.t, **self._core.gauges()}

    @cached_property
    def energy(self) -> dict[str, np.ndarray]:
        """The columns of energy.csv, (K) each: t, kinetic, elastic, contact (in their springs), dissipated, work, total.

        total + dissipated - work keeps its value, up to the error of the time integration.
        """
        names = ("kinetic", "elastic", "contact", "dissipated", "work", "total")
        return {"t": self.t, **dict(zip(names, self._core.energies()))}

    @cached_property
    def summary(self) -> dict[str, Any]:
        """summary.json of the run, as a dictionary; without the checksums of files, which there are none of."""
        summary = json.loads(self._core.summary())
        for of_files in ("files", "crc64"):
            summary.pop(of_files, None)
        for key in FUNCTIONS:
            table, leaf = key.split(".")
            function = self.scene.get(table, {}).get(leaf)
            if callable(function) or is_sampled(function):
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

    def plot(self) -> Any:
        """A matplotlib figure: displacement over space and time, end traces, reactions, energies."""
        from . import _plots

        return _plots.plot_run(self)

    def _repr_html_(self) -> str:
        return framed(self.page())

    def __repr__(self) -> str:
        end = "" if self.completed else f", stopped at t = {self.reached_time:g}"
        return (
            f"<viscobar.Result by {self.method}: {len(self.t)} output times, {len(self.x)} nodes, "
            f"{len(self.events)} contact changes{end}>"
        )


def run(
    scene: SceneLike,
    method: str | None = None,
    *,
    set: Mapping[str, Any] | None = None,
    error: float | str | None = None,
    observer: Callable[[float, np.ndarray, np.ndarray], Any] | None = None,
    on_event: Callable[[dict[str, Any]], Any] | None = None,
) -> Result:
    """Runs a scene and keeps the result in memory; the numbers are those of `viscobar run`, bit for bit.

    scene     a viscobar.Scene, a dictionary with the same tables and keys, or the path of a scene file
    method    name of the method in place of the scene's own: "automatic", "cvode", "ida", "arkode", "odeint", "rigid",
              "exponential", "characteristics", "fully_discrete", "finite_difference"; absent: the scene's, and automatic
              where it names none
    set       further values in place of the scene's: {"contact.restitution": 0, "method.relative_tolerance": 1e-8}; None
              removes a key
    error     the error that is bearable, a number or a percentage such as "0.01 %", of what accuracy.of names in the
              scene (displacements): what the scene leaves open is chosen for it, and .error_estimate tells what is left
    observer  called as observer(t, u, v) at each output time, u and v arrays of J+1 nodes; a true value stops the run
    on_event  called with each contact change, a dictionary with t, where, change, velocity; a true value stops the run

    Returns a viscobar.Result:

        .t (K)  .x (J+1)  .u .v (K, J+1)  .stress (K, J)      arrays, K output times, J elements
        .ends .energy                                          mappings of arrays (K), as ends.csv
        .events                                                structured array: t, where, change, velocity
        .summary                                               as summary.json
        .error_estimate                                        with error=...: total, space, penalty, time, kept, ...
        .plot()  .page()  .frame()                             matplotlib figure, HTML page, pandas DataFrame of the ends

    A run that an observer stopped has completed = False and the rows that it reached. Other threads of Python go on
    meanwhile. Warnings, such as on chatter, are viscobar.RunWarning.

    Raises SceneError for a scene that cannot be run (all errors at once, each with key and hint), IntegrationError when the
    method gives up, and whatever a function of the scene or an observer raises. KeyboardInterrupt stops a run after the
    step at hand. The exception then has the part that was reached as its attribute `result`.
    """
    if error is not None:
        set = {**(set or {}), "accuracy.error": error}
    scene = as_scene(scene, method, set)
    core = _core.Run(parse(scene))
    result = Result(core, scene)
    try:
        core.go(observer, on_event)
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
