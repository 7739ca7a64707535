"""Motion of a viscoelastic bar against rigid obstacles: scenes, methods, and schemes of your own beside them.

    import viscobar

    scene = viscobar.load("examples/scenes/chatter.toml")     # or viscobar.Scene({...}), or a plain dictionary
    result = viscobar.run(scene, set={"contact.restitution": 0})
    result.ends["u_left"], result.events["t"], result.u       # NumPy arrays
    result.plot()                                             # matplotlib

    run        one scene, one method: arrays                  help(viscobar.run)
    compare    several methods and schemes of your own        orders     their orders on exact solutions
    limit      epsilon to 0: orders and a verdict             precision  time against error
    sweep      many values of the scene's keys                check      what a scene needs, predicted impacts
    open       a finished result of a directory
    fit        least squares on measured traces              ensemble   many bars: arrays in, arrays out

docs/python.md has a tutorial.
"""

from ._level import folder

__path__.insert(0, folder(__path__[0]))  # _core for this processor

from ._core import Case
from ._core import methods as _methods
from ._core import version as __version__
from ._ensemble import Ensemble, ensemble
from ._ensemble import statuses as ensemble_statuses
from ._ensemble import ways as ensemble_ways
from ._errors import Finding, IntegrationError, RunWarning, SceneError
from ._plots import plot
from ._run import Recorded, Result, open, run
from ._scene import Scene, load
from ._studies import Comparison, Fit, Judgement, Orders, Study, check, compare, fit, judge, limit, orders, precision, sweep
from ._table import Table

methods: tuple[str, ...] = tuple(_methods)
"""Names of the built-in methods."""

# Not open: `from viscobar import *` would hide Python's own.
__all__ = [
    "Case", "Comparison", "Ensemble", "Finding", "Fit", "IntegrationError", "Judgement", "Orders", "Recorded", "Result", "RunWarning", "Scene", "SceneError",
    "Study", "Table", "check", "compare", "ensemble", "ensemble_statuses", "ensemble_ways", "fit", "judge", "limit", "load", "methods", "orders", "plot", "precision", "run", "sweep",
]  # fmt: skip
