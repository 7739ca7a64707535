"""Comparisons, studies and sweeps."""

from __future__ import annotations

import difflib
import json
import os
import re
import tempfile
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np

from . import _core
from ._errors import Finding, RunWarning, SceneError
from ._ensemble import Progress, at_a_time, telling
from ._run import Recorded
from ._scene import Scene, SceneLike, as_scene, parse
from ._schemes import Method, label_of, recorded
from ._table import Table


class Comparison(Table):
    """What viscobar.compare() returns: a row for each method or scheme, the reference first.

    runs      mapping of names to their traces and fields (viscobar.Recorded)
    contacts  table of the contact periods that a run shares with the reference: begin, end and impulse, and how far they
              are from the reference's
    summary   as `viscobar compare --json`, with the differences of every two runs
    """

    runs: dict[str, Recorded]
    contacts: Table

    @property
    def reference(self) -> str | None:
        """Name of the run that the others are compared with."""
        return self.summary["reference"]

    def plot(self, kind: str | None = None, *, ax: Any = None) -> Any:
        """A matplotlib figure: the end traces of all runs; of one end alone by kind="left" or "right", on the axes `ax`."""
        from . import _plots

        return _plots.plot_comparison(self, kind, ax)


class Study(Table):
    """What viscobar.limit() and viscobar.precision() return: a row for each run; the rest is in `summary`."""

    def plot(self, *, ax: Any = None) -> Any:
        """A matplotlib figure: differences over epsilon, or error over time; on the axes `ax`."""
        from . import _plots

        return _plots.plot_limit(self, ax) if "verdict" in self.summary else _plots.plot_precision(self, ax)

    @property
    def verdict(self) -> str | None:
        """Of limit(): converges, plateau or undecided; `summary["reason"]` says why."""
        return self.summary.get("verdict")


class Orders(Table):
    """What viscobar.orders() returns: errors from the coarsest to the finest level.

    order  mapping of columns to the observed power of h or dt; None where it is not settled
    bound  how far it may be from the power for h or dt -> 0, likewise
    """

    order: dict[str, float | None]
    standard_error: dict[str, float | None]
    bound: dict[str, float | None]


def _listed(names: Any) -> list[Any]:
    """One name, or one scheme, alone is a list of it."""
    return [names] if isinstance(names, str) or callable(names) else list(names)


def _check_methods(names: Sequence[str]) -> None:
    for name in names:
        if name not in _core.methods:
            near = difflib.get_close_matches(name, _core.methods, 1)
            raise SceneError([Finding("method.name", f'there is no method "{name}"',
                                      f'nearest is "{near[0]}"' if near else "known are " + ", ".join(_core.methods))])  # fmt: skip


