#include "viscobar/studies/orders/orders.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "studies/parallel.hpp"
#include "viscobar/case/recorder.hpp"
#include "viscobar/studies/compare/difference.hpp"

namespace viscobar {

std::optional<ObservedOrder> observed_order(std::span<const double> x, std::span<const double> y) {
  std::vector<double> a, b;
  std::optional<std::size_t> first;  // logarithms are of ratios to it, which have no units
  for (std::size_t i = 0; i < x.size() && i < y.size(); ++i) {
    if (!(x[i] > 0.0 && y[i] > 0.0 && std::isfinite(x[i]) && std::isfinite(y[i]))) continue;
    first = first.value_or(i);
    a.push_back(std::log(x[i] / x[*first]));
    b.push_back(std::log(y[i] / y[*first]));
  }
  const auto n = static_cast<double>(a.size());
  if (a.size() < 2) return std::nullopt;
  double mean_a = 0.0, mean_b = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) mean_a += a[i] / n, mean_b += b[i] / n;
  double square = 0.0, product = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    square += (a[i] - mean_a) * (a[i] - mean_a);
    product += (a[i] - mean_a) * (b[i] - mean_b);
  }
  if (square == 0.0) return std::nullopt;
  ObservedOrder result{product / square, 0.0};
  if (a.size() == 2) return result;
  double scatter = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double residual = b[i] - mean_b - result.order * (a[i] - mean_a);
    scatter += residual * residual;
  }
  result.standard_error = std::sqrt(scatter / (n - 2.0) / square);
  return result;
}

namespace {

Recording sound_recording(const Solver& solver, const Case& run) {
  Recording recording = solver(run);
  if (const auto problem = fault(recording, run))
    throw std::invalid_argument(fmt::format("{}: {}", recording.label, *problem));
  return recording;
}

// No floor: only the solver knows the share of rounding and tolerances in an error.
void judge(OrderStudy& study, Refine what) {
  study.what = what;
  study.displacement_l2 = study.errors(&exact::Error::displacement_l2).order();
  study.velocity_l2 = study.errors(&exact::Error::velocity_l2).order();
  study.end_trace = study.errors(&exact::Error::end_trace).order();
  study.reaction_l1 = study.errors(&exact::Error::reaction_l1).order();
}

}  // namespace

std::vector<Case> refinements(const Case& coarsest, Refine what, std::size_t levels) {
  if (what != Refine::mesh && !coarsest.step) throw std::invalid_argument("the case has no step that could be refined");
  std::vector<Case> cases;
  Case run = coarsest;
  for (std::size_t level = 0; level < levels; ++level) {
    cases.push_back(run);
    if (what != Refine::step) run.elements *= 2;
    if (what != Refine::mesh) *run.step /= 2.0;
  }
  return cases;
}

Sequence OrderStudy::errors(double exact::Error::*quantity) const {
  Sequence sequence;
  sequence.within = Sequence::by_few;
  for (const Row& row : rows)
    sequence.add(what == Refine::mesh ? 1.0 / static_cast<double>(row.elements) : row.step.value_or(0.0),
                 row.error.*quantity, 0.0);
  return sequence;
}

OrderStudy order_study(const Solver& solver, const exact::Solution& solution, std::span<const Case> cases, Refine what,
                       std::size_t threads) {
  OrderStudy study;
  study.rows.resize(cases.size());
  parallel_for(
      cases.size(),
      [&](std::size_t i) {
        study.rows[i] = {cases[i].elements, cases[i].step, exact::error(sound_recording(solver, cases[i]), solution)};
      },
      threads);
  judge(study, what);
  return study;
}

OrderStudy self_study(const Solver& solver, std::span<const Case> cases, std::size_t threads) {
  std::vector<Recording> recordings(cases.size());
  parallel_for(
      cases.size(), [&](std::size_t i) { recordings[i] = sound_recording(solver, cases[i]); }, threads);
  OrderStudy study;
  for (std::size_t i = 0; i + 1 < cases.size(); ++i) {
    const Difference change = compare(recordings[i], recordings[i + 1]);
    study.rows.push_back({cases[i].elements,
                          cases[i].step,
                          {change.displacement_l2.value_or(0.0), change.velocity_l2.value_or(0.0), change.end_trace}});
  }
  judge(study, Refine::step);
  return study;
}

}  // namespace viscobar
