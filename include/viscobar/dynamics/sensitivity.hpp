#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "viscobar/discretisation/mesh.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// A parameter p of a scene, told by what it changes: the derivative with respect to p of all that p enters. A run that
/// is given directions (see Observers) tells the derivatives of what it tells: docs/sensitivity.md.
struct Direction {
  std::string key;              ///< name of p, such as "bar.viscosity"
  Bar bar{0.0, 0.0, 0.0, 0.0};  ///< derivatives of the bar's constants
  /// Bar and kinds of ends as those of the scene. Gaps, initial data, load, side, and what its ends are given are
  /// derivatives (motions absent where they do not depend on p), the functions of x at a fixed part x / L of the bar;
  /// of the load f it is d(L f)/dp / L. Breaks are those of the scene's.
  Scene data;
  /// Derivatives of a chain: of what its members are made of, those of joints but for the gaps, which are in `data`.
  std::vector<Member> members{};
  /// The scene at p - apart and p + apart, where integrals over its elements depend on p: of a section, or of a load
  /// along a bar that gets longer. Matrices, load and initial velocities have the difference of the two, beside all
  /// that is told above. At a fixed part of each bar both have the same functions. Their ends stand still.
  struct Beside {
    Scene before;      ///< at p - apart
    Scene after;       ///< at p + apart
    Mesh mesh_before;  ///< of `before`
    Mesh mesh_after;   ///< of `after`
    double apart;      ///< in units of p
  };
  std::optional<Beside> beside{};  ///< absent: no integral depends on p
  double epsilon = 0.0;            ///< derivative of the penalty's epsilon
  double restitution = 0.0;        ///< of the restitution
};

/// Derivatives of the fields with respect to a parameter at one output time; NaN from where there are none on.
struct FieldSensitivity {
  std::span<const double> u;           ///< of the displacement of each node of the mesh, valid during the call
  std::span<const double> v;           ///< of its velocity
  double reaction_left = 0.0;          ///< of Snapshot::reaction_left
  double reaction_right = 0.0;         ///< of Snapshot::reaction_right
  std::vector<double> joint_forces{};  ///< of Snapshot::joint_forces
};

/// Derivatives of a contact change; NaN where it has none.
struct ChangeSensitivity {
  double time = 0.0;      ///< of its time
  double velocity = 0.0;  ///< of the velocity told with it
};

/// Derivatives of the accounts of a run, an entry for each direction.
struct SensitivityAccount {
  std::vector<double> impulse_left;   ///< of the impulse on the left end, so far; NaN without an obstacle there
  std::vector<double> impulse_right;  ///< of the impulse on the right end, so far; NaN, too
  std::vector<double> energy;         ///< of the final energy
  std::optional<double> lost;         ///< from when on there are no derivatives
  std::string why;                    ///< they are lost, in words
};

}  // namespace viscobar
