#pragma once

#include <map>
#include <optional>
#include <span>
#include <vector>

#include "studies/precision/solved.hpp"
#include "viscobar/studies/precision/precision.hpp"

namespace viscobar::precision {

/// A row to be, and the case that it is of.
struct Timed {
  Case run;
  PrecisionRow row;
};

/// The tolerances or steps of a method on its mesh, the coarsest first.
std::vector<Timed> settings_of(const PrecisionStudy& study, const Case& run);

/// Time of all timed runs together, by the clock and of the processor.
struct Spent {
  double wall = 0.0, processor = 0.0;
};

/// Times the rows one by one, until they take too long: then the others are left out.
void time_rows(const PrecisionStudy& study, std::vector<Timed>& rows, std::vector<PrecisionResult::LeftOut>& left_out,
               Spent& spent);

/// All that the errors of a study are measured against: the continuous problem, the semi-discrete problems of its rows,
/// and those that their penalties tend to.
class References {
 public:
  /// Solves them, on all cores.
  References(const PrecisionStudy& study, const Case& scene, std::span<const Mesh> meshes, std::span<const Timed> rows);

  const Continuous& continuous() const { return continuous_; }
  const Field* exact(const Case& run) const;          ///< u_* on a mesh, or null
  const Field* semi_discrete(const Case& run) const;  ///< limit of the run as its time error vanishes

  /// Space and penalty of a method on a mesh.
  ErrorParts parts(const Timed& row) const;

 private:
  const Field* field(const System& system) const;
  /// The solution that the penalised one tends to; tells the parts how that was found, and at which power of epsilon.
  std::optional<Field> penalty_limit(const System& own, const Scene& scene, ErrorParts& parts) const;

  std::map<System, SemiDiscrete> solved_;
  Continuous continuous_;
};

}  // namespace viscobar::precision