def compare(
    scene: SceneLike,
    methods: Sequence[Method] | None = None,
    *,
    schemes: Mapping[str, Callable[..., Any]] | None = None,
    set: Mapping[str, Any] | None = None,
    levels: int = 0,
    refine: str = "both",
    exact: Mapping[str, Callable[..., float]] | None = None,
    threads: int = 0,
) -> Comparison:
    """One scene by several methods and by schemes of your own, and how far they are apart.

    methods  names of built-in methods, and functions, which are schemes of your own; absent: all methods that fit the
             scene. The first method that is built in is the reference.
    schemes  further schemes by the names that they get
    set      values in place of the scene's, as in viscobar.run()
    levels   3 or more: also the observed order of each, by viscobar.orders() with `refine` and `exact`, as columns order_...;
             None where it is not settled
    refine, exact  see viscobar.orders()
    threads  runs at a time; 0: one a core

    A scheme is a function scheme(case) -> ends, field or ends, field, events. It is given a viscobar.Case (nodes, times, step,
    material, initial data, load) and returns, for N steps of any length from t = 0 to the end,

        ends    mapping of columns (N) as ends.csv: "t" and, where there is contact, "reaction_left", "reaction_right"
        field   (u, v), arrays (N, J+1); or None, then ends has u_left, v_left, u_right, v_right, too
        events  contact changes (t, "left" or "right", "closing" or "opening", velocity); absent: read off the reactions

    Rows have, of each run, method, mass, steps, integration_seconds, events, max_penetration and its largest differences to
    the reference: displacement_l2, displacement_h1, velocity_l2 (over the bar), end_trace, largest_event_shift;
    events_matched is the number of contact changes that both have. None: not known.

    What a scheme raises comes out as it is. A built-in method that fails is a row with an error.
    """
    methods = None if methods is None else _listed(methods)
    named = [method for method in methods or [] if isinstance(method, str)]
    own: dict[str, Any] = {label_of(method): method for method in methods or [] if not isinstance(method, str)}
    own.update(schemes or {})
    _check_methods(named)
    scene = as_scene(scene, None, set)
    case = parse(scene, "compare")
    kept = [recorded(case, label, scheme) for label, scheme in own.items()]
    built_in = None if methods is None or (not named and schemes is None and not own) else named
    text, page, differences, runs = _core.compare(case, built_in, kept, at_a_time(threads))
    summary = json.loads(text)
    rows = []
    for entry, difference in zip(summary["methods"], differences):
        row = {key: value for key, value in entry.items() if key not in ("contacts", "energy")}
        rows.append({**row, **(difference or dict.fromkeys(DIFFERENCES))})
        rows[-1]["events"] = entry.get("events")
    table = Comparison(rows, summary, page)
    labels = [entry["method"] for entry in summary["methods"]]
    table.runs = {label: Recorded(run) for label, run in zip(labels, runs) if run is not None}
    table.contacts = Table(_contact_shifts(summary))
    if levels >= 2:
        for label, row in zip(labels, table):
            if label == table.reference and label not in own and exact is None and refine == "step":
                continue
            observed = orders(own.get(label, label), scene, refine=refine, levels=levels, exact=exact)
            row.update({f"order_{key}": value for key, value in observed.order.items()})
    return table


DIFFERENCES = (
    "displacement_l2", "displacement_h1", "velocity_l2", "end_trace", "events_reference", "events_matched",
    "largest_event_shift", "energy_final",
)  # fmt: skip


def _contact_shifts(summary: Mapping[str, Any]) -> list[dict[str, Any]]:
    rows = []
    for pair in summary["pairs"]:
        if pair["first"] != summary["reference"]:
            continue
        for contact in pair["contacts"]:
            first, other = contact["first"], contact["other"]
            row = {"where": contact["where"], "method": pair["other"]}
            for key in ("begin", "end", "impulse"):
                row[key] = other[key]
                known = other[key] is not None and first[key] is not None
                row[f"{key}_shift"] = other[key] - first[key] if known else None
            rows.append(row)
    return rows


def orders(
    scheme: Method,
    scene: SceneLike,
    *,
    refine: str = "both",
    levels: int = 4,
    exact: Mapping[str, Callable[..., float]] | None = None,
    set: Mapping[str, Any] | None = None,
) -> Orders:
    """Errors of a method, or of a scheme of your own, along a refinement, and the powers that they follow.

    scheme  name of a built-in method, or a function as in viscobar.compare()
    refine  "mesh" (h is halved), "step" (dt is halved), or "both"
    levels  number of runs, the scene's mesh and step first
    set     values in place of the scene's, as in viscobar.run()
    exact   the solution, a mapping of functions: "u" and "v" of (x, t), "reaction_left" and "reaction_right" of t; all but
            "u" may be missing. Absent: the method characteristics, exact where it fits the scene (no viscosity); else, with
            refine="step", each run is compared with the next finer one.

    Rows: elements, step, displacement_l2 and velocity_l2 (largest over time of the norm over the bar), end_trace (largest over
    time and ends), reaction_l1 (over time). `.order` has the power of each column, None where three levels
    or more do not settle to one, and `.bound` its bound.
    """
    if refine not in ("mesh", "step", "both"):
        raise ValueError(f'refine: "{refine}" is not mesh, step or both')
    if isinstance(scheme, str):
        _check_methods([scheme])
    case = parse(as_scene(scene, scheme if isinstance(scheme, str) else None, set))
    cases = _core.refined(case, refine, levels)
    if isinstance(scheme, str):
        kept = [_core.record(one) for one in cases]
    else:
        kept = [recorded(one, label_of(scheme), scheme) for one in cases]
    rows, observed = _core.orders(cases, kept, refine, dict(exact or {}))
    table = Orders(rows)
    table.order, table.standard_error, table.bound = (
        {key: told[part] if told else None for key, told in observed.items()} for part in range(3)
    )
    return table


