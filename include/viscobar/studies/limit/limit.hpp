#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "viscobar/case/case.hpp"
#include "viscobar/studies/accuracy/accuracy.hpp"
#include "viscobar/studies/orders/observed_order.hpp"

namespace viscobar {

/// A penalty-limit study: the penalised system at each epsilon against the fully discrete scheme on the same mass and
/// restitution, and, where there is no span obstacle, against the rigid limit on both. The scheme runs at three steps
/// first, and then at smaller ones until the verdict is known or the budget spent.
struct LimitStudy {
  Case scene;                         ///< studied by its penalised_method()
  std::vector<double> epsilons;       ///< decreasing
  std::vector<std::size_t> elements;  ///< meshes; empty: the scene's
  std::vector<double> steps;          ///< of the scheme, one for each mesh; empty: see scheme_step()
  double budget = 60.0;      ///< processor seconds for smaller steps of the scheme, >= 0; 0: only the first three
  std::size_t threads = 0;   ///< 0: all cores
  bool derivatives = false;  ///< LimitRow::local_largest has powers by d/d epsilon, where the method has derivatives
  std::function<void(std::size_t done, std::size_t of)> progress = {};  ///< told after each run, one call at a time
};

/// The power of epsilon at one epsilon in |D|, D = u_epsilon - U, by the derivative of the run. U is the rigid limit
/// where the penalised bar tends to it, else the traces at the smallest epsilon. | | is the largest over time and
/// traces, at t* of one of them, or the root of the mean square over both:
///
///     p = d log|D| / d log epsilon = epsilon du/depsilon(t*) / D(t*)     or     epsilon <D, du/depsilon> / <D, D>.
///
/// The observed power between two epsilons is the mean of p over log epsilon between them. From the mean of both ends
/// it differs by errors of p, and by |p_i - p_{i+1}| / 2 at most where p is monotone there, or by a twelfth of the
/// largest change of p over this interval and the two beside it where p is a cubic through all four rows (of equal
/// intervals).
struct LocalPower {
  double difference = 0.0;         ///< |D|
  std::optional<double> power;     ///< p; absent where the run has no derivative to its end
  double error = 0.0;              ///< of p, at most
  std::optional<double> observed;  ///< power between this row and the next of its mesh
  std::optional<double> mean;      ///< of p at both
  double bound = 0.0;  ///< of |observed - mean|: the largest change of p over these three intervals, and the errors

  /// Whether observed and mean agree; absent where there are not both.
  std::optional<bool> agrees() const;
};

/// One penalised run of a study, beside the limits of its mesh.
struct LimitRow {
  double epsilon = 0.0;                          ///< reaction = penetration / epsilon
  std::size_t elements = 0;                      ///< J
  Mass mass = Mass::consistent;                  ///< that it ran on
  std::size_t events = 0;                        ///< contact changes
  double max_penetration = 0.0;                  ///< max over time and contacts, >= 0
  double difference_to_scheme = 0.0;             ///< max over comparison_times() and ends of |u - u_scheme|
  std::optional<double> difference_to_rigid;     ///< likewise
  std::size_t steps = 0;                         ///< of the integrator
  double seconds = 0.0;                          ///< of the integration alone
  std::optional<LocalPower> local_largest = {};  ///< where asked for, and |D| above the error of the time integration
  std::optional<LocalPower> local_mean = {};     ///< likewise, of the mean square
};

/// A penalised run that could not be finished.
struct FailedRun {
  double epsilon = 0.0;      ///< of the run
  std::size_t elements = 0;  ///< J
  std::string what;          ///< the error's message
};

/// Whether P(0) = S(0): P(epsilon) the end traces of the penalised system, S(dt) those of the scheme on the same mesh.
enum class Verdict {
  converges,  ///< P(0) and S(0) agree to a small part of what is at stake, LimitEvidence::stake
  plateau,    ///< they differ by more than all uncertainties
  undecided   ///< the runs do not tell; LimitEvidence::lack says what would
};
std::string_view name(Verdict verdict);  ///< as in JSON

/// What an undecided verdict lacks.
enum class Lack {
  nothing,          ///< the verdict is known
  obstacle,         ///< the bar goes through it: a penetration of a tenth of max|u| or more at the smallest epsilon
  contact,          ///< nothing touches an obstacle at the smallest epsilon: there is nothing to compare
  penalties,        ///< three epsilons or more, to see whether P(epsilon) settles
  smaller_epsilon,  ///< P(epsilon) has not settled, or not closely enough
  larger_epsilon,   ///< P(epsilon) changes more and more as epsilon falls: errors of the time integration, or chaos
  smaller_step      ///< S(dt) has not settled, or not closely enough, within the budget
};

/// What the runs of one mesh tell of |P(0) - S(0)|, | | the largest over time and both ends:
///
///     | |P(0) - S(0)| - |P(epsilon) - S(dt)| |  <=  |P(epsilon) - P(0)| + |S(dt) - S(0)|
///
/// Each term on the right is measured: against the rigid limit where there is one, else by three values or more of
/// epsilon and of dt that show an order.
struct LimitEvidence {
  double difference = 0.0;              ///< |P(epsilon) - S(dt)| at the smallest of both
  std::optional<double> penalty_error;  ///< |P(epsilon) - P(0)| at most; absent: not settled
  std::optional<double> scheme_error;   ///< |S(dt) - S(0)| at most; absent: not settled
  bool extrapolated = false;            ///< whether S(dt) has lost its error of first order in dt, by two steps
  /// What a wrong limit would change: between massive nodes that share one law of impact what another restitution does,
  /// else what contact itself does, and no more than the ends move. Absent where the verdict does not depend on it.
  std::optional<double> stake;
  bool by_law = false;        ///< whether the stake is that of another restitution
  Lack lack = Lack::nothing;  ///< of an undecided verdict

