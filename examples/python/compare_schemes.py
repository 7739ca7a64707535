"""Two schemes of one's own (newmark.py, nitsche.py) beside built-in methods, on two bars with known answers.

 1. A viscoelastic bar, rho = E = L = eta = 1, thrown at speed 1 at an obstacle that it touches at t = 0. In Laplace space the
    reaction is sqrt(1+s)/s tanh(s/sqrt(1+s)); contact ends at 1.3692116746, the speed of rebound is 0.1503140958.
 2. The period-3 bar of Dabaghi, Petrov, Pousin and Renard (examples/scenes/period-3.toml): contact from 1 to 2 and from 4 to
    5, reaction 1/2.

Run: PYTHONPATH=build/release/python /usr/bin/python3 examples/python/compare_schemes.py
"""
import pathlib

import viscobar
from newmark import newmark
from nitsche import nitsche

CONTACT_TIME, REBOUND = 1.3692116746, 0.1503140958
rebound = viscobar.Scene(
    title="Rebound of a Kelvin-Voigt bar",
    bar={"length": 1.0, "viscosity": 1.0},
    left={"kind": "obstacle", "gap": 0.0},
    initial={"displacement": 0.0, "velocity": -1.0},
    time={"end": 2.0},
    mesh={"elements": 50},
    contact={"epsilon": 1e-5},
    method={"name": "rigid", "step": 1e-3},
    output={"every": 0.01},
)
period_3 = pathlib.Path(__file__).parents[1] / "scenes" / "period-3.toml"


def rows():
    """Contact time and rebound of each, beside the exact ones."""
    table = viscobar.compare(rebound, ["rigid", "arkode", newmark, nitsche])
    for run in table.summary["methods"]:
        (contact,) = [one for one in run["contacts"] if one["end"] < 1.9]
        duration, speed = contact["end"] - contact["begin"], contact["impulse"] - 1.0
        yield {"method": run["method"], "contact time": duration, "its error": duration - CONTACT_TIME,
               "rebound": speed, "error of it": speed - REBOUND}


if __name__ == "__main__":
    print("Rebound\n", viscobar.Table(rows()), sep="")
    comparison = viscobar.compare(period_3, ["rigid", "fully_discrete", newmark, nitsche], set={"mesh.elements": 50})
    print("\nPeriod-3 bar, differences to rigid\n", comparison, "\n\nIts contacts\n", comparison.contacts, sep="")
    for scheme in (newmark, nitsche, "fully_discrete"):
        orders = viscobar.orders(scheme, period_3, levels=4, set={"mesh.elements": 20, "method.step": 0.01})
        print(f"\n{getattr(scheme, '__name__', scheme)}, h and dt halved\n{orders}\norders {orders.order}")
