"""Bars of examples/scenes by GetFEM: P1 elements, the midpoint rule, contact by Nitsche's method (its variant theta = 0)
or by a penalty, as in GetFEM's own demo_dynamic_contact_1D. A step is half a cell. Prints a CSV.

Needs Debian's python3-getfem. Usage: getfem_bar.py period-3|rebound nitsche|penalty STEP
"""
import sys

import getfem
import numpy

# viscosity, right end held, u_0(x), u_1, end
BARS = {"period-3": (0.0, True, lambda x: (1.0 - x) / 2.0, 0.0, 6.0),
        "rebound": (0.1, False, lambda x: 0.0 * x, -1.0, 2.5)}
viscosity, held, displacement, velocity, end = BARS[sys.argv[1]]
contact, step, samples = sys.argv[2], float(sys.argv[3]), 150 if sys.argv[1] == "period-3" else 125
elements = round(1.0 / (2.0 * step))

getfem.util_trace_level(0)
mesh = getfem.Mesh("cartesian", numpy.linspace(0.0, 1.0, elements + 1))
mesh.set_region(1, mesh.outer_faces_with_direction([-1.0], 0.1))
mesh.set_region(2, mesh.outer_faces_with_direction([1.0], 0.1))
basis = getfem.MeshFem(mesh, 1)
basis.set_classical_fem(1)
integral = getfem.MeshIm(mesh, 2)
x = basis.basic_dof_nodes()[0]
left, right = numpy.argmin(x), numpy.argmax(x)

model = getfem.Model("real")
model.add_fem_variable("u", basis)  # in the middle of a step
model.add_fem_data("u0", basis)     # at its beginning
model.add_fem_data("v0", basis)
model.add_initialized_data("dt", step)
model.add_initialized_data("eta", viscosity)
stress = "(Grad_u + 2*eta/dt*(Grad_u - Grad_u0))"
model.add_linear_term(integral, f"(4/sqr(dt)*(u - u0) - 2/dt*v0)*Test_u + {stress}.Grad_Test_u")
# The reaction; g is a stiffness.
if contact == "nitsche":
    model.add_initialized_data("g", (1.0 + 2.0 * viscosity / step) * elements)
    reaction = f"pos_part(-{stress}(1) - g*u)"
else:
    model.add_initialized_data("g", 20.0 * elements)
    reaction = "pos_part(-g*u)"
model.add_nonlinear_term(integral, f"-{reaction}*Test_u", 1)
if held:
    model.add_Dirichlet_condition_with_multipliers(integral, "u", 1, 2)

u, v = displacement(x), numpy.full(elements + 1, velocity)
steps = round(end / step)
each = steps // samples
print("t,u_left,v_left,reaction_left" + ("" if held else ",u_right,v_right"))
for k in range(1, steps + 1):
    model.set_variable("u0", u)
    model.set_variable("v0", v)
    model.set_variable("u", u + step / 2.0 * v)
    model.solve("lsolver", "mumps", "max_res", 1e-10, "max_iter", 50)
    middle = model.variable("u")
    force = getfem.asm("generic", integral, 0, reaction, 1, model)  # in the middle of the step
    u, v = 2.0 * middle - u, 4.0 / step * (middle - u) - v
    if k % each == 0:
        row = [k * step, u[left], v[left], force] + ([] if held else [u[right], v[right]])
        print(",".join(f"{value:.7g}" for value in row))