  /// Bounds of |P(0) - S(0)|; absent where a term is.
  std::optional<double> lower() const;
  std::optional<double> upper() const;  ///< likewise
};

/// A run of the scheme in a study.
struct SchemeRun {
  double step = 0.0;       ///< dt
  double change = 0.0;     ///< |S(dt) - S| to the one before it; 0 for the first
  std::size_t events = 0;  ///< contact changes
  double seconds = 0.0;    ///< that it took
};

/// What the rows of one mesh say.
struct LimitOrders {
  std::size_t elements = 0;       ///< J
  std::size_t first_row = 0;      ///< index of the mesh's first row in LimitResult::rows
  std::size_t row_count = 0;      ///< and how many there are
  double scheme_step = 0.0;       ///< smallest dt of the scheme, that of LimitRow::difference_to_scheme
  double scheme_error = 0.0;      ///< of the scheme's end traces by this step, estimated also where not settled
  std::size_t scheme_events = 0;  ///< contact changes of the scheme at this step
  std::vector<SchemeRun> scheme;  ///< its runs, dt decreasing
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
  bool local_to_rigid = false;                  ///< whether U of LocalPower is the rigid limit
  Verdict verdict = Verdict::undecided;         ///< on this mesh
  LimitEvidence evidence;                       ///< that it rests on
};

/// What a study found.
struct LimitResult {
  std::vector<LimitRow> rows;       ///< mesh by mesh, epsilon decreasing
  std::vector<LimitOrders> orders;  ///< one for each mesh
  std::vector<FailedRun> failed;    ///< runs that are not among the rows
};

/// epsilon from `first` down to `last`, `per_decade` values a decade.
std::vector<double> decades(double first, double last, std::size_t per_decade = 1);

/// 1e-2 to 1e-8 times natural_epsilon(): what a study has that names no penalties.
std::vector<double> natural_penalties(const Scene& scene, std::size_t per_decade = 1);

/// Runs the study, independent runs on all cores. The tolerance is the scene's, but at most 1e-10. The scheme starts
/// at steps 10^(2/3), 10^(1/3) and 1 times the given one: a contact closes on its grid, and halved steps would put it
/// at the same time as often as not.
/// A penalised run that fails is listed and leaves the others standing.
/// @throws IntegrationError (the scheme, the rigid limit, or every penalised run of a mesh failed),
///         std::invalid_argument (the scene has no obstacle, or a run of it is not sound)
LimitResult limit_of(const LimitStudy& study);

/// What the penalised runs of a study tend to, epsilon = 0, solved to an error: the rigid limit on the mass that the
/// partners have in common, or scheme (2.8) where there is none (a span obstacle). The mesh that it takes is one for
/// the whole study: contact is hardest at epsilon = 0.
/// @throws as solve()
AccuracyResult limit_to_accuracy(const LimitStudy& study, const AccuracyRequest& request);

}  // namespace viscobar
