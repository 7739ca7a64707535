"""Bars of examples/scenes by Siconos: P1 elements on the consistent mass, Moreau-Jean's theta scheme with theta = 1/2,
Newton's law of impact with restitution 0, an LCP in each step, as in Siconos' own example ImpactingBar. Prints a CSV.

Needs Debian's python3-siconos. Usage: siconos_bar.py impacting-bar|rebound|bouncing STEP
"""
import sys

import numpy
from siconos.kernel import (LCP, Interaction, LagrangianLinearTIDS, LagrangianLinearTIR, MoreauJeanOSI, NewtonImpactNSL,
                            NonSmoothDynamicalSystem, TimeDiscretisation, TimeStepping)

# length, density, modulus, viscosity, gap, velocity, load, end, elements, samples
BARS = {"impacting-bar": (0.99, 7800.0, 210e9, 0.0, 5e-5, -0.1, 0.0, 1.5e-3, 99, 150),
        "rebound": (1.0, 1.0, 1.0, 0.1, 0.0, -1.0, 0.0, 2.5, 60, 125),
        "bouncing": (10.0, 1.0, 900.0, 0.0, 5.0, 0.0, -10.0, 16.0, 100, 200)}
length, density, modulus, viscosity, gap, velocity, load, end, elements, samples = BARS[sys.argv[1]]
step = float(sys.argv[2])

h = length / elements
nodes = elements + 1
mass, stretch = numpy.zeros((nodes, nodes)), numpy.zeros((nodes, nodes))
for k in range(elements):
    mass[k:k + 2, k:k + 2] += density * h / 6.0 * numpy.array([[2.0, 1.0], [1.0, 2.0]])
    stretch[k:k + 2, k:k + 2] += 1.0 / h * numpy.array([[1.0, -1.0], [-1.0, 1.0]])

bar = LagrangianLinearTIDS(numpy.zeros(nodes), numpy.full(nodes, velocity), mass, modulus * stretch, viscosity * stretch)
bar.setFExtPtr(load / density * mass.sum(axis=1))
left_end = numpy.zeros((1, nodes))
left_end[0, 0] = 1.0
contact = Interaction(NewtonImpactNSL(0.0), LagrangianLinearTIR(left_end, [gap]))
model = NonSmoothDynamicalSystem(0.0, end)
model.insertDynamicalSystem(bar)
model.link(contact, bar)
simulation = TimeStepping(model, TimeDiscretisation(0.0, step), MoreauJeanOSI(0.5), LCP())

steps = round(end / step)
each = steps // samples
print("t,u_left,v_left,reaction_left,u_right,v_right")
for k in range(1, steps + 1):
    simulation.computeOneStep()
    if k % each == 0:
        q, v = bar.q(), bar.velocity()
        reaction = contact.lambda_(1)[0] / step  # the multiplier of the velocity is the impulse of the step
        print(",".join(f"{value:.7g}" for value in (k * step, q[0], v[0], reaction, q[-1], v[-1])))
    simulation.nextStep()
