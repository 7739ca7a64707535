// Prints the table behind "May a contact pull while it opens?" of docs/penalty-limit.md. Run:
// build/release/tests/measure_limit
#include "viscobar/studies/limit/limit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "support/paper_throw.hpp"
#include "viscobar/case/end_traces.hpp"
#include "viscobar/dynamics/penalty_law.hpp"

namespace {

using namespace viscobar;

LimitResult study(const Case& scene, std::vector<double> epsilons) {
  LimitStudy limit;
  limit.scene = scene;
  limit.epsilons = std::move(epsilons);
  limit.budget = 0.0;  // the tables are of the steps that they name
  return limit_of(limit);
}

// "1e-3 / 1e-4 / ..."
std::string differences(const LimitResult& result) {
  std::string text;
  for (const LimitRow& row : result.rows)
    text += fmt::format("{}{:.2e}", text.empty() ? "" : " / ", row.difference_to_scheme);
  return text;
}

// A dashpot whose contact is cut off where its reaction reaches zero, R = max(0, d/epsilon + b d'): the classical
// Runge-Kutta method with steps so small that changes need not be located. The library's contact may pull.
struct CutOff {
  double restitution, ratio;

  // e = exp(-2 zeta acos(zeta) / sqrt(1 - zeta^2)), acosh and sqrt(zeta^2 - 1) beyond 1
  static double restitution_of(double zeta) {
    if (zeta < 1.0) return std::exp(-2 * zeta * std::acos(zeta) / std::sqrt(1 - zeta * zeta));
    return zeta == 1.0 ? std::exp(-2.0) : std::exp(-2 * zeta * std::acosh(zeta) / std::sqrt(zeta * zeta - 1));
  }
  static CutOff with_restitution(double e) {
    double low = 0.0, high = 1e3;
    for (int i = 0; i < 200; ++i) (restitution_of((low + high) / 2) > e ? low : high) = (low + high) / 2;
    return {e, low};
  }
};

EndTraces run_cut_off(const Case& run, const CutOff& law, double step, std::vector<double>& times) {
  const BarSystem system = resolve(run).system();
  const std::size_t n = system.size();
  const double mass = system.inertia().effective_masses().front(), stiffness = 1.0 / *run.epsilon;
  const double damping = 2.0 * law.ratio * std::sqrt(stiffness * mass), gap = 0.1;
  State state = system.initial_state();
  std::vector<double> a(n), u(n), v(n), du(n), dv(n);
  const auto accelerate = [&](const std::vector<double>& at, const std::vector<double>& rate) {
    system.internal_force(at, rate, a);
    for (const std::size_t i : {std::size_t{0}, n - 1}) {
      const double d = -(at[i] + gap);
      if (d > 0.0) a[i] += std::max(0.0, stiffness * d - damping * rate[i]);
    }
    system.inertia().accelerate(a);
  };
  EndTraces traces;
  times.clear();
  const auto steps = static_cast<std::size_t>(std::llround(run.end / step));
  for (std::size_t k = 0; k <= steps; ++k) {
    if (k % 10 == 0) {
      times.push_back(static_cast<double>(k) * step);
      traces.left.push_back(state.u.front());
      traces.right.push_back(state.u.back());
      traces.statistics.max_penetration = std::max(traces.statistics.max_penetration, -(state.u.front() + gap));
    }
    constexpr double share[] = {0.0, 0.5, 0.5, 1.0}, weight[] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    std::vector<double> sum_u(n), sum_v(n);
    for (int stage = 0; stage < 4; ++stage) {
      for (std::size_t i = 0; i < n; ++i) {
        u[i] = state.u[i] + share[stage] * step * du[i] * (stage > 0);
        v[i] = state.v[i] + share[stage] * step * dv[i] * (stage > 0);
      }
      accelerate(u, v);
      du = v;
      dv = a;
      for (std::size_t i = 0; i < n; ++i) sum_u[i] += weight[stage] * du[i], sum_v[i] += weight[stage] * dv[i];
    }
    for (std::size_t i = 0; i < n; ++i) state.u[i] += step * sum_u[i], state.v[i] += step * sum_v[i];
  }
  return traces;
}

void pulling_or_cut_off() {
  fmt::print(
      "\n### A dashpot that may pull while it opens, and one cut off at zero reaction; alpha = 0.01, T = 2.4\n\n| law "
      "| e | zeta | difference to the scheme at epsilon = 1e-3 / 1e-4 / 1e-5 |\n|---|---|---|---|\n");
  const std::vector<double> epsilons = decades(1e-3, 1e-5);
  for (const double e : {0.0, 0.25, 0.5}) {
    Case scene = paper_throw(0.01);
    scene.end = 2.4;
    scene.restitution = e;
    scene.step = 1e-6;
    fmt::print("| may pull | {} | {:.3f} | {} |\n", e, damping_ratio(e), differences(study(scene, epsilons)));
    std::vector<CutOff> laws;
    if (e > 0.0)
      laws.push_back(CutOff::with_restitution(e));
    else
      for (const double zeta : {1.0, 5.0, 20.0}) laws.push_back({CutOff::restitution_of(zeta), zeta});
    for (const CutOff& law : laws) {
      std::string found;
      for (const double epsilon : epsilons) {
        scene.epsilon = epsilon;
        std::vector<double> times;
        const EndTraces cut = run_cut_off(scene, law, 2e-6, times);
        Case scheme = scene;
        scheme.method = MethodName::fully_discrete;
        found +=
            fmt::format("{}{:.2e}", found.empty() ? "" : " / ", largest_difference(cut, trace_ends(scheme, times)));
      }
      fmt::print("| cut off | {:.3g} (scheme {}) | {:.3f} | {} |\n", law.restitution, e, law.ratio, found);
    }
  }
}

}  // namespace

int main() {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // tables as they come, also into a file
  pulling_or_cut_off();
}
