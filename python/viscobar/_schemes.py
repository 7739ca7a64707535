"""Schemes of one's own: Python functions beside the built-in methods."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Union

import numpy as np

from . import _core

Scheme = Callable[[_core.Case], tuple[Any, ...]]
Method = Union[str, Scheme]


def label_of(scheme: Method) -> str:
    return scheme if isinstance(scheme, str) else getattr(scheme, "__name__", type(scheme).__name__)


def recorded(case: _core.Case, label: str, scheme: Scheme) -> _core.Kept:
    """Runs a scheme on a case and takes its steps to the output times."""

    def refuse(what: str) -> ValueError:
        return ValueError(f"{label}: {what}")

    out = scheme(case)
    if not isinstance(out, tuple) or len(out) not in (2, 3):
        raise refuse("a scheme returns (ends, field) or (ends, field, events)")
    ends, field = out[0], out[1]
    if not isinstance(ends, Mapping) or "t" not in ends:
        raise refuse('ends must be a mapping of columns with the times of the steps, "t"')

    def column(key: str, missing: Any = None) -> np.ndarray:
        if key not in ends:
            if missing is None:
                raise refuse(f'without a field, ends needs the column "{key}"')
            return missing
        values = np.ascontiguousarray(ends[key], dtype=float)
        if values.ndim != 1 or "t" in ends and len(values) != len(ends["t"]):
            raise refuse(f'ends["{key}"] has the shape {values.shape}, not ({len(ends["t"])},)')
        return values

    t = column("t")
    nodes = len(case.x)
    if field is None:
        u = np.column_stack([column("u_left"), column("u_right")])
        v = np.column_stack([column("v_left"), column("v_right")])
    else:
        u, v = (field["u"], field["v"]) if isinstance(field, Mapping) else field
        u, v = np.ascontiguousarray(u, dtype=float), np.ascontiguousarray(v, dtype=float)
        for name, values in (("u", u), ("v", v)):
            if values.shape != (len(t), nodes):
                raise refuse(f"{name} has the shape {values.shape}, not ({len(t)}, {nodes}): a row a step, a column a node")
    none = np.zeros(len(t))
    reactions = {side: column(f"reaction_{side}", none) for side in ("left", "right")}
    # The impulse so far is the integral over the steps, which the output times do not resolve.
    impulses = {side: np.append(0.0, np.cumsum(np.diff(t) * (R[1:] + R[:-1]) / 2)) for side, R in reactions.items()}
    if len(out) == 3:
        for at, where, change, _ in out[2]:
            if where not in ("left", "right") or change not in ("closing", "opening"):
                raise refuse(f"the contact change {where!r}, {change!r} at t = {at} is none: left or right, closing or opening")
        events = [
            (float(at), where == "left", change == "closing", float(velocity), float(np.interp(at, t, impulses[where])))
            for at, where, change, velocity in out[2]
        ]
    else:
        events = [
            change
            for side, node in (("left", 0), ("right", -1))
            if getattr(case, side) == "obstacle"
            for change in changes(t, v[:, node], reactions[side], impulses[side], side == "left")
        ]
        events.sort(key=lambda change: change[0])  # a contact of one step closes and opens at once
    return _core.recorded(case, label, t, u, v, reactions["left"], reactions["right"], events)


Change = tuple[float, bool, bool, float, float]


def changes(t: np.ndarray, v: np.ndarray, reaction: np.ndarray, impulse: np.ndarray, left: bool) -> list[Change]:
    """Contact changes by the reaction: a contact closes at the first step with one and opens at the last, as in the
    built-in schemes. What the reaction does in the step before and in the step after belongs to the contact."""
    closed = reaction != 0.0
    found = [(float(t[0]), left, True, float(v[0]), 0.0)] if closed[0] else []
    for n in np.flatnonzero(closed[1:] != closed[:-1]):
        if closed[n + 1]:
            found.append((float(t[n + 1]), left, True, float(v[n]), float(impulse[n])))
        else:
            found.append((float(t[n]), left, False, float(v[n + 1]), float(impulse[n + 1])))
    return found
