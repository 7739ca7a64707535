#include "sensitivity/random_fits.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <unsupported/Eigen/NonLinearOptimization>

#include "campaign/draw.hpp"
#include "studies/fit/noise.hpp"
#include "studies/fit/search.hpp"
#include "support/maximum_norm.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar::random_fits {

using campaign::Draw;

namespace {

struct Values {
  double viscosity, modulus, gap, speed;
};
constexpr double Values::*members[] = {&Values::viscosity, &Values::modulus, &Values::gap, &Values::speed};
constexpr const char* keys[] = {"bar.viscosity", "bar.modulus", "left.gap", "parameters.speed"};

double value_of(TraceColumn column, std::span<const double> u, std::span<const double> v, double reaction) {
  const bool left = column <= TraceColumn::reaction_left;
  if (column == TraceColumn::reaction_left || column == TraceColumn::reaction_right) return reaction;
  const auto field = column == TraceColumn::u_left || column == TraceColumn::u_right ? u : v;
  return left ? field.front() : field.back();
}

// The residuals of a study for MINPACK's lmder, which shares nothing with the search of fit(), in the logarithms of the
// parameters. docs/fit.md defines what is compared.
struct Residuals {
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  static constexpr int InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic;

  const FitStudy& study;
  double least = std::numeric_limits<double>::infinity();  // S

  int inputs() const { return static_cast<int>(study.parameters.size()); }
  int values() const { return static_cast<int>(study.traces.size() * study.times.size()); }

  // A run that fails, takes too many steps or has values far from where the search begins is far from any data.
  int operator()(const InputType& logarithms, ValueType& residual) {
    JacobianType none;
    compare(logarithms, residual, none, false);
    least = std::min(least, residual.squaredNorm());
    return 0;
  }
  int df(const InputType& logarithms, JacobianType& jacobian) {
    ValueType residual(values());
    jacobian.setZero(values(), inputs());
    if (!study.differences && compare(logarithms, residual, jacobian, true)) return 0;
    compare(logarithms, residual, jacobian, false);
    for (int k = 0; k < inputs(); ++k) {
      InputType beside = logarithms;
      beside(k) += 1e-4;
      ValueType other(values());
      compare(beside, other, jacobian, false);
      jacobian.col(k) = (other - residual) / 1e-4;
    }
    return 0;
  }

