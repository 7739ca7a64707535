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


def _chosen(kind: str, kinds: Any) -> Any:
    if kind not in kinds:
        raise ValueError(f'kind: "{kind}" is none of {", ".join(kinds)}')
    return kinds[kind]


def _axes(ax: Any, **options: Any) -> tuple[Any, Any]:
    """Figure and axes: those that are given, or new ones."""
    return (ax.figure, ax) if ax is not None else _figure(1, **options)


def _displacement(result: Any, axis: Any) -> None:
    field = axis.pcolormesh(result.x, result.t, result.u, shading="nearest", cmap="RdBu_r", rasterized=True)
    axis.figure.colorbar(field, ax=axis, label="u")
    axis.set(xlabel="x", ylabel="t", title=result.summary["title"] or "displacement")


def _ends(result: Any, axis: Any) -> None:
    for side in ("left", "right"):
        axis.plot(result.ends["t"], result.ends[f"u_{side}"], label=f"{side} end")
    axis.set(xlabel="t", ylabel="u")
    axis.legend()


def _reactions(result: Any, axis: Any) -> None:
    joints = {name: force for name, force in result.joints.items() if name.startswith("force:")}
    for side, style in (("left", "-"), ("right", "--")):  # seen where both are equal
        reaction = result.ends[f"reaction_{side}"]
        if not joints or np.any(reaction):
            axis.plot(result.ends["t"], reaction, style, label=f"{side} end")
    for name, force in joints.items():
        axis.plot(result.t, force, label=name.replace("force:", "joint "))
    axis.set(xlabel="t", ylabel="force of a joint, reaction" if joints else "reaction")
    axis.legend()


def _energy(result: Any, axis: Any) -> None:
    energy = result.energy
    for name in ("kinetic", "elastic", "contact", "dissipated", "work", "total"):
        if name in ("kinetic", "elastic", "total") or np.any(energy[name]):
            axis.plot(energy["t"], energy[name], label=name)
    axis.set(xlabel="t", ylabel="energy")
    axis.legend()


PICTURES = {"displacement": _displacement, "ends": _ends, "reactions": _reactions, "energy": _energy}


def plot_run(result: Any, kind: str | None = None, ax: Any = None) -> Any:
    if kind is None and ax is None:
        figure, axes = _figure(2, 2, figsize=(10, 7))
        for draw, axis in zip(PICTURES.values(), axes.flat):
            draw(result, axis)
        return figure
    draw = _chosen(kind or "ends", PICTURES)
    figure, axis = _axes(ax, figsize=(7, 5))
    draw(result, axis)
    return figure


def small_picture(result: Any) -> str:
    """The displacements of both ends over time as some kilobytes of SVG."""
    ends = result.ends
    if len(ends["t"]) < 2:
        return ""
    some = np.unique(np.linspace(0, len(ends["t"]) - 1, 200).astype(int))
    u = np.array([ends["u_left"][some], ends["u_right"][some]])
    low, high = u.min(), u.max()
    x = 300 * (ends["t"][some] - ends["t"][0]) / (ends["t"][-1] - ends["t"][0])
    y = 5 + 90 * (high - u) / (high - low if high > low else 1.0)
    lines = "".join(
        f'<polyline points="{" ".join(f"{a:.0f},{b:.1f}" for a, b in zip(x, row))}" fill="none" stroke="{colour}"/>'
        for row, colour in zip(y, ("#1f77b4", "#ff7f0e"))
    )
    title = f"u of the left end (blue) and the right end (orange), from {low:.4g} to {high:.4g}, over t"
    return f'<svg viewBox="0 0 300 100" width="300" height="100"><title>{title}</title>{lines}</svg>'


def plot_comparison(comparison: Any, kind: str | None = None, ax: Any = None) -> Any:
    sides = ("left", "right")
    if kind is None and ax is None:
        figure, axes = _figure(2, figsize=(8, 7), sharex=True)
    else:
        sides = (_chosen(kind or "left", {side: side for side in sides}),)
        figure, axis = _axes(ax, figsize=(7, 5))
        axes = [axis]
    for label, run in comparison.runs.items():
        for axis, side in zip(axes, sides):
            axis.plot(run.t, run.ends[f"u_{side}"], label=label)
            axis.set_ylabel(f"u, {side} end")
    axes[0].legend()
    axes[-1].set_xlabel("t")
    return figure


def plot_limit(study: Any, ax: Any = None) -> Any:
    figure, axis = _axes(ax, figsize=(7, 5))
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


def plot_precision(study: Any, ax: Any = None) -> Any:
    figure, axis = _axes(ax, figsize=(7, 5))
    for method in dict.fromkeys(study.column("method")):
        rows = [row for row in study if row["method"] == method and row.get("error")]
        if rows:
            axis.loglog([row["seconds"] for row in rows], [row["error"] for row in rows], "o-", label=method)
    axis.set(xlabel="seconds", ylabel="error")
    axis.legend()
    return figure


def plot(what: Any, **options: Any) -> Any:
    """A matplotlib figure of a Result, a Comparison or a Study; `options` are those of its plot(), such as kind and ax."""
    return what.plot(**options)
