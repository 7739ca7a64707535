#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "viscobar/case/end_traces.hpp"
#include "viscobar/studies/limit/limit.hpp"

namespace viscobar {

/// Share of the boundary of the regimes below which a penalty counts as small.
extern const double part_of_boundary;

using TracesRef = std::reference_wrapper<const EndTraces>;

/// End traces T(x) on common times, x a penalty or a step, decreasing.
struct TraceSequence {
  std::vector<double> x;
  std::vector<TracesRef> traces;

  void add(double at, const EndTraces& value) {
    x.push_back(at);
    traces.push_back(value);
  }
  const EndTraces& last() const { return traces.back(); }
  /// |T(x) - limit|, each with that floor.
  Sequence to(const EndTraces& limit, double floor) const;
};

/// |T(x) - T(0)| at the smallest x.
struct Settling {
  double error = 0.0;
  bool settled = false;  ///< true if the values show that T(x) has a limit
  bool grows = false;    ///< true if its differences grow as x falls
};

/// How a sequence tends to its limit.
struct Approach {
  double order;        ///< that theory has
  std::size_t values;  ///< last ones that tell the constant
  double safety;       ///< the constant's, over the largest that they show
};

/// |T(x) - T(0)| <= A x^p, A the largest |T(x_i) - T(x_j)| / (x_i^p - x_j^p) of the last values times their safety, p
/// the order that the last three differences of neighbours show, but not more than the theory's. Settled with three
/// values or more and at least a quarter of that order. Differences below `floor` are those of the time integration.
Settling settling(const TraceSequence& sequence, const Approach& approach, double floor);

/// A limit that is known by a run of its own, to an error.
struct LimitTrace {
  TracesRef traces;
  double error = 0.0;
};

/// The traces of one mesh, and what is run only where a verdict needs it.
struct LimitTraces {
  TraceSequence penalised;                   ///< over epsilon
  TraceSequence scheme;                      ///< over dt
  std::optional<LimitTrace> own_limit;       ///< P(0)
  std::optional<LimitTrace> scheme_limit;    ///< S(0)
  bool one_limit = false;                    ///< by theory they are one motion
  bool one_law = false;                      ///< massive contact nodes have one law of impact in penalty and scheme
  std::optional<double> boundary;            ///< of epsilon, above which P tells nothing of P(0)
  double floor = 0.0;                        ///< error of the time integration in a difference
  std::function<TraceSequence()> other_law;  ///< the last penalised traces, with another restitution
  std::function<const EndTraces&()> without_obstacles;  ///< the penalised traces of the bar that touches nothing
};

struct Judgement {
  Verdict verdict = Verdict::undecided;
  LimitEvidence evidence;
  double scheme_error = 0.0;  ///< estimated also where not settled
};

Judgement judge(const LimitTraces& mesh);

/// max over time and traces of |u|.
double largest_displacement(const EndTraces& traces);

}  // namespace viscobar
