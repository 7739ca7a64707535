#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "viscobar/studies/limit/limit.hpp"

namespace viscobar {

/// epsilon(h) at which the penalty's difference to its limit is as large as the error of the mesh: a smaller epsilon
/// gains nothing, a larger one spoils the mesh.
///
/// The mesh error K h^q of the end traces is read off the limits on the three finest meshes: neighbours differ by
/// K |h_i^q - h_{i+1}^q|. The difference of the penalised solution is interpolated between the rows of a study, on
/// logarithmic axes.
struct Coupling {
  /// A mesh of the study.
  struct Mesh {
    std::size_t elements = 0;       ///< J
    double spacing = 0.0;           ///< h
    double mesh_error = 0.0;        ///< K h^q
    std::optional<double> epsilon;  ///< absent where the study's rows do not enclose the mesh error
    double local_order = 0.0;       ///< of the difference in epsilon there, when epsilon is present
  };
  std::vector<Mesh> meshes;          ///< from coarse to fine
  double mesh_order = 0.0;           ///< q
  std::optional<ObservedOrder> law;  ///< epsilon ~ h^s over the meshes
  std::string limit;                 ///< reference of the differences: "rigid" or "scheme"
};

/// Absent when the data do not carry it, with the reason.
struct CouplingResult {
  std::optional<Coupling> coupling;  ///< the balance
  std::string reason;                ///< why there is none; empty when there is one
};

/// Runs the limit of each mesh once more, within the budget of the study, and balances. `result` is that of the study.
CouplingResult balance_errors(const LimitStudy& study, const LimitResult& result);

/// q and K with difference[i] = K (h[i]^q - h[i+1]^q) for the last two of them and decreasing h; absent for fewer than
/// two differences or when q is not in 0.1 ... 4.
struct MeshError {
  double order = 0.0;     ///< q
  double constant = 0.0;  ///< K
};
/// `spacings` has one entry more than `differences`.
std::optional<MeshError> mesh_error(const std::vector<double>& spacings, const std::vector<double>& differences);

}  // namespace viscobar