def limit(
    scene: SceneLike,
    *,
    epsilon: Sequence[float] | None = None,
    mass: str | None = None,
    elements: Sequence[int] = (),
    steps: Sequence[float] = (),
    budget: float = 60.0,
    error: float | str | None = None,
    progress: Progress = None,
    set: Mapping[str, Any] | None = None,
    threads: int = 0,
) -> Study:
    """Whether the penalised bar tends to the fully discrete scheme as epsilon goes to 0, and how fast: `viscobar limit`.

    epsilon      penalties, decreasing; absent: 1e-2, 1e-3, ..., 1e-8 times L/E, under a span obstacle alone L^2/E
    mass         name of a mass matrix in place of the scene's
    elements     meshes in place of the scene's; three or more give epsilon(h)
    steps        of the scheme, one for each mesh; absent: the scene's
    budget       processor seconds for smaller steps of the scheme
    error        the error that is bearable at epsilon = 0, as in viscobar.run(): the elements are chosen for it
    progress     called with the runs done and all runs so far; True: a bar of tqdm
    set          values in place of the scene's, as in viscobar.run()
    threads      runs at a time; 0: one a core

    Rows have epsilon, elements, mass, events, max_penetration, difference_to_scheme, difference_to_rigid. `.verdict` is
    converges, plateau or undecided, `.summary` has reason and orders. Ctrl-C ends it within the step at hand.
    """
    changes = {**(set or {})}
    if mass is not None:
        changes["mesh.mass"] = mass
    if elements:
        changes["mesh.elements"] = max(elements)
    if error is not None:
        if elements:
            raise ValueError("elements: error chooses the mesh; give one of the two")
        changes["accuracy.error"] = error
    if len(steps) not in (0, max(1, len(elements))):
        raise ValueError(f"steps: {len(steps)} given for {max(1, len(elements))} meshes, one for each is needed")
    if epsilon is None:  # the scene's own, which it may lack, is not used
        epsilons = _core.natural_penalties(parse(as_scene(scene, None, changes), "limit"))
    else:
        epsilons = sorted(map(float, epsilon), reverse=True)
    if not epsilons:
        raise ValueError("epsilon: at least one penalty is needed")
    case = parse(as_scene(scene, None, {"contact.epsilon": epsilons[0], **changes}), "limit")
    with telling(progress, "run") as told:
        text, page = _core.limit(case, epsilons, list(elements), list(steps), budget, at_a_time(threads), told)
    summary = json.loads(text)
    if (estimate := summary.get("error_estimate")) and not estimate["kept"]:
        warnings.warn("limit: the error that was asked for is not kept at epsilon = 0", RunWarning, stacklevel=2)
    return Study(summary["rows"], summary, page)


