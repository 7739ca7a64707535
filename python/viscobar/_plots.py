"""Pictures by matplotlib."""

from __future__ import annotations

from typing import Any

import numpy as np


def _figure(rows: int, columns: int = 1, **options: Any) -> Any:
    from matplotlib.figure import Figure

    try:  # in a notebook or a window, where there is one
        from matplotlib import pyplot

        return pyplot.subplots(rows, columns, layout="constrained", **options)
    except ImportError:
        figure = Figure(layout="constrained")
        return figure, figure.subplots(rows, columns)


def plot_run(result: Any) -> Any:
    figure, axes = _figure(2, 2, figsize=(10, 7))
    field = axes[0, 0].pcolormesh(result.x, result.t, result.u, shading="nearest", cmap="RdBu_r", rasterized=True)
    figure.colorbar(field, ax=axes[0, 0], label="u")
    axes[0, 0].set(xlabel="x", ylabel="t", title=result.summary["title"] or "displacement")
    ends, energy = result.ends, result.energy
    for side in ("left", "right"):
        axes[0, 1].plot(ends["t"], ends[f"u_{side}"], label=f"{side} end")
        style = "-" if side == "left" else "--"  # seen where both are equal
        axes[1, 0].plot(ends["t"], ends[f"reaction_{side}"], style, label=f"{side} end")
    for name in ("kinetic", "elastic", "contact", "dissipated", "work", "total"):
        if name in ("kinetic", "elastic", "total") or np.any(energy[name]):
            axes[1, 1].plot(energy["t"], energy[name], label=name)
    for axis, what in ((axes[0, 1], "u"), (axes[1, 0], "reaction"), (axes[1, 1], "energy")):
        axis.set(xlabel="t", ylabel=what)
        axis.legend()
    return figure


def plot_comparison(comparison: Any) -> Any:
    figure, axes = _figure(2, figsize=(8, 7), sharex=True)
    for label, run in comparison.runs.items():
        for axis, side in zip(axes, ("left", "right")):
            axis.plot(run.t, run.ends[f"u_{side}"], label=label)
            axis.set_ylabel(f"u, {side} end")
    axes[0].legend()
    axes[1].set_xlabel("t")
    return figure


def plot_limit(study: Any) -> Any:
    figure, axis = _figure(1, figsize=(7, 5))
    meshes = list(dict.fromkeys(study.column("elements")))
    for elements in meshes:
        rows = [row for row in study if row["elements"] == elements]
        for key in ("max_penetration", "difference_to_scheme", "difference_to_rigid"):
            values = [row.get(key) for row in rows]
            if all(values):
                of_mesh = f", {elements} elements" if len(meshes) > 1 else ""
                axis.loglog([row["epsilon"] for row in rows], values, "o-", label=key.replace("_", " ") + of_mesh)
    axis.set(xlabel="epsilon", title=study.verdict)
    axis.legend()
    return figure


def plot_precision(study: Any) -> Any:
    figure, axis = _figure(1, figsize=(7, 5))
    for method in dict.fromkeys(study.column("method")):
        rows = [row for row in study if row["method"] == method and row.get("error")]
        if rows:
            axis.loglog([row["seconds"] for row in rows], [row["error"] for row in rows], "o-", label=method)
    axis.set(xlabel="seconds", ylabel="error")
    axis.legend()
    return figure


def plot(what: Any) -> Any:
    """A matplotlib figure of a Result, a Comparison or a Study."""
    return what.plot()
