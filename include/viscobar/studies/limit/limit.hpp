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

struct LimitRow;

/// A penalty-limit study: the penalised system at each epsilon against the fully discrete scheme on the same mass and
/// restitution, and both against their limits where `rigid` knows these. It goes on by itself, with smaller penalties,
/// smaller steps of the scheme and tighter tolerances, until the verdict is known or the budget spent.
struct LimitStudy {
  Case scene;                    ///< studied by its penalised_method()
  std::vector<double> epsilons;  ///< decreasing
  /// Meshes; empty: the scene's. Those of bars in line that are multiples of the coarsest refine all bars by one
  /// factor.
  std::vector<std::size_t> elements;
  std::vector<double> steps;  ///< of the scheme, one for each mesh; empty: see resolve()
  /// Processor seconds of all runs together, >= 0. No run begins that would overrun it by what it is expected to take;
  /// one that does is stopped and left out. 0: only the penalties asked for and three steps, however long they take.
  double budget = 60.0;
  std::size_t threads = 0;                     ///< 0: all cores
  std::optional<ErrorEstimate> estimate = {};  ///< of the mesh, where limit_to_accuracy() has chosen it
  std::function<void(std::size_t done, std::size_t of)> progress = {};  ///< told after each run, one call at a time
  std::function<void(const LimitRow&)> row = {};  ///< told each row as it is made, likewise; difference_to_scheme is 0
  std::function<bool()> interrupted = {};         ///< true to stop: the runs so far are judged
};

/// One penalised run of a study, beside the limits of its mesh.
struct LimitRow {
  double epsilon = 0.0;          ///< reaction = penetration / epsilon
  std::size_t elements = 0;      ///< J
  Mass mass = Mass::consistent;  ///< that it ran on
  double tolerance = 0.0;        ///< relative, that it ran with
  std::size_t events = 0;        ///< contact changes
  double max_penetration = 0.0;  ///< max over time and contacts, >= 0
  /// max over comparison_times() and traces of |u - u_scheme|, at the smallest step
  double difference_to_scheme = 0.0;
  std::optional<double> difference_to_own_limit;     ///< to P(0)
  std::optional<double> difference_to_scheme_limit;  ///< to S(0): `rigid` with the scene's restitution, or 0
  std::size_t steps = 0;                             ///< of the integrator
  double seconds = 0.0;                              ///< of the integration alone
};

/// A penalised run that could not be finished.
struct FailedRun {
  double epsilon = 0.0;      ///< of the run
  std::size_t elements = 0;  ///< J
  std::string what;          ///< the error's message
};

/// Answer to the question P(0) = S(0): P(epsilon) the end traces of the penalised system, S(dt) those of the scheme on
/// the same mesh.
enum class Verdict {
  converges,  ///< P(0) and S(0) are one, and both sequences are seen to tend there
  plateau,    ///< they differ by more than all uncertainties
  undecided   ///< the runs do not tell; LimitEvidence::missing says what would
};
std::string_view name(Verdict verdict);  ///< as in JSON

/// Evidence that an undecided verdict lacks.
enum class Missing {
  nothing,           ///< the verdict is known
  obstacle,          ///< the bar goes through it: a penetration of a tenth of max|u| or more at the smallest epsilon
  contact,           ///< nothing touches an obstacle at the smallest epsilon: there is nothing to compare
  runs,              ///< of the penalised system or the scheme: the budget allowed none
  penalties,         ///< three epsilons or more, to see whether P(epsilon) settles
  smaller_epsilon,   ///< P(epsilon) has not settled, or not closely enough
  larger_epsilon,    ///< P(epsilon) changes more and more as epsilon falls: errors of the time integration, or chaos
  smaller_step,      ///< S(dt) has not settled, or not closely enough
  tighter_tolerance  ///< the limits are not known closely enough
};

/// Evidence of one mesh on G = |P(0) - S(0)|, | | the largest over time and traces. `rigid` knows S(0) of end
/// obstacles, on any mass, and P(0): the same motion of massless nodes and of a restitution that both share, and that
/// of restitution 1 of nodes with mass on an undamped spring. Then G is known to the errors of two runs, and P and S
/// are to be seen to fall to their limits. Elsewhere
///
///     | G - |P(epsilon) - S(dt)| |  <=  |P(epsilon) - P(0)| + |S(dt) - S(0)|,
///
/// each term on the right by three values or more of epsilon and of dt that show an order.
struct LimitEvidence {
  double difference = 0.0;              ///< |P(epsilon) - S(dt)| at the smallest of both
  std::optional<double> penalty_error;  ///< |P(epsilon) - P(0)| at most; absent: not settled
  std::optional<double> scheme_error;   ///< |S(dt) - S(0)| at most; absent: not settled
  std::optional<double> apart;          ///< G, where both limits are known
  double apart_error = 0.0;             ///< of it, at most
  bool extrapolated = false;            ///< true if two steps remove the error of first order in dt from S(dt)
  /// Change of the traces by a wrong limit, at most as far as the ends move: that by another restitution for massive
  /// nodes that share one law of impact under a span, else that by contact itself. Absent where the verdict does not
  /// depend on it.
  std::optional<double> stake;
  bool by_law = false;            ///< true if the stake is that of another restitution
  std::optional<double> until{};  ///< the verdict is that of the time up to there, where less than the run tells it
  Missing missing = Missing::nothing;  ///< of an undecided verdict

  /// Bounds of |P(0) - S(0)|; absent where a term is.
  std::optional<double> lower() const;
  std::optional<double> upper() const;  ///< upper bound
};

