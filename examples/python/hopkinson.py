"""Three-wave analysis of a Hopkinson test by the strains of two gauges.

The gauge of the incident bar sees the incident wave e_i and, later, the reflected one e_r; that of the transmitted bar
sees e_t. A wave takes x / c to go as far as x, so that at the faces of the specimen, a pull being positive,

    v_in = c (e_r - e_i),     F_in = E A (e_i + e_r),     v_out = -c e_t,     F_out = E A e_t.

A specimen of the length l and the section A_s has the strain rate (v_out - v_in) / l, and the stress that is the mean of
those of its faces: what its inertia takes from one of them it gives to the other, but for (l / c_s)^2 / 12 of the
second derivative. Least squares over the pulse give stress = E_s strain + eta_s rate.

    viscobar run examples/scenes/hopkinson.toml --set output.every=0.005 -o hopkinson
    python3 examples/python/hopkinson.py hopkinson/gauges.csv
"""
import csv
import sys

# Of the scene: the bars (E, c and A are 1), the gauges, the faces and the length of the specimen, whose section is 1.
INCIDENT, FACE_IN, FACE_OUT, TRANSMITTED = 1.5, 2.5, 2.52, 2.6
LENGTH = FACE_OUT - FACE_IN
BEGIN, END = 1.95, 3.4  # the pulse is at the specimen, and the gauge of the incident bar sees no wave twice


def read(path):
    with open(path) as file:
        rows = [line for line in csv.DictReader(file)]
    return tuple([float(row[name]) for row in rows]
                 for name in ("t", f"strain@{INCIDENT}", f"strain@{TRANSMITTED}"))


def at(time, times, values):
    """The value at a time, linear between samples; 0 before the first."""
    if time < times[0]:
        return 0.0
    low, high = 0, len(times) - 1
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if times[middle] <= time else (low, middle)
    return values[low] + (values[high] - values[low]) * (time - times[low]) / (times[high] - times[low])


def analyse(times, incident, transmitted):
    """Lists of stress, strain and strain rate of the specimen from BEGIN to END, a sample's distance apart."""
    to_face, from_face = FACE_IN - INCIDENT, TRANSMITTED - FACE_OUT
    step = times[1] - times[0]
    stress, strain, rate = [], [0.0], []
    for k in range(round((END - BEGIN) / step)):
        t = BEGIN + k * step
        e_i, e_r = at(t - to_face, times, incident), at(t + to_face, times, incident)
        e_t = at(t + from_face, times, transmitted)
        stress.append(((e_i + e_r) + e_t) / 2)
        rate.append((-e_t - (e_r - e_i)) / LENGTH)
        if k > 0:
            strain.append(strain[-1] + step * (rate[-2] + rate[-1]) / 2)
    return stress, strain, rate


def modulus_and_viscosity(stress, strain, rate):
    """E and eta of the least squares of stress - E strain - eta rate."""
    def dot(a, b):
        return sum(x * y for x, y in zip(a, b))
    ee, er, rr = dot(strain, strain), dot(strain, rate), dot(rate, rate)
    es, rs = dot(strain, stress), dot(rate, stress)
    determinant = ee * rr - er * er
    return (rr * es - er * rs) / determinant, (ee * rs - er * es) / determinant


if __name__ == "__main__":
    modulus, viscosity = modulus_and_viscosity(*analyse(*read(sys.argv[1])))
    print(f"modulus {modulus:.4g}, viscosity {viscosity:.4g}")