def precision(
    scene: SceneLike,
    *,
    methods: Sequence[str] = (),
    tolerances: Sequence[float] | None = None,
    elements: Sequence[int] = (),
    halvings: int = 9,
    repeat: int = 0,
    seconds: float = 1.0,
    set: Mapping[str, Any] | None = None,
    threads: int = 0,
) -> Study:
    """Time against error for the methods that fit the scene, and the error's parts: `viscobar precision`.

    methods     names; absent: all that fit the scene
    tolerances  relative, decreasing; absent: 1e-3, 1e-4, ..., 1e-10
    elements    meshes in place of the scene's
    halvings    how often the schemes' step is halved, from h / c on
    repeat      timed runs of each row, odd, whose median counts; 0: 3 to 11
    seconds     runs that take longer are left out
    set         values in place of the scene's, as in viscobar.run()
    threads     references at a time; 0: one a core. Timed runs run alone.

    Rows have method, label, error, seconds, steps; `.summary` has the reference and how good it is. Ctrl-C ends it within the step at hand.
    """
    methods = _listed(methods)
    _check_methods(methods)
    if repeat and repeat % 2 == 0:
        raise ValueError("repeat: the median needs an odd number of runs")
    changes = dict(set or {})
    if elements:
        changes["mesh.elements"] = max(elements)
    case = parse(as_scene(scene, None, changes))
    values = sorted(map(float, tolerances), reverse=True) if tolerances is not None else _core.decades(1e-3, 1e-10, 1)
    text, page = _core.precision(case, list(methods), values, list(elements), halvings, repeat, seconds, at_a_time(threads))
    summary = json.loads(text)
    return Study(summary["rows"], summary, page)


