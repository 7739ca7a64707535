"""Many bars of one scene: arrays in, arrays out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from . import _core
from ._scene import Scene, SceneLike, as_scene

statuses: tuple[str, ...] = tuple(_core.bar_statuses)
"""Meanings of the codes of `status`: kept, not_kept, failed, faulty, not_run."""

ways: tuple[str, ...] = tuple(_core.bar_ways)
"""Meanings of the codes of `way`: none, lanes, alone."""


class Ensemble(Mapping[str, np.ndarray]):
    """What viscobar.ensemble() returns: a mapping of each output to an array, the axes of the parameters first.

    status    codes of viscobar.ensemble_statuses: 0 is a bar that is within its error
    error     the estimate of each bar, NaN without a request
    way       codes of viscobar.ensemble_ways: side by side in lanes, or alone
    steps     of each bar
    times     mapping of outputs such as "u_left@0.1" to their times
    messages  why bars failed: {index of the bar: sentence}, of the first hundred
    """

    def __init__(self, told: dict[str, Any], shape: tuple[int, ...]) -> None:
        self.times: dict[str, np.ndarray] = told.pop("times")
        self.messages: dict[int, str] = dict(told.pop("messages"))
        arrays = {key: array.reshape(shape + array.shape[1:]) for key, array in told.items()}
        self.status, self.error = arrays.pop("status"), arrays.pop("error")
        self.way, self.steps = arrays.pop("way"), arrays.pop("steps")
        self._arrays = arrays

    def __getitem__(self, key: str) -> np.ndarray:
        return self._arrays[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    def __repr__(self) -> str:
        counts = ", ".join(f"{np.count_nonzero(self.status == k)} {word}" for k, word in enumerate(statuses) if (self.status == k).any())  # fmt: skip
        return f"<Ensemble of {self.status.size} bars: {counts}; {', '.join(self._arrays)}>"


def ensemble(
    scene: SceneLike,
    parameters: Mapping[str, Any],
    outputs: Sequence[str],
    *,
    error: float | None = None,
    threads: int | None = None,
    progress: Callable[[int, int], Any] | bool | None = None,
    set: Mapping[str, Any] | None = None,
) -> Ensemble:
    """A scene for many values of its numbers, on all cores, without files: see docs/ensembles.md.

    parameters  keys with arrays, such as {"bar.viscosity": eta, "left.gap": gap}; they are broadcast, so that the arrays
                of np.meshgrid() make a grid
    outputs     "u_left@0.1" (any column of ends.csv, every 0.1), "gauge:0.25@0.01" (u, v, strain, stress at x = 0.25),
                "events:8" (times of the first contact changes), "impulse_left", "peak_left", "final" (u and v of all nodes)
    error       of each bar, as a share of the largest value of what is asked for; that of the mesh comes on top. Without it
                each bar is run by the scene's own method
    threads     at a time; None: one a core
    progress    called with the bars done and all bars; True: a bar of tqdm
    set         values in place of the scene's, as in viscobar.run()

    The result does not depend on the number of threads, nor on which other bars there are. The scene must have formulas, not
    Python functions. Ctrl-C stops it.
    """
    shape = np.broadcast_shapes(*(np.shape(value) for value in parameters.values())) if parameters else ()
    arrays = [np.broadcast_to(np.asarray(value, float), shape if np.ndim(value) else ()).ravel() for value in parameters.values()]
    if any(array.size == 0 for array in arrays):
        raise ValueError("ensemble: no bars: an array of parameters is empty")
    shown = None
    if progress is True:
        from tqdm import tqdm

        shown = tqdm(total=int(np.prod(shape, dtype=int)), unit="bar")
        progress = lambda done, _: shown.update(done - shown.n)  # noqa: E731
    try:
        text = Scene.toml(as_scene(scene, None, set))
        told = _core.ensemble(text, list(parameters), arrays, list(outputs), error, threads or 0, progress or None)
    finally:
        if shown is not None:
            shown.update(shown.total - shown.n)
            shown.close()
    return Ensemble(told, shape or (1,))