/// A run of the scheme in a study.
struct SchemeRun {
  double step = 0.0;                ///< dt
  double change = 0.0;              ///< |S(dt) - S| to the one before it; 0 for the first
  std::optional<double> distance;   ///< |S(dt) - S(0)|, where that is known
  std::size_t events = 0;           ///< contact changes
  double seconds = 0.0;             ///< that it took
  std::vector<double> differences;  ///< of the rows of its mesh to it
};

/// Orders and verdict of one mesh, from its rows.
struct LimitOrders {
  std::size_t elements = 0;       ///< J
  std::size_t first_row = 0;      ///< index of the mesh's first row in LimitResult::rows
  std::size_t row_count = 0;      ///< and how many there are
  double scheme_step = 0.0;       ///< smallest dt of the scheme, that of LimitRow::difference_to_scheme
  double scheme_error = 0.0;      ///< of the scheme's end traces by this step, estimated also where not settled
  std::size_t scheme_events = 0;  ///< contact changes of the scheme at this step
  std::vector<SchemeRun> scheme;  ///< its runs, dt decreasing
  double tolerance_error = 0.0;   ///< largest contribution of the time integration to a difference
  double tolerance = 0.0;         ///< relative, of the penalised runs
  double largest = 0.0;           ///< max |u| of the traces
  /// epsilon = rho h^3 / (A eta^2), where the two powers of the penetration meet; under a span obstacle
  /// rho h^4 / (A eta^2), below which a node has come to rest before viscosity drags it along with its neighbours
  std::optional<double> boundary;
  /// Powers of epsilon as epsilon goes to 0, where they settle (see Sequence).
  std::optional<SequenceOrder> penetration;
  std::optional<SequenceOrder> to_scheme;        ///< of difference_to_scheme
  std::optional<SequenceOrder> to_own_limit;     ///< of difference_to_own_limit
  std::optional<SequenceOrder> to_scheme_limit;  ///< of difference_to_scheme_limit
  std::optional<SequenceOrder> of_step;          ///< the power of dt in the scheme's distances to its limit
  /// Where the mesh resolves the contact layer: of a settled range whose middle lies above the boundary, before
  /// another.
  std::optional<SequenceOrder> penetration_layer;
  std::optional<SequenceOrder> to_scheme_limit_layer;  ///< of difference_to_scheme_limit there
  Verdict verdict = Verdict::undecided;                ///< on this mesh
  LimitEvidence evidence;                              ///< that it rests on
  bool interrupted = false;                            ///< from outside
  double seconds = 0.0;                                ///< of the processor, of the study so far
  std::optional<double> lacking_seconds;  ///< that the next run would have taken, more than the budget had left
};

/// The limits on a sequence of meshes against the bar's own motion, that of the fourth-order mass on twice the finest
/// mesh or a finer one, or of `characteristics` without viscosity.
struct OwnMotion {
  /// A mesh of the study.
  struct Mesh {
    std::size_t elements = 0;       ///< J
    double spacing = 0.0;           ///< h
    double penalty = 0.0;           ///< |P(0) - u|, u the bar's own motion
    double scheme = 0.0;            ///< |S(0) - u|
    double apart = 0.0;             ///< |P(0) - S(0)|
    std::optional<double> epsilon;  ///< at which |P(epsilon) - P(0)| is as large; absent: outside the rows
    std::optional<double> step;     ///< at which |S(dt) - S(0)| is as large; absent: outside the runs
  };
  std::vector<Mesh> meshes;              ///< from coarse to fine
  std::optional<SequenceOrder> penalty;  ///< power of h of Mesh::penalty; absent: not settled
  std::optional<SequenceOrder> scheme;   ///< the same of Mesh::scheme
  std::optional<SequenceOrder> apart;    ///< the same of Mesh::apart, the plateau
  std::string reference;                 ///< source of u, in words
  double error = 0.0;                    ///< of u, by half as many elements
};

/// The result of a study.
struct LimitResult {
  std::vector<LimitRow> rows;           ///< mesh by mesh, epsilon decreasing
  std::vector<LimitOrders> orders;      ///< one for each mesh
  std::vector<FailedRun> failed;        ///< runs that are not among the rows
  std::optional<OwnMotion> own_motion;  ///< of three meshes or more, whose limits are known
  std::vector<double> left_out;         ///< epsilons asked for, whose runs the budget did not allow or stopped
};

/// epsilon from `first` down to `last`, `per_decade` values a decade.
std::vector<double> decades(double first, double last, std::size_t per_decade = 1);

/// 1e-2 to 1e-8 times natural_epsilon(): what a study has that names no penalties.
std::vector<double> natural_penalties(const Scene& scene, std::size_t per_decade = 1);

/// Why a scene has no penalty limit: nothing to touch, or a stop with a law of its own, whose key it names. Absent: it
/// has one.
std::optional<Finding> limit_fault(const Scene& scene);

/// Runs the study, independent runs on all cores. The tolerance is the scene's, but at most 1e-10 where that costs
/// little of the budget. The scheme starts at steps 10^(2/3), 10^(1/3) and 1 times the given one: a contact closes on
/// its grid, and halved steps would put it at the same time as often as not.
/// A penalised run that fails is listed and leaves the others standing.
/// @throws IntegrationError (the scheme, the rigid limit, or every penalised run of a mesh failed),
///         std::invalid_argument (the scene has no obstacle, or a run of it is not sound)
LimitResult limit_of(const LimitStudy& study);

/// Limit epsilon = 0 of the penalised runs of a study, solved to an error: the rigid limit on the mass that the
/// partners have in common, or scheme (2.8) where there is none (a span obstacle). The mesh that it takes is one for
/// the whole study: contact is hardest at epsilon = 0.
/// @throws as solve()
AccuracyResult limit_to_accuracy(const LimitStudy& study, const AccuracyRequest& request);

}  // namespace viscobar
