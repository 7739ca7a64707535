#include "studies/fit/search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <stdexcept>
#include <utility>

#include "discretisation/dense.hpp"

namespace viscobar::fitting {

bool leaves(const FittedParameter& parameter, double value, double step) {
  return (value <= parameter.low && step < 0.0) || (value >= parameter.high && step > 0.0);
}

double halton(std::size_t i, std::size_t k) {
  constexpr std::size_t primes[] = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37};
  double fraction = 1.0, value = 0.0;
  for (; i > 0; i /= primes[k])
    fraction /= static_cast<double>(primes[k]), value += fraction * static_cast<double>(i % primes[k]);
  return value;
}

Misfit Search::at(const Eigen::VectorXd& values, Compared compared, bool derivatives) {
  try {
    Misfit misfit = run(values, compared, derivatives && !study_.differences);
    if (!most_steps_) most_steps_ = 1000 + 50 * misfit.steps;
    if (misfit.sound) tried.push_back({values, compared, misfit.sum()});
    // Where derivatives end, differences go on.
    if (derivatives && misfit.sound && (study_.differences || misfit.lost)) difference(values, compared, misfit);
    return misfit;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    Misfit failed;
    failed.error = error.what();
    return failed;
  }
}

bool Search::jumps() const {
  return std::ranges::any_of(
      study_.traces, [](const MeasuredTrace& one) { return is_velocity(one.column) || is_reaction(one.column); });
}

// Integrals of what jumps, for no sample of a jump tells by how much it changes.
Eigen::MatrixXd Search::axes_of_deviations(const Eigen::VectorXd& values) {
  const Misfit misfit = at(values, Compared::integrals);
  if (!misfit.sound) return Eigen::MatrixXd::Zero(n_, n_);
  const Eigen::VectorXd size = values.cwiseAbs();
  const auto [values_of, directions] = singular_values(misfit.jacobian * size.asDiagonal());
  const Eigen::VectorXd lengths = values_of.cwiseMax(1.0).cwiseInverse();
  return size.asDiagonal() * directions * lengths.asDiagonal();
}

Eigen::VectorXd Search::beside(const Eigen::VectorXd& centre, const Eigen::MatrixXd& axes, std::size_t i) const {
  Eigen::VectorXd part(n_);
  for (Eigen::Index k = 0; k < n_; ++k) part(k) = 2.0 * halton(i, static_cast<std::size_t>(k)) - 1.0;
  Eigen::VectorXd to = centre + axes * part;
  for (Eigen::Index k = 0; k < n_; ++k) to(k) = limited(k, centre(k), to(k));
  return to;
}

Minimum Search::minimum_from(const Eigen::VectorXd& start, Compared first, std::size_t most_runs) {
  if (first == Compared::integrals && jumps())
    if (const Minimum near = descend(start, Compared::integrals, most_runs); near.misfit.sound) {
      // Integrals of contacts shorter than a sample's interval tell little, and may lead away from values that are
      // better.
      const Minimum there = descend(near.at, Compared::samples, most_runs);
      if (there.misfit.sum() <= at(start, Compared::samples, false).sum()) return there;
    }
  return descend(start, first == Compared::exact ? first : Compared::samples, most_runs);
}

Misfit Search::run(const Eigen::VectorXd& values, Compared compared, bool derivatives) {
  ++runs;
  return measure(study_, study_.model({values.data(), static_cast<std::size_t>(values.size())}), compared, derivatives,
                 most_steps_.value_or(first_steps_), errors);
}

void Search::difference(const Eigen::VectorXd& values, Compared compared, Misfit& misfit) {
  misfit.jacobian.setZero(misfit.residual.size(), n_);
  for (Eigen::Index k = 0; k < n_; ++k) {
    if (k == held) continue;
    const FittedParameter& parameter = study_.parameters[k];
    const double step = 1e-4 * std::max({std::abs(values(k)), 1e-2 * std::abs(parameter.start), 1e-6});
    const double forth = values(k) + step <= parameter.high ? step : -step;
    const auto quotient = [&](double by) {
      Eigen::VectorXd beside = values;
      beside(k) += by;
      const Misfit other = run(beside, compared, false);
      return Eigen::VectorXd((other.residual - misfit.residual) / (beside(k) - values(k)));
    };
    auto column = misfit.jacobian.col(k);
    column = quotient(forth);
    if (!jumps() || values(k) - forth < parameter.low || values(k) - forth > parameter.high) continue;
    try {  // a sample over which a wave front passes on one side changes as the other one says
      const Eigen::VectorXd back = quotient(-forth);
      column = (back.array().abs() < column.array().abs()).select(back, column).eval();
    } catch (const std::runtime_error&) {  // there is no run on that side
    }
  }
}