def check(scene: SceneLike, *, set: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """What a scene needs, and what is predicted of its first impacts: `viscobar check --json` as a dictionary.

    set  values in place of the scene's, as in viscobar.run()

    Raises SceneError with all errors of an unsound scene. `contacts` has a row for each contact: effective mass, damping
    ratio, whether chatter is expected, predicted penetration; `warnings` are sentences.
    """
    return json.loads(_core.check(parse(as_scene(scene, None, set))))


class Fit(Table):
    """What viscobar.fit() returns: a row for each parameter, with key, estimate, standard_deviation and at_bound.

    estimates   mapping of keys to estimates
    covariance  array (n, n), n parameters, in the order of the rows; NaN where the data do not determine it
    runs        of the model
    converged   whether it came to a minimum, and nothing speaks against it; `summary["reason"]` says why it ended,
                `summary["warnings"]` what speaks against it
    summary     as `viscobar fit --json`
    """

    @property
    def estimates(self) -> dict[str, float]:
        return {row["key"]: row["estimate"] for row in self}

    @property
    def covariance(self) -> np.ndarray:
        return np.array([[np.nan if value is None else value for value in row] for row in self.summary["covariance"]])

    @property
    def runs(self) -> int:
        return int(self.summary["runs"])

    @property
    def converged(self) -> bool:
        return bool(self.summary["converged"])


@contextmanager
def _folder_of_arrays() -> Iterator[str]:
    """A folder for arrays as files, whose name nobody has seen: errors call the files by their own names."""
    with tempfile.TemporaryDirectory() as directory:
        try:
            yield directory
        except SceneError as error:
            found = error.findings
            raise SceneError([replace(one, source=one.source.removeprefix(directory + os.sep)) for one in found]) from None
        except ValueError as error:
            raise ValueError(str(error).replace(directory + os.sep, "")) from None


def _measured(data: Any, file: str, command: str = "fit") -> str:
    """The path of a table: `data` itself, or that of a file with its columns."""
    if data is None:
        return ""
    if isinstance(data, (str, os.PathLike)):
        return os.fspath(data)
    if isinstance(data, np.ndarray):  # .events of a result
        data = {name: data[name] for name in data.dtype.names}
    for name, values in data.items():
        if np.iscomplexobj(values):
            raise ValueError(f"{command}: {name} has complex numbers")
    columns = {name: list(values.astype(float).filled(np.nan) if np.ma.isMaskedArray(values) else values) for name, values in data.items()}
    if len({len(values) for values in columns.values()}) > 1:
        raise ValueError(f"{command}: the columns of the data have different lengths")
    with open(file, "w", encoding="utf-8") as out:
        print(",".join(columns), file=out)
        for row in zip(*columns.values()):
            print(",".join(cell if isinstance(cell, str) else "" if np.isnan(cell) else repr(float(cell)) for cell in row), file=out)
    return file


def fit(
    scene: SceneLike,
    parameters: Sequence[str],
    *,
    data: Mapping[str, Any] | str | os.PathLike[str] | None = None,
    events: Mapping[str, Any] | str | os.PathLike[str] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    deviations: Mapping[str, float] | None = None,
    starts: int = 1,
    runs: int = 100,
    set: Mapping[str, Any] | None = None,
) -> Fit:
    """Least squares on measured traces and contact times: `viscobar fit`, see docs/fit.md.

    parameters  keys to look for, such as ["bar.viscosity", "left.gap"]; the scene says where they begin
    data        traces: a mapping of columns as `.ends` of a result, "t" among them, NaN where nothing was measured; or a file
    events      contact times: a mapping with "t", "where" ("left", "right"), "change" ("closing", "opening"); or a file
    bounds      {key: (low, high)}
    deviations  {column: standard deviation of its noise, in the column's unit}, "events" for contact times
    starts      begins so many times, spread over the bounds
    runs        of the model at most, for each start
    set         values in place of the scene's, as in viscobar.run()

    The scene must have formulas, not Python functions. Ctrl-C ends it within the step at hand.
    """
    text = Scene.toml(as_scene(scene, None, set))
    parameters = _listed(parameters)
    with _folder_of_arrays() as directory:
        request = (
            _measured(data, os.path.join(directory, "data.csv")),
            _measured(events, os.path.join(directory, "events.csv")),
            list(parameters),
            [f"{key}={float(low)!r}:{float(high)!r}" for key, (low, high) in (bounds or {}).items()],
            [f"{column}={float(value)!r}" for column, value in (deviations or {}).items()],
            starts,
            runs,
        )
        try:
            printed, page = _core.fit(text, *request)
        except ValueError as error:  # the options of the program are arguments here
            if isinstance(error, SceneError):
                raise
            said = str(error).replace("--deviation", "deviations")
            raise ValueError(re.sub(r"--([a-z])", r"\1", said)) from None
    printed, page = (text.replace(directory + os.sep, "") for text in (printed, page))
    summary = json.loads(printed)
    return Fit([{"key": key, **told} for key, told in summary["parameters"].items()], summary, page)


class Judgement(Table):
    """What viscobar.judge() returns: a row for each quantity of each solution, with label, quantity, largest, at,
    root_mean_square, mean, size, own_error, own_mean, told_apart, order and order_of.

    missed, made_up  contacts of the bar that the solutions have not, and theirs that the bar has not
    untold           contacts of which samples cannot tell
    contacts         Table of all, with label, where, verdict, begin, end, their_begin, their_end, delay, longer, parts, own_error
    summary          as `viscobar compare --with --json`
    """

    def _count(self, name: str) -> int:
        return sum(one[name] for one in self.summary["judged"])

    @property
    def missed(self) -> int:
        return self._count("missed")

    @property
    def made_up(self) -> int:
        return self._count("made_up")

    @property
    def untold(self) -> int:
        return self._count("untold")

    @property
    def contacts(self) -> Table:
        return Table([{"label": one["label"], **contact} for one in self.summary["judged"] for contact in one["contacts"]])


def judge(
    scene: SceneLike,
    t: Sequence[float] | None = None,
    *,
    files: Sequence[str | os.PathLike[str] | Sequence[str | os.PathLike[str]]] = (),
    columns: Mapping[str, Sequence[float]] | None = None,
    events: Mapping[str, Any] | str | os.PathLike[str] | None = None,
    set: Mapping[str, Any] | None = None,
    **traces: Sequence[float],
) -> Judgement:
    """A solution of your own beside the bar's own motion, with a rigid obstacle: `viscobar compare --with`.

    t        times of the solution, in [0, time.end]
    traces   columns of ends.csv, such as u_left=..., NaN where there is none
    columns  others, such as {"u@0.25": ...} for the place x = 0.25
    events   its contact changes, "t", "where" and "change", as `.events` of a result; or a file; also alone
    files    CSV files with such columns in place of arrays, "FILE" or "FILE=STEP": several with steps show an order; a
             list of lists for several schemes, each with an order of its own
    set      values in place of the scene's, as in viscobar.run()

    What the scene says of mesh, method, epsilon and tolerances is left out: they are chosen so that our own error is a
    tenth of each difference, as far as a minute allows. The scene must have formulas, not Python functions.
    """
    data = {**traces, **(columns or {})}
    if (t is None) != (not data) or not (files or data or events is not None):
        raise TypeError("judge: wants t and columns such as u_left, events, or files")
    flat = all(isinstance(file, (str, os.PathLike)) for file in files)
    schemes = [[os.fspath(file) for file in group] for group in ([files] if flat else files)]
    with _folder_of_arrays() as directory:
        own = [
            _measured({"t": t, **data} if data else None, os.path.join(directory, "solution.csv"), "judge"),
            _measured(events, os.path.join(directory, "events.csv"), "judge"),
        ]
        schemes.append([file for file in own if file])
        printed, page = _core.judge(Scene.toml(as_scene(scene, None, set)), schemes)
    printed, page = (text.replace(directory + os.sep, "") for text in (printed, page))
    summary = json.loads(printed)
    rows = [
        {"label": one["label"], "quantity": quantity, **told}
        for one in summary["judged"]
        for quantity, told in one["columns"].items()
    ]
    return Judgement(rows, summary, page)


def sweep(
    scene: SceneLike,
    vary: Mapping[str, Sequence[Any]] | None = None,
    *,
    combine: str = "grid",
    error: float | str | None = None,
    set: Mapping[str, Any] | None = None,
    threads: int = 0,
) -> Table:
    """A scene for many values of its keys, on all cores, kept in memory.

    vary     keys with the values that they take: {"bar.viscosity": [0.01, 0.1, 1.0], "left.gap": [0.1, 0.2]}
    error    the error that is bearable in each case, as in viscobar.run()
    combine  "grid": every value with every other, the last key running fastest; "zip": the first values, the second ones, ...
    set      values in place of the scene's, as in viscobar.run()
    threads  cases at a time; 0: one a core

    Without `vary`, `scene` is the path of a sweep file (docs/sweep.md).

    A row for each case: index, the keys, completed, error, and the quantities of sweep.csv (closings, impulses, energies, ...);
    NaN: the case has no such value. The rows do not depend on the number of threads. Ctrl-C stops it within the step at
    hand; KeyboardInterrupt has the finished rows as its attribute `rows`. The scene must have formulas, not Python functions.
    """
    rows: list[dict[str, Any]] = []
    try:
        if vary is None:
            if not isinstance(scene, (str, os.PathLike)) or set or error is not None:
                raise TypeError("sweep: without `vary`, the path of a sweep file alone is wanted")
            _core.sweep_file(os.fspath(scene), at_a_time(threads), rows)
        else:
            if combine not in ("grid", "zip"):
                raise ValueError(f'combine: "{combine}" is neither grid nor zip')
            lists = {key: [v.item() if isinstance(v, np.generic) else v for v in values] for key, values in vary.items()}
            if empty := [key for key, values in lists.items() if not values]:
                raise ValueError(f"{', '.join(empty)}: no values")
            if combine == "zip" and len({len(values) for values in lists.values()}) > 1:
                raise ValueError("zip: the keys have different numbers of values")
            changes = dict(set or {}) if error is None else {**(set or {}), "accuracy.error": error}
            text = Scene.toml(as_scene(scene, None, changes))
            _core.sweep_scene(text, lists, combine == "zip", at_a_time(threads), rows)
    except BaseException as error:
        error.rows = Table(rows)  # type: ignore[attr-defined]
        raise
    return Table(rows)
