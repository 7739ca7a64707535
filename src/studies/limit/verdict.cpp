#include "studies/limit/verdict.hpp"

#include <algorithm>
#include <cmath>

#include "case/regime.hpp"

namespace viscobar {

const double part_of_boundary = 0.01;

std::string_view name(Verdict verdict) {
  switch (verdict) {
    case Verdict::converges: return "converges";
    case Verdict::plateau: return "plateau";
    case Verdict::undecided: break;
  }
  return "undecided";
}

double largest_displacement(const EndTraces& traces) {
  double largest = 0.0;
  for (const auto* trace : EndTraces::all(traces))
    for (const double u : *trace) largest = std::max(largest, std::abs(u));
  return largest;
}

std::optional<double> LimitEvidence::lower() const {
  if (apart) return std::max(0.0, *apart - apart_error);
  if (!upper()) return std::nullopt;
  return std::max(0.0, difference - *penalty_error - *scheme_error);
}

std::optional<double> LimitEvidence::upper() const {
  if (apart) return *apart + apart_error;
  if (!penalty_error || !scheme_error) return std::nullopt;
  return difference + *penalty_error + *scheme_error;
}

namespace {

constexpr std::size_t considered = 4;  // last values of a sequence, for its order

// A contact of the scheme closes on its grid, anywhere within a step of its time, so that the differences of a few
// steps show less than all of the error's constant. The penalised traces have no grid, and their error falls faster
// while epsilon is large: two differences tell the constant where both powers are past.
constexpr Approach by_step{.order = 1.0, .values = 4, .safety = 2.0};
// A bounce lasts O(sqrt(epsilon)).
constexpr Approach by_penalty{.order = 0.5, .values = 3, .safety = 1.0};

// Share of the order in theory: a sequence of a lower order is not taken to have a limit.
constexpr double least_part_of_order = 0.25;

// P(0) = S(0) is believed where what is left is a small part of what a wrong limit would change. A law of impact either
// is the same or is not: a quarter tells. What contact does with massless nodes has no such alternative.
constexpr double part_of_law = 0.25, part_of_contact = 0.01;
// Distance to a known limit that both sequences must have reached, as a share of the stake.
constexpr double part_of_stake = 0.05;
// Share of that distance below which chatter need not fall from one value to the next.
constexpr double beyond_doubt = 0.1;
// Share of a largest difference that its times may miss: see comparison_times().
constexpr double missed_part = 0.01;

bool touches(const EndTraces& traces) { return !traces.events.empty() || traces.statistics.max_penetration > 0.0; }

double hardest_impact(const EndTraces& traces) {
  double speed = 0.0;
  for (const Event& event : traces.events)
    if (event.change == Change::closing) speed = std::max(speed, std::abs(event.velocity));
  return speed;
}

// True if bodies meet at a speed that stays as epsilon goes to 0. A node that is pressed on its obstacle oscillates at
// speeds of O(sqrt(epsilon)): half that order tells the two apart.
bool impacts(const TraceSequence& penalised) {
  const std::size_t count = penalised.x.size(), first = count - std::min<std::size_t>(3, count);
  std::vector<double> speeds;
  for (std::size_t i = first; i < count; ++i) speeds.push_back(hardest_impact(penalised.traces[i]));
  if (speeds.back() == 0.0) return false;
  const auto order = observed_order(std::span(penalised.x).subspan(first), speeds);
  return !order || order->order < 0.25;
}

// Change of the traces by contact, at most their range: without the obstacle a bar under a load may go anywhere.
double stake_of_contact(const LimitTraces& mesh) {
  const EndTraces& traces = mesh.penalised.last();
  double range = 0.0;
  for (const auto* trace : EndTraces::all(traces)) {
    const auto [least, most] = std::ranges::minmax(*trace);
    range = std::max(range, most - least);
  }
  return std::min(range, largest_difference(traces, mesh.without_obstacles()));
}

Judgement known(Verdict verdict, Judgement found) {
  found.verdict = verdict;
  found.evidence.missing = Missing::nothing;
  return found;
}

// How far the limit of a sequence may be from the one it is seen to fall to: where the distances are |C x^p + d| and
// the powers of neighbours agree to 0.06, d is a tenth of the last one at most.
double left_over(const Sequence& sequence, double theory) {
  constexpr double safe_part = 0.25;
  const auto order = sequence.order();
  const bool settles = order && order->last + 1 == sequence.x.size() && order->order >= 0.75 * theory;
  return settles ? safe_part * sequence.distance.back() : sequence.distance.back();
}

// Both limits are known, each by a run of its own: G is, and both sequences are to be seen to fall to their limit, as
// close as half the distance to the other one.
Judgement judge_known(const LimitTraces& mesh) {
  Judgement found;
  LimitEvidence& evidence = found.evidence;
  const LimitTrace &own = *mesh.own_limit, &other = *mesh.scheme_limit;
  const Sequence penalised = mesh.penalised.to(own.traces, own.error + mesh.floor),
                 scheme = mesh.scheme.to(other.traces, other.error + mesh.floor);
  const double p = penalised.distance.back(), s = scheme.distance.back();
  evidence.difference = largest_difference(mesh.penalised.last(), mesh.scheme.last());
  evidence.penalty_error = p + own.error;
  evidence.scheme_error = found.scheme_error = s + other.error;
  evidence.apart = mesh.one_limit ? 0.0 : largest_difference(own.traces, other.traces);
  evidence.apart_error = mesh.one_limit ? other.error : own.error + other.error + missed_part * *evidence.apart;
  const bool differ = *evidence.lower() > 0.0;
  if (!differ && hardest_impact(other.traces) > 0.0 && !mesh.one_limit) {
    // Two laws of impact do not lead to one limit because their difference is too small to be seen.
    evidence.missing = Missing::tighter_tolerance;
    return found;
  }
  if (!differ) evidence.stake = stake_of_contact(mesh);
  const double near = differ ? 0.5 * *evidence.apart : part_of_stake * *evidence.stake;
  if (!differ && evidence.apart_error > part_of_contact * *evidence.stake)
    evidence.missing = Missing::tighter_tolerance;
  else if (left_over(penalised, by_penalty.order) > near ||
           !(p <= beyond_doubt * near || penalised.falls(by_penalty.order)))
    evidence.missing = Missing::smaller_epsilon;
  else if (left_over(scheme, by_step.order) > near || !(s <= beyond_doubt * near || scheme.falls(by_step.order)))
    evidence.missing = Missing::smaller_step;
  else
    return known(differ ? Verdict::plateau : Verdict::converges, found);
  return found;
}

// Scheme traces from which a first power of dt is taken: T_i + (T_i - T_{i-1}) x_i / (x_{i-1} - x_i). Their limit is
// the same; what the start and the smooth part of the motion contribute to the error is gone, what the grid does to
// contact times is not.
std::vector<EndTraces> extrapolated(const TraceSequence& sequence) {
  std::vector<EndTraces> found;
  for (std::size_t i = 1; i < sequence.x.size(); ++i) {
    const EndTraces &before = sequence.traces[i - 1], &now = sequence.traces[i];
    const double share = sequence.x[i] / (sequence.x[i - 1] - sequence.x[i]);
    EndTraces& next = found.emplace_back(now);
    const auto of_next = EndTraces::all(next);
    const auto of_before = EndTraces::all(before);
    for (std::size_t trace = 0; trace < of_next.size(); ++trace)
      for (std::size_t k = 0; k < of_next[trace]->size(); ++k) {
        double& u = (*of_next[trace])[k];
        u += share * (u - (*of_before[trace])[k]);
      }
  }
  return found;
}

Judgement judge_massive(const LimitTraces& mesh, const TraceSequence& schemes) {
  Judgement found;
  LimitEvidence& evidence = found.evidence;
  evidence.difference = largest_difference(mesh.penalised.last(), schemes.last());
  const Settling scheme = settling(schemes, by_step, mesh.floor);
  found.scheme_error = scheme.error;
  if (scheme.settled) evidence.scheme_error = scheme.error;
  if (mesh.penalised.x.size() < 3) {
    evidence.missing = Missing::penalties;
    return found;
  }
  const Settling penalised = settling(mesh.penalised, by_penalty, mesh.floor);
  if (!penalised.settled) {
    const bool small = !mesh.boundary || mesh.penalised.x.back() < part_of_boundary * *mesh.boundary;
    evidence.missing = penalised.grows && small ? Missing::larger_epsilon : Missing::smaller_epsilon;
    return found;
  }
  evidence.penalty_error = penalised.error;
  evidence.missing = Missing::smaller_step;
  if (!scheme.settled) return found;
  if (*evidence.lower() > 0.0) return known(Verdict::plateau, found);
  const bool impact = impacts(mesh.penalised);
  // Two laws of impact do not lead to one limit because their difference is too small to be seen.
  if (impact && !mesh.one_law) {
    if (evidence.difference + scheme.error < penalised.error) evidence.missing = Missing::smaller_epsilon;
    return found;
  }
  // The larger error first: the other one does not help while it hides as much.
  if (scheme.error < penalised.error) evidence.missing = Missing::smaller_epsilon;
  double part = part_of_contact;
  if (impact) {
    const TraceSequence other = mesh.other_law();
    if (other.x.size() < 3) return found;
    const Settling limit = settling(other, by_penalty, mesh.floor);
    if (!limit.settled) return found;
    evidence.stake =
        std::max(0.0, largest_difference(mesh.penalised.last(), other.last()) - penalised.error - limit.error);
    evidence.by_law = true;
    part = part_of_law;
  } else {
    evidence.stake = stake_of_contact(mesh);
  }
  return *evidence.upper() <= part * *evidence.stake ? known(Verdict::converges, found) : found;
}

Judgement judge_massive(const LimitTraces& mesh) {
  Judgement as_run = judge_massive(mesh, mesh.scheme);
  if (as_run.evidence.missing != Missing::smaller_step) return as_run;
  const std::vector<EndTraces> traces = extrapolated(mesh.scheme);
  TraceSequence sequence;
  for (std::size_t i = 0; i < traces.size(); ++i) sequence.add(mesh.scheme.x[i + 1], traces[i]);
  Judgement better = judge_massive(mesh, sequence);
  if (!better.evidence.scheme_error || better.scheme_error > as_run.scheme_error) return as_run;
  better.evidence.extrapolated = true;
  better.scheme_error = as_run.scheme_error;
  return better;
}

}  // namespace

Settling settling(const TraceSequence& sequence, const Approach& approach, double floor) {
  const double order = approach.order;
  const std::size_t count = sequence.x.size(), first = count - std::min(considered, count);
  std::vector<double> x, differences;
  for (std::size_t i = first; i + 1 < count; ++i) {
    x.push_back(sequence.x[i]);
    differences.push_back(largest_difference(sequence.traces[i], sequence.traces[i + 1]));
  }
  const auto shown = observed_order(x, differences);
  const bool still = std::all_of(differences.begin(), differences.end(), [&](double d) { return d <= floor; });
  const double p = std::clamp(shown ? shown->order : order, least_part_of_order * order, order);
  const auto power = [&](std::size_t i) { return std::pow(sequence.x[i] / sequence.x.back(), p); };
  double error = 0.0;  // A x^p at the last x
  for (std::size_t i = count - std::min(approach.values, count); i < count; ++i)
    for (std::size_t j = i + 1; j < count; ++j)
      error = std::max(error, largest_difference(sequence.traces[i], sequence.traces[j]) / (power(i) - power(j)));
  const bool enough = differences.size() >= 2;
  return {.error = approach.safety * error + floor,
          .settled = enough && (still || (shown && shown->order >= least_part_of_order * order)),
          .grows = enough && !still && shown && shown->order < 0.0};
}

Sequence TraceSequence::to(const EndTraces& limit, double floor) const {
  Sequence sequence;
  for (std::size_t i = 0; i < x.size(); ++i) sequence.add(x[i], largest_difference(traces[i], limit), floor);
  return sequence;
}

Judgement judge(const LimitTraces& mesh) {
  if (mesh.penalised.x.empty() || mesh.scheme.x.empty()) {
    Judgement none;
    none.evidence.missing = Missing::runs;
    return none;
  }
  const EndTraces& penalised = mesh.penalised.last();
  const bool through = is_no_obstacle(penalised.statistics.max_penetration, largest_displacement(penalised));
  const bool limits = mesh.own_limit && mesh.scheme_limit;
  if (!through && (touches(penalised) || (limits && touches(mesh.own_limit->traces))))
    return limits ? judge_known(mesh) : judge_massive(mesh);
  Judgement found;
  found.evidence.difference = largest_difference(penalised, mesh.scheme.last());
  found.evidence.missing = through ? Missing::obstacle : Missing::contact;
  found.scheme_error = settling(mesh.scheme, by_step, mesh.floor).error;
  return found;
}

}  // namespace viscobar