  // Returns whether there are all derivatives.
  bool compare(const InputType& logarithms, ValueType& residual, JacobianType& jacobian, bool derivatives) const {
    std::vector<double> at(logarithms.begin(), logarithms.end());
    bool far = false;
    for (std::size_t k = 0; k < at.size(); ++k) {
      at[k] = std::exp(at[k]);
      far = far || !(std::abs(std::log(at[k] / study.parameters[k].start)) < std::log(1e4));
    }
    residual.setConstant(1e6);
    if (far) return true;
    Recording run;
    try {
      Case model = study.model(at);
      if (!derivatives) model.directions.clear();
      Observers observers;
      observers.off_the_clock = false;
      observers.directions = model.directions;
      observers.snapshot = [&](const Snapshot& at_time) { run.keep(at_time, model.directions); };
      observers.event = [&](const Event& event) { run.events.push_back(event); };
      observers.progress = [&, steps = 0](double) mutable {
        return ++steps > 20'000 ? RunControl::stop : RunControl::go_on;
      };
      run.mesh = model.mesh();
      if (!simulate(resolve(model), study.times, observers).completed) return true;
    } catch (const std::exception&) {
      return true;
    }
    int row = 0;
    bool all = true;
    for (const MeasuredTrace& trace : study.traces) {
      const bool jumps = trace.column != TraceColumn::u_left && trace.column != TraceColumn::u_right;
      const std::size_t last = run.times.size() - 1, nodes = run.mesh.nodes();
      const auto of = [&](std::size_t k, const auto& of_run) {
        const auto part = [&](const std::vector<double>& field) { return std::span(field).subspan(k * nodes, nodes); };
        return value_of(trace.column, part(of_run.u), part(of_run.v), of_run.reaction_left[k]);
      };
      for (std::size_t k = 0; k <= last; ++k, ++row) {
        // The nearest change of contact, as a part of the way to the next sample.
        double share = 0.0, per_time = 0.0;
        const Event* nearest = nullptr;
        for (const Event& event : run.events) {
          const double to = run.times[k] - event.time, part = to > 0.0
                                                                  ? run.times[k] - run.times[k - (k > 0)]
                                                                  : run.times[std::min(k + 1, last)] - run.times[k];
          if (jumps && std::abs(to) < part && 1.0 - std::abs(to) / part > share)
            share = 1.0 - std::abs(to) / part, per_time = (to > 0.0 ? 1.0 : -1.0) / part, nearest = &event;
        }
        const double own = of(k, run);
        double difference = own - trace.values[k];
        std::size_t with = k;
        for (const std::size_t near : {k - (k > 0), std::min(k + 1, last)}) {
          const double other = own + share * (of(near, run) - own) - trace.values[k];
          if (std::signbit(other) != std::signbit(difference)) difference = 0.0;
          if (std::abs(other) < std::abs(difference)) difference = other, with = near;
        }
        residual(row) = difference / trace.deviation;
        for (int j = 0; derivatives && difference != 0.0 && j < inputs(); ++j) {
          const double here = of(k, run.sensitivities[j]);
          double slope = here;
          if (with != k)
            slope += share * (of(with, run.sensitivities[j]) - here) +
                     per_time * nearest->sensitivities[j].time * (of(with, run) - own);
          jacobian(row, j) = at[j] * slope / trace.deviation;
          all = all && std::isfinite(jacobian(row, j));
        }
      }
    }
    return all;
  }
};

// The data of a run on so many times the elements, with noise: the columns of the study, or as many contact changes.
void take_from_finer(RandomFit& one, Draw& draw, std::size_t factor = 8, std::size_t changes = 0) {
  FitStudy& study = one.study;
  for (MeasuredTrace& trace : study.traces) trace.values.assign(study.times.size(), 0.0);
  Case run = study.model(one.truth);
  run.elements *= factor;
  run.directions.clear();
  const fitting::Misfit finer = fitting::measure(study, run, fitting::Compared::exact, false, 10'000'000);
  const auto& made = finer.traces;
  for (std::size_t i = 0; i < made.size(); ++i) {
    double largest = 0.0;
    for (const double value : made[i]) largest = std::max(largest, std::abs(value));
    study.traces[i].deviation = largest > 0.0 ? 0.01 * largest : 1.0;
    for (std::size_t k = 0; k < made[i].size(); ++k)
      study.traces[i].values[k] = made[i][k] + one.noise * largest * draw.normal();
  }
  if (changes == 0 || finer.changes.empty()) return;
  study.traces.clear(), study.times.clear();
  study.changes.assign(finer.changes.begin(), finer.changes.begin() + std::min(changes, finer.changes.size()));
  study.change_deviation = 0.01 * study.changes.back().time;
  for (Event& change : study.changes)
    change.time = std::max(0.0, change.time + 30.0 * one.noise * study.change_deviation * draw.normal());
  std::ranges::stable_sort(study.changes, {}, &Event::time);
}

std::vector<double> times_to(double end, std::size_t count = 150) {
  std::vector<double> times;
  for (std::size_t k = 0; k <= count; ++k) times.push_back(end * static_cast<double>(k) / static_cast<double>(count));
  return times;
}

using Named = std::pair<std::string, double>;

// Looks for one or two of these values of a scene, that of `otherwise` if for no other, and holds the rest. Restitution
// is among them where it is `always`.
void choose(RandomFit& made, Draw& draw, const std::string& scene, std::vector<Named> values, std::size_t otherwise,
            bool always = false) {
  std::vector<Named> fitted;
  std::vector<std::string> held;
  const std::size_t most = always ? 1 : 2;
  for (const Named& one : values)
    if ((draw.chance(0.4) && fitted.size() < most) || (always && one.first == "contact.restitution"))
      fitted.push_back(one);
    else
      held.push_back(fmt::format("{}={}", one.first, one.second));
  if (fitted.empty()) fitted.push_back(values[otherwise]), held.erase(held.begin() + std::ptrdiff_t(otherwise));
  std::vector<std::string> sought;
  for (const auto& [key, value] : fitted) {
    sought.push_back(key);
    made.truth.push_back(value);
    const double low = key.ends_with("modulus") ? 1e-300 : 0.0;
    made.study.parameters.push_back({key, 0.0, low, key.ends_with("restitution") ? 1.0 : INFINITY});
  }
  made.study.model = [=](std::span<const double> given) {
    std::vector<std::string> settings = held;
    for (std::size_t k = 0; k < sought.size(); ++k) settings.push_back(fmt::format("{}={}", sought[k], given[k]));
    settings.push_back(fmt::format("sensitivity.of=[\"{}\"]", fmt::join(sought, "\",\"")));
    return parse_scene(scene, "", settings).run;
  };
}

void begin_within_ten(RandomFit& made, Draw& draw) {
  for (std::size_t k = 0; k < made.truth.size(); ++k) {
    FittedParameter& one = made.study.parameters[k];
    one.start = std::min(made.truth[k] * draw.decades(0.1, 10.0), one.high);
    made.words += fmt::format(", {} {:.4g} from {:.4g}", one.key, made.truth[k], one.start);
  }
}

// Two bars that meet, by the force of their joint.
RandomFit random_chain(Draw draw) {
  RandomFit made;
  const double end = draw.between(1.5, 5.0);
  const std::size_t elements = draw.one_of({24, 40, 60});
  const auto [length, density, far_speed] =
      std::tuple(draw.between(0.5, 1.5), draw.decades(0.5, 2.0), draw.chance(0.5) ? draw.between(-0.5, 0.0) : 0.0);
  const std::vector<Named> values = {{"bar.1.viscosity", draw.decades(0.02, 0.5)},
                                     {"bar.2.modulus", draw.decades(0.3, 3.0)},
                                     {"joint.1.gap", draw.between(0.02, 0.3)},
                                     {"bar.2.viscosity", draw.decades(0.02, 0.5)}};
  std::string scene = fmt::format(
      "[[bar]]\nlength = 1.0\nvelocity = 1.0\n[[bar]]\nlength = {}\ndensity = {}\nvelocity = {}\n[[joint]]\nkind = "
      "\"contact\"\n[mesh]\nelements = {}\n[method]\nname = \"rigid\"\n[time]\nend = {}\n",
      length, density, far_speed, elements, end);
  choose(made, draw, scene, values, 1);
  made.study.times = times_to(end);
  made.study.traces.push_back({TraceColumn::force_of, {}, 1.0, true, 1.0});
  made.noise = draw.chance(0.5) ? 0.01 : 0.0;
  made.words = fmt::format("{} elements, end {:.3g}, noise {}, force:1", elements, end, made.noise);
  begin_within_ten(made, draw);
  take_from_finer(made, draw);
  return made;
}

// A few data of a bar that is thrown at an obstacle, or of one that bounces on it with a mass at its end.
RandomFit random_few(Draw draw) {
  RandomFit made;
  const bool bounces = draw.chance(0.5);
  const double end = draw.between(1.5, 5.0);
  const std::size_t elements = draw.one_of({10, 20, 30}), samples = draw.one_of({12, 16, 20, 24, 36, 60});
  std::string scene = fmt::format(
      "[bar]\nlength = 1.0\n[left]\nkind = \"obstacle\"\n[mesh]\nelements = {}\n[method]\nname = \"rigid\"\n"
      "[time]\nend = {}\n",
      elements, end);
  std::vector<Named> values = {{"bar.viscosity", draw.decades(0.02, 0.5)},
                               {"bar.modulus", draw.decades(0.3, 3.0)},
                               {"left.gap", draw.between(0.02, 0.5)}};
  if (bounces) {
    scene += fmt::format("[load]\ndensity = {}\n", -draw.between(0.5, 3.0));
    values.emplace_back("left.mass", draw.decades(0.3, 3.0));
    values.emplace_back("contact.restitution", draw.between(0.1, 0.8));
  } else {
    scene += fmt::format("[initial]\nvelocity = \"-{}*(1+{}*x)\"\n", draw.decades(0.3, 3.0),
                         draw.chance(0.3) ? 0.0 : draw.between(0.0, 0.5));
  }
  choose(made, draw, scene, values, 2);
  const bool is_events = draw.chance(0.2);
  const auto column = draw.one_of({TraceColumn::v_left, TraceColumn::v_right, TraceColumn::reaction_left});
  const std::size_t changes = is_events ? draw.one_of({1, 2, 3, 4, 6}) : 0, factor = draw.one_of({1, 4});
  made.study.times = times_to(end, samples);
  made.study.traces.push_back({column, {}, 1.0, true});
  made.noise = draw.chance(0.5) ? 0.01 : 0.0;
  made.words =
      fmt::format("{} elements, end {:.3g}, noise {}, {} of {} times the elements{}", elements, end, made.noise,
                  is_events ? fmt::format("{} changes", changes) : fmt::format("{} {}", samples, name(column)), factor,
                  bounces ? ", bouncing" : "");
  begin_within_ten(made, draw);
  take_from_finer(made, draw, factor, changes);
  return made;
}

// A lone mass, or a bar with one at its end, that bounces until it rests.
RandomFit random_bounces(Draw draw) {
  RandomFit made;
  const bool alone = draw.chance(0.5);
  const double gap = draw.between(0.02, 0.5), load = draw.between(0.5, 3.0), restitution = draw.between(0.2, 0.95);
  const double fall = std::sqrt(2.0 * gap / load);
  // A lone mass rests at fall (1 + e) / (1 - e).
  const double end = fall * (1.0 + draw.between(0.3, 1.2) * 2.0 * restitution / (1.0 - restitution));
  const std::size_t elements = alone ? 2 : draw.one_of({10, 20, 30}), samples = draw.one_of({24, 60, 150});
  std::string scene = fmt::format(
      "bar.length = 2.0\nbar.modulus = {}\nleft.kind = \"obstacle\"\nmesh.elements = {}\nmethod.name = \"rigid\"\n"
      "time.end = {}\nload.density = {}\nmesh.mass = \"{}\"\nright.kind = \"{}\"\n",
      alone ? 1e-12 : 1.0, elements, end, -load, alone ? "lumped" : "consistent", alone ? "fixed" : "free");
  std::vector<Named> values = {{"left.gap", gap}, {"contact.restitution", restitution}};
  if (!alone) {
    values.emplace_back("left.mass", draw.decades(0.3, 3.0));
    values.emplace_back("bar.modulus", draw.decades(0.3, 3.0));
    values.emplace_back("bar.viscosity", draw.decades(0.02, 0.5));
  }
  choose(made, draw, scene, values, 1, true);
  const bool is_events = draw.chance(0.5);
  const auto column = draw.one_of({TraceColumn::v_left, TraceColumn::v_right, TraceColumn::u_left});
  const std::size_t changes = is_events ? draw.one_of({3, 4, 6, 10, 20, 100}) : 0, factor = draw.one_of({2, 4});
  made.study.times = times_to(end, samples);
  made.study.traces.push_back({alone && column == TraceColumn::v_right ? TraceColumn::v_left : column, {}, 1.0, true});
  made.noise = draw.chance(0.5) ? 0.01 : 0.0;
  made.words = fmt::format(
      "{} elements, end {:.3g}, noise {}, {} of {} times the elements", elements, end, made.noise,
      is_events ? fmt::format("{} changes", changes) : fmt::format("{} {}", samples, name(made.study.traces[0].column)),
      factor);
  begin_within_ten(made, draw);
  take_from_finer(made, draw, factor, changes);
  return made;
}

}  // namespace

