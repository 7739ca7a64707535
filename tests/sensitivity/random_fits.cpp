#include "sensitivity/random_fits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "viscobar/case/recording.hpp"

namespace viscobar::random_fits {

namespace {

class Draw {
 public:
  Draw(std::uint64_t seed, std::size_t index) : engine_(seed * 1'000'003 + index) { engine_.discard(16); }
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  double decades(double low, double high) { return std::pow(10.0, between(std::log10(low), std::log10(high))); }
  bool chance(double p) { return between(0.0, 1.0) < p; }
  double normal() {  // of the sum of twelve
    double sum = -6.0;
    for (int k = 0; k < 12; ++k) sum += between(0.0, 1.0);
    return sum;
  }

 private:
  std::mt19937_64 engine_;
};

struct Values {
  double viscosity, modulus, gap, speed;
};
constexpr double Values::*members[] = {&Values::viscosity, &Values::modulus, &Values::gap, &Values::speed};
constexpr const char* keys[] = {"bar.viscosity", "bar.modulus", "left.gap", "parameters.speed"};

}  // namespace

RandomFit random_fit(std::uint64_t seed, std::size_t index) {
  Draw draw(seed, index);
  Values truth{draw.decades(0.02, 0.5), draw.decades(0.3, 3.0), draw.between(0.02, 0.5), draw.decades(0.3, 3.0)};
  const double kind = draw.between(0.0, 1.0), bend = draw.between(0.0, 0.5), end = draw.between(1.5, 5.0);
  const double force = draw.chance(0.3) ? draw.between(-0.5, 0.5) : 0.0,
               load = draw.chance(0.3) ? -draw.between(0.0, 1.0) : 0.0;
  const MethodName method = kind < 0.7    ? MethodName::rigid
                            : kind < 0.8  ? MethodName::arkode
                            : kind < 0.92 ? MethodName::fully_discrete
                                          : MethodName::characteristics;
  if (method == MethodName::characteristics) truth.viscosity = 0.0;
  std::vector<std::size_t> which;
  for (std::size_t k = method == MethodName::characteristics ? 1 : 0; k < 4; ++k)
    if (draw.chance(0.45) && which.size() < 3) which.push_back(k);
  if (which.empty()) which.push_back(2);

  const auto bar = [=](const Values& values) {
    Case run;
    run.scene.bar.viscosity = values.viscosity;
    run.scene.bar.modulus = values.modulus;
    run.scene.left = Obstacle{values.gap};
    run.scene.displacement = [](double) { return 0.0; };
    run.scene.velocity = [speed = values.speed, bend](double x) { return -speed * (1.0 + bend * x); };
    if (load != 0.0) run.scene.load = SteadyLoad{[load](double) { return load; }};
    if (force != 0.0)
      run.scene.right_input.force = EndForce{[force](double t) { return force * std::sin(3.0 * t); }, {}, false};
    run.elements = 12;
    run.method = method;
    if (method == MethodName::arkode) run.epsilon = 1e-3;
    if (method == MethodName::fully_discrete) run.step = 2e-3;
    run.end = end;
    run.output_every = end / 150.0;
    return run;
  };
  RandomFit made;
  FitStudy& study = made.study;
  study.differences = method == MethodName::fully_discrete || method == MethodName::characteristics;
  study.model = [=](std::span<const double> given) {
    Values values = truth;
    for (std::size_t k = 0; k < which.size(); ++k) values.*members[which[k]] = given[k];
    Case run = bar(values);
    if (!study.differences)
      for (const std::size_t k : which) {
        Direction along = direction(run, k == 3 ? "bar.density" : keys[k]);
        if (k == 3) along.bar.density = 0.0, along.data.velocity = [bend](double x) { return -(1.0 + bend * x); };
        run.directions.push_back(along);
      }
    return run;
  };
  const Recording exact = record(bar(truth));
  study.times = exact.times;
  const double noise = draw.chance(0.5) ? 0.01 : 0.0;
  made.words = fmt::format("{} of {}, noise {},", name(method), end, noise);
  for (const TraceColumn column : all_trace_columns) {
    if (!draw.chance(column == TraceColumn::u_left ? 0.7 : 0.4) &&
        !(study.traces.empty() && column == TraceColumn::u_right))
      continue;
    if (column == TraceColumn::reaction_right) continue;  // of a free end
    MeasuredTrace trace{column, {}, 1.0, true};
    for (std::size_t k = 0; k < exact.times.size(); ++k) {
      const bool left = column <= TraceColumn::reaction_left;
      const auto node = [&](std::span<const double> field) { return left ? field.front() : field.back(); };
      trace.values.push_back(column == TraceColumn::reaction_left ? exact.reaction_left[k]
                             : column == TraceColumn::u_left || column == TraceColumn::u_right
                                 ? node(exact.displacement(k))
                                 : node(exact.velocity(k)));
    }
    double largest = 0.0;
    for (const double value : trace.values) largest = std::max(largest, std::abs(value));
    if (!(largest > 0.0)) continue;
    trace.deviation = 0.01 * largest;
    for (double& value : trace.values) value += noise * largest * draw.normal();
    study.traces.push_back(trace);
    made.words += fmt::format(" {}", name(column));
  }
  for (const std::size_t k : which) {
    const double factor = draw.decades(0.1, 10.0);
    made.truth.push_back(truth.*members[k]);
    const double low = k == 1 || k == 3 ? std::numeric_limits<double>::min() : 0.0;
    study.parameters.push_back({keys[k], made.truth.back() * factor, low});
    made.words += fmt::format(", {} {:.4g} from {:.4g}", keys[k], made.truth.back(), study.parameters.back().start);
  }
  return made;
}

Judged judge(const RandomFit& one) {
  FitStudy from_truth = one.study;
  for (std::size_t k = 0; k < one.truth.size(); ++k) from_truth.parameters[k].start = one.truth[k];
  const FitResult best = fit(from_truth), found = fit(one.study);
  const auto least = [](const FitResult& result) {
    double sum = std::numeric_limits<double>::infinity();
    for (const double start : result.sums)
      if (start < sum) sum = start;
    return sum;
  };
  Judged judged;
  const double variance = std::max(best.residual * best.residual, 1e-4);
  judged.excess = (least(found) - least(best)) / variance;
  judged.found = judged.excess <= 0.1;
  judged.converged = found.converged;
  judged.runs = found.runs;
  return judged;
}

}  // namespace viscobar::random_fits
