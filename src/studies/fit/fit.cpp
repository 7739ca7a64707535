#include "viscobar/studies/fit/fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "discretisation/dense.hpp"
#include "studies/fit/judgement.hpp"
#include "studies/fit/noise.hpp"
#include "studies/fit/search.hpp"

namespace viscobar {

using namespace fitting;

namespace {

// Standard deviations of the parameters, as far as S is quadratic.
Eigen::VectorXd deviations(const Misfit& misfit) {
  const Eigen::MatrixXd covariance = inverse(misfit.jacobian.transpose() * misfit.jacobian);
  return (misfit.variance(covariance.rows()) * covariance.diagonal()).cwiseSqrt();
}

// So many times as large or small as where it begins a parameter is looked for.
constexpr double far_off = 10.0;

// A parameter that the data hardly know, far from where it begins, seldom is that of the best minimum.
bool runs_away(const FitStudy& study, const Eigen::VectorXd& values, const Misfit& misfit) {
  const Eigen::VectorXd deviation = deviations(misfit);
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    const double start = study.parameters[k].start, ratio = std::abs(values(k) / start);
    const bool known = deviation(k) < std::abs(values(k));
    if (start != 0.0 && !known && (ratio > far_off || ratio < 1.0 / far_off)) return true;
  }
  return false;
}

// True if what samples beside contact changes are forgiven leaves nothing that tells a parameter.
bool jumps_alone_tell(const Minimum& at) {
  return at.compared == Compared::samples &&
         (at.misfit.jacobian.colwise().norm().transpose().array() * at.at.array().abs() < 1.0).any();
}

void check(const FitStudy& study) {
  const auto require = [](bool holds, const std::string& what) {
    if (!holds) throw std::invalid_argument("fit: " + what);
  };
  require(!study.parameters.empty(), "there is no parameter to look for");
  require(!study.traces.empty() || !study.changes.empty(), "there are no data");
  for (const FittedParameter& parameter : study.parameters) {
    require(std::isfinite(parameter.start) && parameter.low <= parameter.start && parameter.start <= parameter.high,
            fmt::format("{} begins at {}, outside of its bounds {} to {}", parameter.key, parameter.start,
                        parameter.low, parameter.high));
    require(study.starts <= 1 || (std::isfinite(parameter.low) && std::isfinite(parameter.high)),
            fmt::format("several starts are spread over the bounds, and {} has none", parameter.key));
  }
  require(study.parameters.size() <= 12, "at most 12 parameters can be looked for");
  for (const MeasuredTrace& trace : study.traces) {
    require(trace.values.size() == study.times.size(),
            fmt::format("{} has not a value for each time", name(trace.column, trace.place)));
    require(trace.deviation > 0.0, fmt::format("the deviation of {} is not positive", name(trace.column, trace.place)));
  }
  require(study.change_deviation > 0.0, "the deviation of the contact times is not positive");
  require(std::ranges::is_sorted(study.times) && (study.times.empty() || study.times.front() >= 0.0),
          "the times must not fall, and begin at 0 or later");
  const auto after_start = [](const Event& change) { return change.time > 0.0; };
  require((!study.times.empty() && study.times.back() > 0.0) || std::ranges::any_of(study.changes, after_start),
          "the data have no time after 0");
  require(!study.changes.empty() || std::ranges::any_of(study.traces,
                                                        [](const MeasuredTrace& trace) {
                                                          return std::ranges::any_of(trace.values, [](double value) {
                                                            return std::isfinite(value);
                                                          });
                                                        }),
          "the data have no value");
}

// Contact changes are where something can touch.
void check_places(const FitStudy& study) {
  std::vector<double> values;
  for (const FittedParameter& parameter : study.parameters) values.push_back(parameter.start);
  const Case run = study.changes.empty() ? Case() : study.model(values);
  for (const Event& change : study.changes) {
    const bool left = change.where == Where::left;
    const std::vector<Member>& chain = run.scene.chain;
    if (change.where == Where::joint && change.node < chain.size() &&
        chain[change.node - 1].joint.kind == JointKind::contact)
      continue;
    if (change.where != Where::joint &&
        (change.where == Where::span ? run.scene.span && change.node <= run.elements
                                     : is_obstacle(left ? run.scene.left : run.scene.right)))
      continue;
    const std::string place = change.where == Where::joint  ? fmt::format("joint {}", change.node)
                              : change.where == Where::span ? fmt::format("node {} of a span obstacle", change.node)
                                                            : fmt::format("the {} end", left ? "left" : "right");
    throw std::invalid_argument(
        fmt::format("fit: a contact was measured at t = {} at {}, where the scene has none", change.time, place));
  }
}

// The i-th of values to begin with, besides those given.
Eigen::VectorXd start_of(const FitStudy& study, std::size_t i, bool spread) {
  Eigen::VectorXd start(study.parameters.size());
  for (std::size_t k = 0; k < study.parameters.size(); ++k) {
    const auto& [key, given, low, high] = study.parameters[k];
    // Up to twice as far off as is looked for, and every other one between bounds that are near.
    const double size = given != 0.0 ? std::abs(given) : 1.0;
    const bool linear = spread || (i % 2 == 0 && high - low <= 1e3 * size);
    const double part = halton(spread ? i : (i + 1) / 2, k);
    const double sign = low < 0.0 && i % 4 < 2 ? -1.0 : 1.0;
    const double logarithmic = high - low <= 1e3 * size ? part : halton(i, k);
    start(k) =
        linear ? low + (high - low) * part
               : std::clamp(std::copysign(1.0, given) * sign * size * std::pow(2.0 * far_off, 2.0 * logarithmic - 1.0),
                            low, high);
  }
  return start;
}

// Values near the best at which a contact change lies on the other side of a sample beside it, where the data change
// least. A fiftieth of an interval behind the sample is more than a change misses by: of 400 random fits a 200th finds
// the same, a tenth leaves one wrong. In the middle no sample is nearer; a quarter or all of an interval finds the
// same, and so do 2 or 32 changes.
std::vector<Eigen::VectorXd> across_samples(const Search& search, const FitStudy& study, const Minimum& best) {
  constexpr std::size_t most = 8;
  const Eigen::Index n = best.at.size();
  Eigen::MatrixXd normal = best.misfit.jacobian.transpose() * best.misfit.jacobian;
  normal.diagonal() *= 1.0 + 1e-12;
  std::vector<Eigen::VectorXd> all;
  for (const Event& change : best.misfit.changes) {
    if (std::ssize(change.sensitivities) != n || all.size() >= 4 * most) continue;
    Eigen::VectorXd time(n);
    for (Eigen::Index k = 0; k < n; ++k) time(k) = change.sensitivities[static_cast<std::size_t>(k)].time;
    const auto after = std::ranges::lower_bound(study.times, change.time);
    if (!time.allFinite() || time.isZero(0.0) || after == study.times.begin() || after == study.times.end()) continue;
    const Eigen::VectorXd along = definite_solution(normal, time);
    const double per_time = time.dot(along), interval = *after - *(after - 1);
    if (!along.allFinite() || !(per_time > 0.0)) continue;
    for (const double to : {*after + 0.02 * interval, *after + 0.5 * interval, *(after - 1) - 0.02 * interval,
                            *(after - 1) - 0.5 * interval}) {
      Eigen::VectorXd at = best.at + (to - change.time) / per_time * along;
      for (Eigen::Index k = 0; k < n; ++k) at(k) = search.limited(k, best.at(k), at(k));
      all.push_back(at);
    }
  }
  return all;
}

// Values near the best that meet the samples as they are, or values that do but for what the model itself is wrong by.
// At the best ones a contact change may be on the wrong side of a sample, which is hidden by what samples beside
// changes are compared with.
std::optional<Minimum> exact_minimum(Search& search, const FitStudy& study, const Minimum& best) {
  const double noise = residual_of(best.misfit, best.at.size());
  const auto if_met = [&](const Minimum& found) {
    return is_met_exactly(study, found, noise) ? std::optional(found) : std::nullopt;
  };
  std::optional<Minimum> lowest;
  const auto from = [&](const Eigen::VectorXd& at) {
    Minimum found = search.minimum_from(at, Compared::exact, study.most_runs);
    found.errors = search.errors;
    if (!lowest || found.misfit.sum() < lowest->misfit.sum()) lowest = found;
    return if_met(found);
  };
  search.errors.clear();
  if (auto found = from(best.at)) return found;
  const auto from_best_of = [&](const std::vector<Eigen::VectorXd>& all) -> std::optional<Minimum> {
    std::vector<std::pair<double, Eigen::VectorXd>> tried;
    for (const Eigen::VectorXd& at : all) tried.emplace_back(search.at(at, Compared::exact, false).sum(), at);
    std::ranges::sort(tried, {}, [](const auto& one) { return one.first; });
    for (std::size_t i = 0; i < std::min<std::size_t>(3, tried.size()); ++i)
      if (auto found = from(tried[i].second)) return found;
    return std::nullopt;
  };
  if (auto found = from_best_of(across_samples(search, study, best))) return found;
  const Eigen::MatrixXd axes = search.axes_of_deviations(best.at);
  std::vector<Eigen::VectorXd> around;
  for (const double scale : {4.0, 2.0, 1.0})
    for (std::size_t i = 0; i < 16; ++i) around.push_back(search.beside(best.at, scale * axes, around.size() + 1));
  if (auto found = from_best_of(around)) return found;
  // Excused is what is met least, or what the excuse leads to.
  search.errors = time_errors(study, best);
  lowest->errors = search.errors;
  lowest->misfit = search.at(lowest->at, Compared::exact);
  if (auto found = if_met(*lowest)) return found;
  return from(best.at);
}

}  // namespace