double Search::limited(Eigen::Index k, double from, double to) const {
  const FittedParameter& parameter = study_.parameters[k];
  const double given = std::abs(parameter.start), size = std::max(std::abs(from), 0.1 * given), far = 1e4;
  // Nor does any lead to where no run ends, or nothing moves.
  if (given > 0.0) to = std::clamp(to, parameter.low >= 0.0 ? given / far : -given * far, given * far);
  if (size > 0.0) to = std::clamp(to, parameter.low >= 0.0 ? 0.25 * from : from - 3.0 * size, from + 3.0 * size);
  return std::clamp(to, parameter.low, parameter.high);
}

// From here on a step changes nothing that the data tell: of a standard deviation, and of a parameter.
constexpr double small_step = 1e-3, rounding_step = 1e-9;

Minimum Search::descend(const Eigen::VectorXd& start, Compared compared, std::size_t most_runs) {
  Minimum now{start, at(start, compared), 0, false, "", compared, {}};
  const auto ended = [&now](std::string reason) {
    now.reason = std::move(reason);
    return now;
  };
  const auto converged = [&](const char* reason) {
    now.converged = true;
    return ended(reason);
  };
  if (!now.misfit.sound) return ended(now.misfit.error);
  double damping = 1e-3;
  bool differenced = study_.differences;
  const std::size_t first_run = runs;
  while (runs - first_run < most_runs) {
    const Eigen::MatrixXd& jacobian = now.misfit.jacobian;
    const Eigen::VectorXd gradient = jacobian.transpose() * now.misfit.residual;
    std::vector<Eigen::Index> free;
    for (Eigen::Index k = 0; k < n_; ++k)
      if (k != held && !leaves(study_.parameters[k], now.at(k), -gradient(k))) free.push_back(k);
    if (free.empty()) return converged("all parameters are at their bounds");
    const Eigen::MatrixXd part = jacobian(Eigen::all, free);
    const Eigen::MatrixXd normal = part.transpose() * part;
    const Eigen::VectorXd slope = gradient(free);
    Eigen::VectorXd scale = normal.diagonal();
    const double least = 1e-30 * std::max(scale.maxCoeff(), 1e-300);
    scale = scale.cwiseMax(least);
    Eigen::MatrixXd damped = normal;
    damped.diagonal() += damping * scale;
    const Eigen::VectorXd step = definite_solution(damped, -slope);
    Eigen::VectorXd next = now.at;
    for (std::size_t j = 0; j < free.size(); ++j)
      next(free[j]) = limited(free[j], now.at(free[j]), now.at(free[j]) + step(j));
    const Eigen::VectorXd moved = next - now.at;
    const double variance = now.misfit.variance(n_);
    // In the quadratic model |J step|^2 in units of the variance is the step in standard deviations, squared.
    const double deviations = std::sqrt((jacobian * moved).squaredNorm() / std::max(variance, 1e-300));
    const bool still = ((moved.array().abs() <= rounding_step * now.at.array().abs().max(1e-300)).all());
    if ((damping <= 1.0 && deviations < small_step) || still)
      return converged("the next step would change the model by less than the data can show");
    Misfit trial = at(next, compared);
    ++now.iterations;
    const double predicted = now.misfit.sum() - (now.misfit.residual + jacobian * moved).squaredNorm();
    const double gained = trial.sound ? now.misfit.sum() - trial.sum() : -1.0;
    if (gained > 0.0) {
      const double ratio = gained / std::max(predicted, 1e-300);
      damping *= ratio > 0.75 ? 0.1 : ratio > 0.25 ? 0.5 : 2.0;
      damping = std::max(damping, 1e-12);
      now.at = next;
      now.misfit = std::move(trial);
      continue;
    }
    // A gain below the rounding of the sum is none.
    if (trial.sound && std::abs(gained) <= 1e-12 * now.misfit.sum() && predicted <= 1e-9 * now.misfit.sum())
      return converged("the sum of squares does not fall any more");
    damping = std::max(10.0 * damping, 1e-3);
    if (damping < 1e8) continue;
    if (compared == Compared::exact) return converged("any step puts a sample on the other side of a contact change");
    if (differenced) return ended("no step makes the sum of squares smaller, though its derivatives say so");
    try {  // the sum of squares has a kink, which its derivatives on one side do not tell
      difference(now.at, compared, now.misfit);
    } catch (const std::runtime_error& error) {
      return ended(error.what());
    }
    differenced = true;
    damping = 1e-3;
  }
  return ended(fmt::format("{} runs were not enough", most_runs));
}

}  // namespace viscobar::fitting
