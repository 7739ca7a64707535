"""Runs GetFEM's own demo_dynamic_contact_1D.py with the settings that are given, and prints its relative error of u in
L^infinity(0, T; L^2). Its linear systems are solved by SciPy's SuperLU: that of GetFEM 5.4.2 ended in a segmentation
fault.

Usage: run_getfem.py demo_dynamic_contact_1D.py NX=20 version=3
"""
import contextlib
import io
import re
import runpy
import sys

import getfem
import numpy
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import spsolve


def solve(matrix, right):
    pointers, rows = matrix.csc_ind()
    sparse = csc_matrix((matrix.csc_val(), rows, pointers), shape=matrix.size())
    return numpy.atleast_2d(spsolve(sparse, right)).T, 1.0


getfem.linsolve_superlu = solve
sys.argv = sys.argv[1:] + ["do_final_plot=False"]
printed = io.StringIO()
with contextlib.redirect_stdout(printed):
    runpy.run_path(sys.argv[0], run_name="__main__")
print(re.search(r"0,T,L\^2\)-norm of the error on u:\s*(\S+)", printed.getvalue()).group(1))
