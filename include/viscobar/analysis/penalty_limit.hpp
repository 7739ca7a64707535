#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "viscobar/analysis/case.hpp"
#include "viscobar/analysis/observed_order.hpp"

namespace viscobar {

/// A penalty-limit study: the penalised system at each epsilon against the fully discrete scheme on the same mass and
/// restitution, and, where the mass has massless contact nodes, against the rigid limit.
struct LimitStudy {
  Case scene;                         ///< studied by its penalised_method()
  std::vector<double> epsilons;       ///< decreasing
  std::vector<std::size_t> elements;  ///< meshes; empty: the scene's
  std::vector<double> steps;          ///< of the scheme, one for each mesh; empty: see scheme_step()
  std::size_t threads = 0;            ///< 0: all cores
  std::function<void(std::size_t done, std::size_t of)> progress = {};  ///< told after each run, one call at a time
};

/// One penalised run of a study, beside the limits of its mesh.
struct LimitRow {
  double epsilon = 0.0;                       ///< reaction = penetration / epsilon
  std::size_t elements = 0;                   ///< J
  Mass mass = Mass::consistent;               ///< that it ran on
  std::size_t events = 0;                     ///< contact changes
  double max_penetration = 0.0;               ///< max over time and contacts, >= 0
  double difference_to_scheme = 0.0;          ///< max over comparison_times() and ends of |u - u_scheme|
  std::optional<double> difference_to_rigid;  ///< likewise
  std::size_t steps = 0;                      ///< of the integrator
  double seconds = 0.0;                       ///< of the integration alone
};

/// A penalised run that could not be finished.
struct FailedRun {
  double epsilon = 0.0;      ///< of the run
  std::size_t elements = 0;  ///< J
  std::string what;          ///< the error's message
};

/// Whether the penalised bar tends to the scheme as epsilon goes to 0.
enum class Verdict {
  converges,  ///< the difference falls with epsilon down to the error of the scheme's own time step
  plateau     ///< it stops falling above that
};
std::string_view name(Verdict verdict);  ///< as in JSON

/// What the rows of one mesh say.
struct LimitOrders {
  std::size_t elements = 0;       ///< J
  std::size_t first_row = 0;      ///< index of the mesh's first row in LimitResult::rows
  std::size_t row_count = 0;      ///< and how many there are
  double scheme_step = 0.0;       ///< dt of the scheme
  double scheme_error = 0.0;      ///< of the scheme's end traces by its time step: twice the change when dt is halved
  std::size_t scheme_events = 0;  ///< contact changes of the scheme
  double tolerance_error = 0.0;   ///< what the time integration may add to a difference
  /// epsilon = rho h^3 / eta^2, where the two powers of the penetration meet; under a span obstacle rho h^4 / eta^2,
  /// below which a node has come to rest before viscosity drags it along with its neighbours
  std::optional<double> boundary;
  /// Powers of epsilon over the last two decades above the floor, where they are closest to their limits: in the regime
  /// of small epsilon, below boundary / 100, where the node alone answers; of all rows when fewer than two lie there.
  std::optional<ObservedOrder> penetration;
  std::optional<ObservedOrder> to_rigid;   ///< likewise, of difference_to_rigid
  std::optional<ObservedOrder> to_scheme;  ///< likewise, of difference_to_scheme
  /// Where the mesh resolves the contact layer, epsilon > 100 boundary.
  std::optional<ObservedOrder> penetration_layer;
  std::optional<ObservedOrder> to_rigid_layer;  ///< likewise
  std::optional<Verdict> verdict;               ///< absent where one epsilon alone is above the scheme's own error
};

/// What a study found.
struct LimitResult {
  std::vector<LimitRow> rows;       ///< mesh by mesh, epsilon decreasing
  std::vector<LimitOrders> orders;  ///< one for each mesh
  std::vector<FailedRun> failed;    ///< runs that are not among the rows
};

/// epsilon from `first` down to `last`, `per_decade` values a decade.
std::vector<double> decades(double first, double last, std::size_t per_decade = 1);

/// The step of the scheme that a study of this case takes when none is given: the scene's, or h / (100 c).
double scheme_step(const Case& run);

/// Runs the study, independent runs on all cores. The tolerance is the scene's, but at most 1e-10.
/// A penalised run that fails is listed and leaves the others standing.
/// @throws IntegrationError (the scheme, the rigid limit, or every penalised run of a mesh failed),
///         std::invalid_argument (the scene has no obstacle, or a run of it is not sound)
LimitResult penalty_limit(const LimitStudy& study);

}  // namespace viscobar
