#pragma once

#include <string>

#include "hard/oracle.hpp"

namespace viscobar::hard {

/// The same motion by another method, and by how much the two may differ.
struct Reference {
  std::string label;
  Recording recording;
  double tolerance = 0.0;
};

/// - penalised, adaptive: by matrix exponentials (a finer run of another integrator on more than 60 elements), to what
///   the tolerances promise
/// - exponential: by ARKODE at a tolerance of 1e-10
/// - rigid: by ARKODE at epsilon = 1e-9 and a penetration of d: a gap wrong by d moves the bar by d, and each contact
/// change,
///   late by d / v, by 2 d more
/// - characteristics, which solves the bar itself and not its elements: by a difference scheme at Courant number 1
///   (oracle::CellWaves); each contact change, late by its step, moves the bar by a step at the largest speed, and the
///   later ones by twice that more
/// - schemes: penalised at epsilon = 1e-8 with the restitution of the scheme (rigid where the contact nodes are
///   massless), to four times the change from dt to dt/2, of which order one makes 2, and that of the reference from
///   100 epsilon to epsilon
Reference make_reference(const Trial& trial, bool measure_sensitivity);

}  // namespace viscobar::hard
