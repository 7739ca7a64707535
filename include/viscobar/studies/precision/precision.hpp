#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "viscobar/case/case.hpp"
#include "viscobar/studies/accuracy/accuracy.hpp"

namespace viscobar {

/// The solution of a scene of rho u_tt - E u_xx - eta u_xxt = f, as its user knows it.
struct KnownSolution {
  std::string name;     ///< in words
  SpaceTimeFunction u;  ///< displacement
};

/// Speed against error: every method at every tolerance (adaptive methods) or step (schemes), on every mesh. Errors are
///
///     max over times t > 0 and mesh nodes of |u - u'|,
///
/// in the unit of u, at up to 2000 times: the output times and as many between them, or every n-th of them where a
/// field of many nodes would fill the memory. With u_* the solution of the continuous problem, u_h that of the
/// semi-discrete one without penalty (epsilon = 0) and u_{h,epsilon} with it, the error of a run splits as
///
///     u - u_*  =  (u - u_{h,epsilon})  +  (u_{h,epsilon} - u_h)  +  (u_h - u_*),     time + penalty + space.
///
/// u_h is the rigid limit on massless contact nodes; on nodes with mass that of the method's own law of impact: a
/// penalty at epsilon / 100, extrapolated where it falls by a power of epsilon, or a scheme at a far smaller step.
struct PrecisionStudy {
  Case scene;                         ///< scene of all runs, but for method, mesh and tolerance
  std::vector<MethodName> methods;    ///< empty: all that fit the scene, but for exponential
  std::vector<double> tolerances;     ///< relative, decreasing; the absolute ones keep their ratio to them
  std::vector<std::size_t> elements;  ///< meshes, all on the scene's epsilon; empty: the scene's
  std::size_t halvings = 9;           ///< of the schemes' step, from h / c on
  std::size_t repeat = 0;             ///< timed runs of a row, odd; 0: 3 of a long one up to 11 of a short one
  double seconds = 1.0;  ///< a run that would take longer is left out; references may take 20 times as long
  std::optional<KnownSolution> exact;  ///< absent: characteristics where they fit, else finer meshes
  std::size_t threads = 0;             ///< of references and errors; timed runs have the machine alone
  std::function<void(const std::string& what)> progress;  ///< told what is being run; may be empty
  std::function<bool()> stop;                             ///< asked after each step of each run; may be empty
};

/// One method at one tolerance or step on one mesh.
struct PrecisionRow {
  MethodName method = MethodName::cvode;  ///< which
  std::size_t elements = 0;               ///< J
  Mass mass = Mass::consistent;           ///< that the method ran on
  double setting = 0.0;                   ///< tolerance or step; 0 for exponential
  std::string label;                      ///< method and setting in words
  std::size_t steps = 0;                  ///< of one run
  double seconds = 0.0;                   ///< median of `runs`, the integration alone
  std::size_t runs = 0;                   ///< timed
  std::optional<double> error;            ///< to u_*; absent where there is no reference, or the run failed
  std::optional<double> time_error;       ///< to the exact solution of the semi-discrete system
  std::string failure;                    ///< empty for a run that did what it should
};

/// Parts of the error of a method on a mesh besides that of time.
struct ErrorParts {
  MethodName method = MethodName::cvode;  ///< which
  std::size_t elements = 0;               ///< J
  Mass mass = Mass::consistent;           ///< that it ran on
  std::optional<double> epsilon;          ///< that it ran with; absent where nothing is penalised
  std::optional<double> space;            ///< of the mesh, the semi-discrete solution to u_*
  std::optional<double> penalty;          ///< absent where nothing is penalised
  std::optional<double> penalty_order;    ///< power of epsilon over two decades; absent: not settled
  std::string penalty_against;            ///< reference for epsilon = 0, in words
  std::string time_reference;             ///< reference of the time errors, in words; empty: there is none
  double time_reference_error = 0.0;      ///< its difference to another method or to a coarser run
  std::string problem;                    ///< why a part or the reference is missing
};

/// u_*, and how good it is.
struct PrecisionReference {
  /// One mesh of a refinement.
  struct Level {
    std::size_t elements = 0;          ///< J
    std::optional<double> difference;  ///< to the next finer mesh; absent for the finest
  };
  std::string what;          ///< in words
  bool closed_form = false;  ///< a formula, of error 0, or characteristics, with the error that they tell
  double error =
      0.0;  ///< else of the finest, d / (2^p - 1) from its difference d to the one before, p the order, or 1 at most
  bool settles = true;                ///< false where the last three d grow; the error is then max |u_*| or more
  std::optional<double> order;        ///< power of h; absent: not settled (see Sequence)
  std::vector<Level> levels;          ///< the meshes that it was refined over
  double largest_displacement = 0.0;  ///< max |u_*|
};

/// Measurements of a study.
struct PrecisionResult {
  /// A run that was not made.
  struct LeftOut {
    MethodName method;     ///< which
    std::size_t elements;  ///< J
    std::string what;      ///< the tolerance or step from which on; empty: the method as a whole
    std::string reason;    ///< why
  };
  std::optional<PrecisionReference> reference;  ///< u_*
  std::string no_reference;                     ///< why there is none
  std::vector<PrecisionRow> rows;               ///< mesh by mesh, method by method, tolerance or step decreasing
  std::vector<ErrorParts> parts;                ///< one for each method on each mesh
  std::vector<LeftOut> left_out;                ///< in the order of the rows
  double core_share = 1.0;  ///< of a core that the timed runs had; less where other work kept the machine busy
  std::size_t times = 0;    ///< number of times at which errors are taken,
  double every = 0.0;       ///< and how far apart they are

  const ErrorParts& parts_of(const PrecisionRow& row) const;  ///< those of the row's method on its mesh
};

/// Runs the study: timed runs one by one, then references and errors on all cores. A run that fails is a row that says
/// so. @throws std::invalid_argument when no method fits the scene, or one that was asked for does not @throws
/// StudyStopped
PrecisionResult precision_of(const PrecisionStudy& study);

}  // namespace viscobar
