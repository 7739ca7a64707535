#include "studies/fit/judgement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <stdexcept>
#include <utility>

#include "discretisation/dense.hpp"
#include "studies/fit/noise.hpp"

namespace viscobar::fitting {

namespace {

// The minimum of a finer model. Where its search from the best values of the coarse one does not meet data of what
// jumps that those meet, its valley is farther than slopes tell: it is looked for up to a third of the values away.
Minimum finer_minimum(Search& further, const FitStudy& study, const Minimum& best, Compared along,
                      std::size_t most_runs) {
  constexpr std::size_t tries = 16;
  const Eigen::Index n = best.at.size();
  Minimum least;
  const auto search_from = [&](const Eigen::VectorXd& start) {
    // Samples as they are lead over the flat floors of those beside changes, unless one is on the wrong side.
    for (const Compared compared : {Compared::samples, Compared::exact}) {
      Minimum found = further.minimum_from(start, compared, most_runs);
      if (compared != along) found.misfit = further.at(found.at, along, false);
      if (found.misfit.sum() < least.misfit.sum()) least = std::move(found);
      if (!further.jumps()) return;
    }
  };
  search_from(best.at);
  if (!further.jumps() || is_large(study, best.misfit)) return least;
  const double most = curved_residual * std::max(1.0, residual_of(best.misfit, n));
  std::size_t tried = 0;
  for (const double part : {1.0 / 300.0, 1.0 / 30.0, 0.1, 1.0 / 3.0}) {
    if (residual_of(least.misfit, n) <= most) break;
    const Eigen::MatrixXd axes = (part * best.at.cwiseAbs()).asDiagonal();
    std::pair<double, Eigen::VectorXd> start(INFINITY, best.at);
    for (std::size_t i = 0; i < tries; ++i) {
      Eigen::VectorXd at = further.beside(best.at, axes, ++tried);
      if (const double sum = further.at(at, along, false).sum(); sum < start.first) start = {sum, std::move(at)};
    }
    search_from(start.second);
  }
  return least;
}

// How far the model's own error moves the parameters, counted in `scale`, twice for an error of order one: what a finer
// run changes its values by, taken for data that are wrong by so much; and, where samples jump, which a line does not
// follow from one valley into the next, the way to the minimum of the finer model.
struct ModelError {
  Eigen::VectorXd linear, searched;
};
ModelError model_error(Search& search, const FitStudy& study, const Minimum& best, const Eigen::MatrixXd& scaled,
                       const Eigen::MatrixXd& inverse, const Eigen::VectorXd& scale, const Eigen::VectorXd& ways,
                       const std::vector<Eigen::Index>& free, FitResult& result) {
  constexpr std::size_t few_runs = 12;
  constexpr Eigen::Index many = 100;
  constexpr double farthest = 0.25;
  const std::size_t runs_of_a_step = study.differences ? 1 + 2 * study.parameters.size() : 1;
  ModelError error{Eigen::VectorXd::Zero(inverse.rows()), Eigen::VectorXd::Zero(inverse.rows())};
  try {
    FitStudy of_finer = study;
    of_finer.model = [&study](std::span<const double> values) { return finer(study.model(values)); };
    if (const auto found = faults(resolve(of_finer.model({best.at.data(), static_cast<std::size_t>(best.at.size())})));
        !found.empty())
      throw std::runtime_error(found.front().problem);
    Search further(of_finer, 1000 + 200 * best.misfit.steps);
    further.errors = search.errors;
    // A finer run has contact changes on the other side of a sample, which is an error of so much only where few
    // samples tell the parameters.
    const Compared along = best.misfit.residual.size() > many ? Compared::samples : best.compared;
    const Misfit fine = further.at(best.at, along, false);
    if (!fine.sound) throw std::runtime_error(fine.error);
    const Misfit coarse = along == best.compared ? best.misfit : search.at(best.at, along, false);
    error.linear = 2.0 * (inverse * (scaled.transpose() * (fine.residual - coarse.residual))).cwiseAbs();
    if (search.jumps() || is_large(study, best.misfit)) {
      const Minimum other = finer_minimum(further, study, best, along, few_runs * runs_of_a_step);
      if (search.jumps() && other.misfit.sound)
        error.searched = 2.0 * (other.at - best.at)(free).cwiseAbs().cwiseQuotient(scale(free));
      result.finer_residual = residual_of(other.misfit, best.at.size());
    }
    // No derivative leads a search over the plateaus of a parameter that jumps alone tell.
    for (Eigen::Index a = 0; a < ways.size(); ++a) {
      double least = fine.sum();
      for (double way = ways(a); way > 0.0 && way <= farthest * scale(free[a]); way *= 2.0)
        for (const double sign : {-1.0, 1.0}) {
          Eigen::VectorXd values = best.at;
          values(free[a]) = search.limited(free[a], best.at(free[a]), best.at(free[a]) + sign * way);
          const double sum = further.at(values, best.compared, false).sum();
          if (!(sum < least)) continue;
          least = sum, error.searched(a) = std::max(error.searched(a), 2.0 * way / scale(free[a]));
        }
    }
    result.runs += further.runs;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& problem) {
    result.warnings.push_back(fmt::format("the model's own error is not in the deviations: {}", problem.what()));
  }
  return error;
}

constexpr double far_apart = 5.0;  // deviations
constexpr double as_well = 4.0;    // variances by which S may be larger

// Other values than the best that meet the data as well.
bool is_another(const Minimum& other, const Minimum& best, const FitResult& result) {
  const double variance = std::max(best.misfit.variance(best.at.size()), std::pow(small_residual, 2));
  if (!other.misfit.sound || other.misfit.sum() - best.misfit.sum() > as_well * variance) return false;
  for (Eigen::Index k = 0; k < best.at.size(); ++k) {
    const double deviation = result.parameters[k].standard_deviation;  // NaN: whatever the value, the data agree
    if (std::abs(other.at(k) - best.at(k)) > std::max(far_apart * deviation, 0.01 * std::abs(best.at(k)))) return true;
  }
  return false;
}

// How many times as long as this step, one deviation of parameter k by the derivatives, a deviation is: half of the way
// on which S rises by four times its variance; 1 where that is as far as they say. Beside a jump they know one side of
// a valley that is wide on the other, and behind a ridge S may be low again.
double reach(Search& search, const FitStudy& study, const Minimum& best, Eigen::Index k, const Eigen::VectorXd& step,
             std::optional<Eigen::VectorXd>& lower) {
  constexpr double sigmas = 2.0, widening = 4.0, farthest = 1e7;
  // Deviations by the derivatives are kept where S says between a half and 1.15 of them: it rises by their square. Of
  // 400 random fits 0.35 and 0.7, 1.05 and 1.4 leave as many wrong.
  constexpr double shortest = 0.5, longest = 1.15;
  constexpr std::size_t behind = 2, few_runs = 8;
  const std::size_t most_runs = 10 * study.most_runs;
  const double variance = best.misfit.variance(step.size()), least = best.misfit.sum();
  const double enough = sigmas * sigmas * variance;
  const auto is_between = [&](Eigen::Index j, double value) {
    return study.parameters[j].low <= value && value <= study.parameters[j].high;
  };
  const auto within = [&](const Eigen::VectorXd& values) {
    for (Eigen::Index j = 0; j < step.size(); ++j)
      if (!is_between(j, values(j))) return false;
    return true;
  };
  const auto rise_at = [&](double times) {
    return search.at(best.at + times * step, best.compared, false).sum() - least;
  };
  // S has a valley that bends: the others find its floor.
  const auto rise_of_floor = [&](double times) {
    Eigen::VectorXd values = best.at + times * step;
    if (!is_between(k, values(k))) return static_cast<double>(INFINITY);
    for (Eigen::Index j = 0; j < step.size(); ++j)
      if (j != k) values(j) = search.limited(j, best.at(j), values(j));
    Eigen::VectorXd stay = best.at;
    stay(k) = values(k);
    search.held = k;
    double rise = INFINITY;
    for (const Eigen::VectorXd& from : {values, stay}) {
      const Minimum floor = search.minimum_from(from, best.compared, few_runs);
      if (floor.misfit.sum() - least < -0.03 * variance && !lower) lower = floor.at;
      rise = std::min(rise, floor.misfit.sum() - least);
      if (step.size() == 1) break;
    }
    search.held.reset();
    return rise;
  };
  const auto look_behind = [&](double times) {
    for (std::size_t i = 0; i < behind; ++i) rise_of_floor(times *= widening);
  };
  double before = 0.0, risen = 0.0;
  for (double times = sigmas; times < farthest; times *= widening) {
    const bool first = times == sigmas, inside = within(best.at + times * step);
    if (!inside && !first) return times / sigmas;
    double rise = inside ? rise_at(times) : INFINITY;
    if (rise < -0.03 * variance && !lower) lower = best.at + times * step;
    if (first && !(rise * shortest * shortest <= enough)) rise = std::min(rise, rise_of_floor(times));
    if (first && !(rise * shortest * shortest <= enough)) {  // a bound or a jump is nearer than the derivatives know
      look_behind(times);
      double part = 0.5 * sigmas;
      while (part > 1e-3 && !(rise_of_floor(part) <= enough)) {
        if (search.runs >= most_runs) return 1.0;
        part *= 0.7;
      }
      return 2.0 * part / sigmas;
    }
    const bool kept = first && rise * longest * longest > enough;
    // Smooth data have no ridge behind where S rises as its derivatives say.
    const bool quadratic = kept && std::abs(rise - enough) <= 0.05 * enough;
    if ((kept || rise >= enough) && (search.jumps() || !quadratic)) look_behind(times);
    if (kept) return 1.0;
    if (!std::isfinite(rise)) return times / sigmas;
    if (rise >= enough) return (before + (times - before) * (enough - risen) / (rise - risen)) / sigmas;
    before = times, risen = std::max(rise, 0.0);
  }
  return farthest;
}

// A deviation that S allows by all runs made: where it is quadratic, |p_k - best_k| <= deviation (rise of S / its
// variance)^(1/2) anywhere; and the run that tells it.
struct TriedDeviation {
  double deviation = 0.0;
  Eigen::VectorXd at;
};
TriedDeviation deviation_of_tried(const Search& search, const Minimum& best, Eigen::Index k) {
  constexpr double farthest = 9.0;
  const double variance = best.misfit.variance(best.at.size());
  TriedDeviation most;
  for (const auto& [at, compared, sum] : search.tried) {
    const double rise = (sum - best.misfit.sum()) / variance;
    const double deviation = std::abs(at(k) - best.at(k)) / std::sqrt(std::max(rise, 1.0));
    if (compared == best.compared && rise <= farthest && deviation > most.deviation) most = {deviation, at};
  }
  return most;
}

// How far a parameter that J hardly knows may go, the others held, until S rises: samples of what jumps tell it to
// their intervals. Nothing where it goes farther than the data may be said to tell, or to a bound.
std::optional<double> plateau(Search& search, const FitStudy& study, const Minimum& best, Eigen::Index k, double size,
                              std::optional<Eigen::VectorXd>& lower) {
  constexpr double sigmas = 2.0, first = 1e-4, widening = 4.0, farthest = 10.0, sharp = 0.1;
  // A rise by errors of the runs is none.
  const double variance = std::max(best.misfit.variance(best.at.size()), small_residual * small_residual);
  const double most = best.misfit.sum() + sigmas * sigmas * variance;
  double widest = 0.0;
  for (const double sign : {-1.0, 1.0}) {
    const auto at = [&](double way) { return best.at(k) + sign * way; };
    const auto rises = [&](double way) {
      Eigen::VectorXd values = best.at;
      values(k) = at(way);
      const double sum = search.at(values, best.compared, false).sum();
      if (sum - best.misfit.sum() < -0.03 * variance && !lower) lower = values;
      return !(sum <= most);
    };
    double flat = 0.0, high = first * size;
    for (;; flat = high, high *= widening) {
      if (high > farthest * size || at(high) <= study.parameters[k].low || at(high) >= study.parameters[k].high)
        return std::nullopt;
      if (rises(high)) break;
    }
    while (high - flat > sharp * high) (rises(0.5 * (flat + high)) ? high : flat) = 0.5 * (flat + high);
    widest = std::max(widest, high);
  }
  return widest;
}

}  // namespace

std::optional<Eigen::VectorXd> judge(Search& search, const FitStudy& study, const Minimum& best,
                                     std::vector<Minimum>& others, FitResult& result) {
  const Eigen::Index n = std::ssize(study.parameters);
  const Misfit& misfit = best.misfit;
  // Numbers of 53 digits are rounded by so much of a deviation that is a hundredth of them.
  constexpr double rounding = 100.0 * 0x1p-53;
  const double variance = std::max(misfit.variance(n), rounding * rounding);
  result.residual = residual_of(misfit, n);
  result.measured = static_cast<std::size_t>(misfit.residual.size());
  result.freedom = misfit.is_tested(n) ? static_cast<std::size_t>(misfit.freedom(n)) : 0;
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const auto size = static_cast<std::size_t>(n);
  result.covariance.assign(size * size, none);
  result.correlation.assign(size * size, none);
  result.model_errors.assign(size, none);

  Eigen::VectorXd scale(n);
  std::vector<Eigen::Index> free;
  const Eigen::VectorXd gradient = misfit.jacobian.transpose() * misfit.residual;
  for (Eigen::Index k = 0; k < n; ++k) {
    const FittedParameter& parameter = study.parameters[k];
    const double range = parameter.high - parameter.low;
    scale(k) = best.at(k) != 0.0 ? std::abs(best.at(k)) : std::isfinite(range) ? range : 1.0;
    // Or the model jumps right behind it: data do not tell a parameter to a part in 1e9.
    const bool bound = leaves(parameter, best.at(k), -gradient(k)) ||
                       (on_bound(parameter, best.at(k)) && 1e-9 * scale(k) * misfit.jacobian.col(k).norm() > 1.0);
    result.parameters.push_back({parameter.key, best.at(k), none, bound});
    if (!bound) free.push_back(k);
  }
  std::optional<Eigen::VectorXd> lower;
  if (free.empty()) return lower;
  const auto count = std::ssize(free);
  const Eigen::MatrixXd scaled = misfit.jacobian(Eigen::all, free) * scale(free).asDiagonal();
  const auto [values, directions] = singular_values(scaled);
  // Smaller singular values are below rounding: their directions leave the model as it is.
  const double least = std::max(1e-8 * values(0), 1e-6);
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(count, count);
  std::vector<bool> known(size, true);
  Eigen::VectorXd ways = Eigen::VectorXd::Zero(count);  // over plateaus
  for (Eigen::Index j = 0; j < count; ++j) {
    result.singular_values.push_back(values(j));
    const Eigen::VectorXd direction = directions.col(j);
    if (values(j) > least) {
      inverse += direction * direction.transpose() / (values(j) * values(j));
      continue;
    }
    Eigen::Index own = 0;
    const bool alone = direction.cwiseAbs().maxCoeff(&own) > 1.0 - 1e-6;
    if (const auto way = alone ? plateau(search, study, best, free[own], scale(free[own]), lower) : std::nullopt) {
      ways(own) = *way;
      continue;
    }
    Undetermined lack{values(0) > 0.0 ? values(j) / values(0) : 0.0, std::vector<double>(size, 0.0)};
    for (Eigen::Index a = 0; a < count; ++a) {
      lack.shares[free[a]] = direction(a);
      if (std::abs(direction(a)) > 1e-3) known[free[a]] = false;
    }
    result.undetermined.push_back(std::move(lack));
  }
  const ModelError moved = model_error(search, study, best, scaled, inverse, scale, ways, free, result);
  Eigen::VectorXd longer = Eigen::VectorXd::Ones(count);
  for (Eigen::Index a = 0; a < count; ++a) {
    const FittedParameter& parameter = study.parameters[free[a]];
    Estimate& one = result.parameters[free[a]];
    if (!known[free[a]]) continue;
    // Noise is left, and not what runs are wrong by; or nothing tells it, and it is as large as it was said to be.
    if (ways(a) == 0.0 && (result.residual > small_residual || result.freedom == 0)) {
      Eigen::VectorXd step = Eigen::VectorXd::Zero(n);
      step(free) = std::sqrt(variance / inverse(a, a)) * scale(free).cwiseProduct(inverse.col(a));
      const double own = std::abs(step(free[a]));
      longer(a) =
          std::max(reach(search, study, best, free[a], step, lower), reach(search, study, best, free[a], -step, lower));
      // A run that is low farther off than that is in the same valley, or in another one, whose minimum it leads to.
      if (const auto [deviation, at] = deviation_of_tried(search, best, free[a]); deviation > longer(a) * own) {
        Minimum other = search.minimum_from(at, best.compared, study.most_runs);
        const double gained = best.misfit.sum() - other.misfit.sum();
        if (gained > 0.03 * variance && !lower) lower = other.at;
        const bool is_told = -gained <= as_well * variance;  // else it is no minimum to be told
        if (is_told && std::abs(other.at(free[a]) - best.at(free[a])) > far_apart * longer(a) * own)
          others.push_back(std::move(other));
        else
          longer(a) = deviation / own;
      }
    }
    const double noise = longer(a) * scale(free[a]) * std::sqrt(variance * inverse(a, a)),
                 linear = std::min(1.0, longer(a)) * scale(free[a]) * moved.linear(a);
    const double own = std::max(scale(free[a]) * moved.searched(a),
                                std::numeric_limits<double>::epsilon() * std::abs(one.estimate));  // its rounding
    double error = std::max(linear, own), deviation = std::hypot(noise, error);
    // A step of one deviation by the data leaves the bounds, or what the parameter is large by.
    const bool far =
        std::hypot(noise, linear) > std::min(0.5 * (parameter.high - parameter.low), 10.0 * std::abs(one.estimate));
    // Nor do others make up for it.
    if (far && scaled.col(a).squaredNorm() * inverse(a, a) < 2.0)
      ways(a) = plateau(search, study, best, free[a], scale(free[a]), lower).value_or(0.0);
    if (far && ways(a) == 0.0) {
      known[free[a]] = false;
      result.undetermined.push_back(
          {inverse(a, a) > 0.0 ? 1.0 / std::sqrt(inverse(a, a)) / values(0) : 0.0, std::vector<double>(size, 0.0)});
      result.undetermined.back().shares[free[a]] = 1.0;
      continue;
    }
    if (ways(a) > 0.0) {
      error = own, deviation = std::hypot(ways(a), error), longer(a) = 1.0;
      inverse.row(a).setZero(), inverse.col(a).setZero();
      inverse(a, a) = std::pow(ways(a) / scale(free[a]), 2) / variance;
    }
    result.model_errors[free[a]] = error;
    one.standard_deviation = deviation;
  }
  for (Eigen::Index a = 0; a < count; ++a)
    for (Eigen::Index b = 0; b < count; ++b) {
      if (!known[free[a]] || !known[free[b]]) continue;
      const double covariance = variance * longer(a) * scale(free[a]) * longer(b) * scale(free[b]) * inverse(a, b);
      const std::size_t at = static_cast<std::size_t>(free[a] * n + free[b]);
      result.covariance[at] = covariance + (a == b ? std::pow(result.model_errors[free[a]], 2) : 0.0);
      result.correlation[at] = inverse(a, b) / std::sqrt(inverse(a, a) * inverse(b, b));
    }
  return lower;
}

void add_warnings(const FitStudy& study, const std::vector<Minimum>& found, const Minimum& best, bool met,
                  FitResult& result) {
  const std::size_t before = result.warnings.size();
  if (is_large(study, best.misfit)) {
    const bool mesh = result.finer_residual < 0.5 * result.residual;
    result.warnings.push_back(
        fmt::format("the model stays {:.3g} deviations away from the data", result.residual) +
        (mesh ? fmt::format(", and {:.3g} on twice the elements: its mesh is too coarse for them; raise mesh.elements",
                            result.finer_residual)
              : ": either it is not theirs, or these are not the values; other starts, bounds, or parameters that are "
                "held now may help"));
  }
  if (!met && result.warnings.size() == before)
    result.warnings.push_back(
        "beside contact changes the model is farther from the samples than noise and its own error in the times of these: "
        "other starts, bounds, or more elements may help");
  for (const Minimum& other : found)
    if (is_another(other, best, result)) {
      std::string values;
      for (Eigen::Index k = 0; k < other.at.size(); ++k)
        values += fmt::format("{}{} = {:.6g}", values.empty() ? "" : ", ", study.parameters[k].key, other.at(k));
      result.warnings.push_back("starts disagree: other values meet the data as well: " + values);
      break;
    }
  if (!result.converged) result.warnings.push_back("the search: " + result.reason);
  const bool bound = std::ranges::any_of(result.parameters, &Estimate::at_bound);
  if (result.converged && result.warnings.size() == before && !bound && result.undetermined.empty()) return;
  if (result.converged) result.reason = "it came to a minimum that is not to be relied on: see the warnings";
  result.converged = false;
}

}  // namespace viscobar::fitting