FitResult fit(const FitStudy& study) {
  check(study);
  check_places(study);
  FitResult result;
  Search search(study);
  std::vector<Minimum> found;
  std::size_t best = 0;
  const auto begin_at = [&](const Eigen::VectorXd& start, Compared first, std::size_t most) {
    found.push_back(search.minimum_from(start, first, most));
    result.sums.push_back(found.back().misfit.sound ? found.back().misfit.sum()
                                                    : std::numeric_limits<double>::quiet_NaN());
    const double gained = found[best].misfit.sum() - found.back().misfit.sum();
    // No more numbers than parameters are met by several values: those that were found first stay.
    const bool is_met = found[best].misfit.sum() <= small_residual * small_residual &&
                        !found[best].misfit.is_tested(std::ssize(study.parameters));
    if (is_met && !found.back().at.isApprox(found[best].at, 0.01)) return;
    if (gained > 0.0 || (gained == 0.0 && found.back().converged >= found[best].converged)) best = found.size() - 1;
  };
  // Values that meet the samples as they are, by the minima that lead there.
  std::map<std::size_t, std::optional<Minimum>> exact;
  const auto exact_of = [&](std::size_t k) -> const std::optional<Minimum>& {
    if (!exact.contains(k)) exact[k] = exact_minimum(search, study, found[k]);
    return exact[k];
  };
  const auto is_settled = [&] {
    const Minimum& now = found[best];
    return is_explained(study, now.misfit) && !runs_away(study, now.at, now.misfit) &&
           (!search.jumps() || (!jumps_alone_tell(now) && exact_of(best) && exact_of(best)->errors.empty()));
  };
  Eigen::VectorXd given(study.parameters.size());
  for (std::size_t k = 0; k < study.parameters.size(); ++k) given(k) = study.parameters[k].start;
  const Eigen::Index n = given.size();
  begin_at(given, Compared::integrals, study.most_runs);
  for (std::size_t i = 1; i < study.starts; ++i)
    begin_at(start_of(study, i, true), Compared::integrals, study.most_runs);
  // Many runs without derivatives say where to begin again.
  const std::size_t tries = 24 * std::min<std::size_t>(study.parameters.size(), 4), most_runs = 8 * study.most_runs;
  // The best of them shows soon; it goes on below.
  const std::size_t few_runs = (study.most_runs + 3) / 4;
  std::size_t far = 0, near = 0;
  const auto begin_among = [&](std::size_t count, std::size_t most, Compared compared, const auto& next) {
    std::vector<std::pair<double, Eigen::VectorXd>> tried;
    for (std::size_t i = 0; i < count && search.runs < most_runs; ++i) {
      const Eigen::VectorXd start = next();
      tried.emplace_back(search.at(start, compared, false).sum(), start);
    }
    std::ranges::sort(tried, {}, [](const auto& one) { return one.first; });
    for (std::size_t i = 0; i < std::min(most, tried.size()) && search.runs < most_runs; ++i)
      if (std::isfinite(tried[i].first)) begin_at(tried[i].second, compared, few_runs);
  };
  // Jumps of velocities and reactions leave narrow valleys beside each other: from one of them to the next, as long as
  // that leads down by what values of the model, right to their tolerance, tell.
  const auto begin_beside = [&](std::size_t count, std::initializer_list<double> scales, const auto& axes_at) {
    for (double least = INFINITY; found[best].misfit.sum() < least && search.runs < most_runs;) {
      least = found[best].misfit.sum() - 0.03 * found[best].misfit.variance(n);
      const Eigen::MatrixXd axes = axes_at(found[best].at);
      for (const double scale : scales) {
        const Eigen::VectorXd centre = found[best].at;
        begin_among(count, 1, Compared::samples, [&] { return search.beside(centre, scale * axes, ++near); });
      }
    }
  };
  const auto sizes = [&](const Eigen::VectorXd& values) {
    return Eigen::MatrixXd((values.array() != 0.0).select(values, 0.1 * given).asDiagonal());
  };
  for (std::size_t round = 0; round < 6 && search.runs < most_runs && !is_settled(); ++round) {
    // Integrals by few samples are wrong by what a bounce in between them changes.
    const bool by_samples = search.jumps() && round % 2 == 1;
    begin_among(tries, 4, by_samples ? Compared::samples : Compared::integrals,
                [&] { return start_of(study, ++far, false); });
    if (search.jumps()) begin_beside(tries / 8, {1.0 / 3.0, 0.1, 1.0 / 30.0, 0.01, 1.0 / 300.0}, sizes);
  }
  if (is_explained(study, found[best].misfit) && residual_of(found[best].misfit, n) > small_residual) {
    // Where noise is all that is left, other minima as low are within a few deviations,
    if (search.jumps())
      begin_beside(tries / 12, {2.0, 1.0, 0.5, 0.25, 0.125},
                   [&](const Eigen::VectorXd& values) { return search.axes_of_deviations(values); });
    // or where a parameter would have another sign or twice its size within three: S is not quadratic as far as that.
    const Minimum centre = found[best];
    const Eigen::VectorXd three = 3.0 * deviations(centre.misfit);
    for (Eigen::Index k = 0; k < n; ++k)
      for (const double step : {-three(k), three(k)}) {
        const FittedParameter& parameter = study.parameters[k];
        const double size = std::abs(centre.at(k));
        const bool to_zero = step * centre.at(k) < 0.0;  // where half of it is as far as twice it is
        if (!std::isfinite(step) || std::abs(step) < (to_zero ? 0.5 : 1.0) * size || search.runs >= most_runs) continue;
        Eigen::VectorXd start = centre.at;
        start(k) = std::clamp(start(k) + step, std::max(parameter.low, parameter.low < 0.0 ? -INFINITY : 0.1 * size),
                              parameter.high);
        begin_at(start, Compared::samples, few_runs);
      }
  }
  if (!found[best].converged && found.size() > study.starts)
    begin_at(found[best].at, Compared::samples, study.most_runs);
  if (!found[best].misfit.sound) throw std::invalid_argument("fit: no start gives a run: " + found.front().reason);
  bool met = true;
  if (search.jumps()) {
    constexpr std::size_t most_looked_at = 4;
    if (!is_settled()) {
      search.errors.clear();
      std::vector<std::size_t> order(found.size());
      std::iota(order.begin(), order.end(), 0);
      std::vector<double> sums;
      for (const Minimum& one : found) sums.push_back(search.at(one.at, Compared::exact, false).sum());
      std::ranges::stable_sort(order, {}, [&](std::size_t k) { return sums[k]; });
      std::vector<std::size_t> looked_at;
      for (const std::size_t k : order) {
        const auto is_near = [&](std::size_t other) { return found[k].at.isApprox(found[other].at, 0.01); };
        if (looked_at.size() == most_looked_at) break;
        if (k != best && !is_explained(study, found[k].misfit)) continue;
        if (std::ranges::any_of(looked_at, is_near)) continue;
        looked_at.push_back(k), exact_of(k);
      }
    }
    const auto rank = [](const auto& one) {
      return std::pair(!one.second || !one.second->errors.empty(), one.second ? one.second->misfit.sum() : INFINITY);
    };
    const auto least = std::ranges::min_element(exact, {}, rank)->second;
    met = least.has_value();
    search.errors = met ? least->errors : TimeErrors();
    if (met) {
      for (Minimum& other : found) other.misfit = search.at(other.at, Compared::exact, false);
      best = found.size(), found.push_back(*least);
      for (const auto& [k, minimum] : exact)
        if (minimum) result.sums.push_back(minimum->misfit.sum()), found.push_back(*minimum);
    }
  }
  for (bool settled = false; !settled;) {
    FitResult judged;
    std::vector<Minimum> others;
    const auto lower = judge(search, study, found[best], others, judged);
    found.insert(found.end(), others.begin(), others.end());
    const std::size_t before = best;
    if (lower && search.runs < most_runs) begin_at(*lower, found[best].compared, few_runs);
    settled = best == before;
    if (settled) judged.sums = std::move(result.sums), result = std::move(judged);
  }
  const Minimum& minimum = found[best];
  result.runs += search.runs;
  result.iterations = minimum.iterations;
  result.converged = minimum.converged;
  result.reason = minimum.reason;
  add_warnings(study, found, minimum, met, result);
  result.traces = minimum.misfit.traces;
  result.changes = minimum.misfit.changes;
  result.lost = minimum.misfit.lost;
  return result;
}

}  // namespace viscobar
