"""Many bars of one scene: arrays in, arrays out."""

from __future__ import annotations

import contextlib
import numbers
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Union

import numpy as np

from . import _core
from ._scene import Scene, SceneLike, as_scene

statuses: tuple[str, ...] = tuple(_core.bar_statuses)
"""Meanings of the codes of `status`: kept, not_kept, failed, faulty, not_run."""

ways: tuple[str, ...] = tuple(_core.bar_ways)
"""Meanings of the codes of `way`: none, lanes, alone."""


Progress = Union[Callable[[int, int], Any], bool, None]


def at_a_time(threads: Any) -> int:
    """A number of threads, 0 for one a core."""
    try:
        count = 0 if threads is None else operator.index(threads)
    except TypeError:
        raise TypeError(f"threads: a whole number is wanted, 0 for one a core, not {threads!r}") from None
    if count < 0:
        raise ValueError(f"threads: must not be negative, is {count}; 0 is one a core")
    return count


@contextlib.contextmanager
def telling(progress: Progress, unit: str) -> Iterator[Callable[[int, int], Any] | None]:
    """A function that is told how many are done of how many; for True it moves a bar of tqdm."""
    if progress is not True:
        if progress and not callable(progress):
            raise TypeError(f"progress: a function of two numbers, or True, is wanted, not {progress!r}")
        yield progress or None
        return
    from tqdm import tqdm

    with tqdm(unit=unit) as shown:

        def move(done: int, of: int) -> None:
            shown.total = of
            shown.update(done - shown.n)

        yield move


def _row(key: str, value: Any) -> np.ndarray:
    """The values of a parameter, NaN where a mask hides one: such a bar is faulty."""
    if np.iscomplexobj(value):
        raise ValueError(f"{key}: complex numbers")
    try:
        return value.astype(float).filled(np.nan) if np.ma.isMaskedArray(value) else np.asarray(value, float)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{key}: no numbers: {error}") from None


def _share(error: Any) -> float | None:
    """An error as a share of the largest value."""
    share = _core.percentage(error.strip()) if isinstance(error, str) else error
    if isinstance(error, str) and share is None:
        raise ValueError(f'error: "{error}" is neither a number nor a percentage such as "1 %"')
    if share is not None and not (isinstance(share, numbers.Real) and share > 0):
        raise ValueError(f"error: a positive number or a percentage is wanted, not {error!r}")
    return None if share is None else float(share)


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
    outputs: Sequence[str] | str,
    *,
    error: float | str | None = None,
    threads: int | None = None,
    progress: Progress = None,
    set: Mapping[str, Any] | None = None,
) -> Ensemble:
    """A scene for many values of its numbers, on all cores, without files: see docs/ensembles.md.

    parameters  keys with arrays, such as {"bar.viscosity": eta, "left.gap": gap}; they are broadcast, so that the arrays
                of np.meshgrid() make a grid, and numbers alone one bar, whose results have no axis of bars. A bar with
                a value that is NaN, or hidden by a mask, is faulty
    outputs     "u_left@0.1" (any column of ends.csv, every 0.1), "gauge:0.25@0.01" (u, v, strain, stress at x = 0.25),
                "events:8" (times of the first contact changes), "impulse_left", "peak_left", "final" (u and v of all nodes)
    error       of each bar, as a share of the largest value of what is asked for, 0.01 or "1 %"; that of the mesh comes on
                top. Without it each bar is run by the scene's own method
    threads     at a time; None or 0: one a core
    progress    called with the bars done and all bars; True: a bar of tqdm
    set         values in place of the scene's, as in viscobar.run()

    The result does not depend on the number of threads, nor on which other bars there are. The scene must have formulas, not
    Python functions. Ctrl-C stops it.
    """
    rows = {key: _row(key, value) for key, value in parameters.items()}
    try:
        shape = np.broadcast_shapes(*(row.shape for row in rows.values()))
    except ValueError:
        shapes = ", ".join(f"{key} {row.shape}" for key, row in rows.items())
        raise ValueError(f"parameters: these shapes do not go together: {shapes}") from None
    if empty := [key for key, row in rows.items() if row.size == 0]:
        raise ValueError(f"{', '.join(empty)}: no values, so there are no bars")
    arrays = [np.broadcast_to(row, shape if row.ndim else ()).ravel() for row in rows.values()]
    text = Scene.toml(as_scene(scene, None, set))
    outputs = [outputs] if isinstance(outputs, str) else list(outputs)
    if wrong := [one for one in outputs if not isinstance(one, str)]:
        raise TypeError(f'outputs: texts such as "u_left@0.1" are wanted, not {wrong[0]!r}')
    with telling(progress, "bar") as told:
        result = _core.ensemble(text, list(rows), arrays, outputs, _share(error), at_a_time(threads), told)
    return Ensemble(result, shape)