RandomFit random_fit(std::uint64_t seed, std::size_t index, Data data) {
  Draw draw(seed, index);
  if (data == Data::forces) return random_chain(draw);
  if (data == Data::few) return random_few(draw);
  if (data == Data::bounces) return random_bounces(draw);
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

  const std::size_t elements = data == Data::any ? 12 : draw.one_of({12, 20, 30, 60});
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
    run.elements = elements;
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
  const double noise = made.noise = draw.chance(0.5) ? 0.01 : 0.0;
  made.words = fmt::format("{} of {} on {}, noise {},", name(method), end, elements, noise);
  const auto is_asked = [&](TraceColumn column) {
    return data == Data::any ||
           (data == Data::reactions ? column == TraceColumn::reaction_left : fitting::is_velocity(column));
  };
  for (const TraceColumn column : {TraceColumn::u_left, TraceColumn::v_left, TraceColumn::reaction_left,
                                   TraceColumn::u_right, TraceColumn::v_right, TraceColumn::reaction_right}) {
    if (!is_asked(column)) continue;
    if (data == Data::any && !draw.chance(column == TraceColumn::u_left ? 0.7 : 0.4) &&
        !(study.traces.empty() && column == TraceColumn::u_right))
      continue;
    if (column == TraceColumn::reaction_right) continue;  // of a free end
    MeasuredTrace trace{column, {}, 1.0, true};
    for (std::size_t k = 0; k < exact.times.size(); ++k)
      trace.values.push_back(value_of(column, exact.displacement(k), exact.velocity(k), exact.reaction_left[k]));
    const double largest = viscobar::largest(trace.values);
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
  if (data != Data::any) take_from_finer(made, draw);
  return made;
}

double least_of_starts(const RandomFit& one, std::size_t starts) {
  Residuals residuals{one.study};
  Draw draw(77, one.study.times.size() * 1000 + starts);
  for (std::size_t i = 0; i <= starts; ++i) {
    Eigen::VectorXd at(one.truth.size());
    for (std::size_t k = 0; k < one.truth.size(); ++k)
      at(k) = std::log(one.truth[k] * (i == 0 ? 1.0 : draw.decades(0.1, 10.0)));
    Eigen::LevenbergMarquardt<Residuals> search(residuals);
    search.parameters.maxfev = 60;
    search.parameters.ftol = search.parameters.xtol = 1e-6;  // to which the model is computed
    search.minimize(at);
  }
  return residuals.least;
}

Judged against_truth(const RandomFit& one, const FitResult& found, double floor) {
  Judged judged;
  for (std::size_t k = 0; k < one.truth.size(); ++k) {
    const auto& [key, estimate, deviation, bound] = found.parameters[k];
    judged.told += fmt::format("{:.7g} +- {:.2g}, ", estimate, deviation);
    if (std::isnan(deviation)) continue;
    // Four deviations of few data are as improbable as Student says; the model's own error has its size anyway.
    constexpr double four = 6.33e-5;
    const double error = found.model_errors[k],
                 noise = std::sqrt(std::max(deviation * deviation - error * error, 0.0)) *
                         fitting::students_bound(1.0 - four, found.freedom) / 4.0;
    judged.off = std::max(judged.off,
                          std::abs(estimate - one.truth[k]) / std::max(std::hypot(noise, error), floor * one.truth[k]));
  }
  judged.found = true;
  judged.converged = found.converged;
  judged.runs = found.runs;
  judged.told += fmt::format("{}", fmt::join(found.warnings, "; "));
  return judged;
}

Judged judge(const RandomFit& one, std::size_t starts, double floor) {
  const double best = least_of_starts(one, starts);
  const FitResult found = fit(one.study);
  double least = std::numeric_limits<double>::infinity();
  for (const double sum : found.sums) least = std::fmin(least, sum);
  const auto measured = static_cast<double>(found.measured), freedom = static_cast<double>(found.freedom);
  // Values of the model are right to their tolerance of 1e-6, a deviation is a hundredth of the largest: each of m
  // residuals r is uncertain by d = 1e-4, S by m d^2 + 2 |r| d m^(1/2). The search ends where a step changes less than
  // 1e-3 of a deviation, a millionth of a variance. A scheme has a contact change at one of its steps, and that decides
  // of how much of its neighbours a sample beside it is compared with: step / interval of a variance for each of these
  // two samples.
  constexpr double uncertain = 1e-4;
  const Case run = one.study.model(one.truth);
  const double in_a_step =
      run.step ? 2.0 * static_cast<double>(found.changes.size()) * *run.step / run.output_every : 0.0;
  const double variance = best / freedom, tolerance = measured * uncertain * uncertain +
                                                      2.0 * std::sqrt(best * measured) * uncertain +
                                                      in_a_step * variance;
  Judged judged = against_truth(one, found, floor);
  judged.found = least - best <= tolerance + 1e-6 * variance;
  judged.excess = (least - best) / std::max(variance, 1e-4);
  return judged;
}

// A thousandth of a deviation, 1e-5 of the largest value, is a residual that a fit does not look behind.
Judged distance(const RandomFit& one) { return against_truth(one, fit(one.study), 1e-5); }

}  // namespace viscobar::random_fits
