// Prints tables behind docs/penalty-limit.md, but that of the redistributions. Run:
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
#include "viscobar/studies/exact/exact_solutions.hpp"

namespace {

using namespace viscobar;

std::string order(const std::optional<SequenceOrder>& found) {
  return found ? fmt::format("{:.3f} +- {:.3f}", found->order, found->standard_error) : "-";
}

LimitResult study(const Case& scene, std::vector<double> epsilons) {
  LimitStudy limit;
  limit.scene = scene;
  limit.epsilons = std::move(epsilons);
  limit.budget = 0.0;  // the tables are of the steps that they name
  return limit_of(limit);
}

// "1e-3 / 1e-4 / ..."
template <class Value>
std::string listed(const LimitResult& result, Value value) {
  std::string text;
  for (const LimitRow& row : result.rows) text += (text.empty() ? "" : " / ") + value(row);
  return text;
}
std::string differences(const LimitResult& result) {
  return listed(result, [](const LimitRow& row) { return fmt::format("{:.2e}", row.difference_to_scheme); });
}
std::string changes(const LimitResult& result) {
  return listed(result, [](const LimitRow& row) { return fmt::format("{}", row.events); });
}

void papers_pair() {
  fmt::print(
      "\n### The paper's pair\n\n| alpha | epsilon | contact changes | largest penetration | difference to (2.8) |\n"
      "|---|---|---|---|---|\n");
  for (const double alpha : {0.01, 0.001}) {
    Case scene = paper_throw(alpha);
    scene.step = 1e-5;
    const LimitResult result = study(scene, decades(1e-2, 1e-6));
    for (const LimitRow& row : result.rows)
      fmt::print("| {} | {:.0e} | {} | {:.2e} | {:.2e} |\n", alpha, row.epsilon, row.events, row.max_penetration,
                 row.difference_to_scheme);
    fmt::print("\nVerdict `{}`; error of the scheme by its step {:.1e}; it has {} changes.\n\n",
               name(result.orders[0].verdict), result.orders[0].scheme_error, result.orders[0].scheme_events);
  }
}

void massless_nodes() {
  fmt::print(
      "\n### Contact nodes without mass\n\n| alpha | contact changes, 1e-4 ... 1e-8 | difference to rigid at 1e-4 / "
      "1e-6 / 1e-8 | its order | order of the penetration | difference to (2.8) at 1e-8, dt = 1e-5 | verdict "
      "|\n|---|---|---|---|---|---|---|\n");
  for (const double alpha : {1.0, 0.1, 0.01, 0.001, 0.0}) {
    Case scene = paper_throw(alpha);
    scene.mass = Mass::redistributed;
    scene.step = 1e-5;
    const LimitResult result = study(scene, decades(1e-4, 1e-8));
    fmt::print("| {} | {} | {:.2e} / {:.2e} / {:.2e} | {} | {} | {:.1e} | {} |\n", alpha, changes(result),
               *result.rows[0].difference_to_rigid, *result.rows[2].difference_to_rigid,
               *result.rows[4].difference_to_rigid, order(result.orders[0].to_rigid),
               order(result.orders[0].penetration), result.rows[4].difference_to_scheme,
               name(result.orders[0].verdict));
  }
}

void layer() {
  fmt::print(
      "\n### The layer resolved, alpha = 1, epsilon = 1e-3 ... 1e-5\n\n| elements | 100 h^3 | order of the penetration "
      "| of the difference to rigid | below h^3 / 100: of the penetration | of the difference to rigid "
      "|\n|---|---|---|---|---|---|\n");
  for (const std::size_t elements : {27u, 54u, 108u, 216u}) {
    Case scene = paper_throw(1.0);
    scene.mass = Mass::redistributed;
    scene.elements = elements;
    scene.step = 1e-4;
    const LimitOrders above = study(scene, decades(1e-3, 1e-5, 4)).orders[0];
    const double least = *above.boundary;
    const LimitOrders below = study(scene, decades(least / 100, least / 1000, 2)).orders[0];
    fmt::print("| {} | {:.1e} | {} | {} | {} | {} |\n", elements, 100 * least, order(above.penetration_layer),
               order(above.to_rigid_layer), order(below.penetration), order(below.to_rigid));
  }
}

void common_restitution() {
  fmt::print(
      "\n### One restitution on both sides, consistent mass, T = 6, dt = 1e-6\n\n| alpha | e | epsilon | difference to "
      "the scheme | its order | contact changes | scheme's |\n|---|---|---|---|---|---|---|\n");
  for (const double alpha : {0.01, 0.001, 0.0})
    for (const double e : {0.0, 0.25, 0.5, 1.0}) {
      Case scene = paper_throw(alpha);
      scene.restitution = e;
      scene.step = 1e-6;
      const LimitResult result = study(scene, alpha > 0.0 ? decades(1e-3, 1e-6) : decades(1e-4, 1e-8));
      fmt::print("| {} | {} | {} | {} | {} | {} | {} |\n", alpha, e, alpha > 0.0 ? "1e-3 ... 1e-6" : "1e-4 ... 1e-8",
                 differences(result), order(result.orders[0].to_scheme), changes(result),
                 result.orders[0].scheme_events);
    }
}

// Finer meshes at T = 2.4, epsilon = share h^3, dt = h^2 / 50: print(alpha, elements, dt, row, order in h).
template <class Print>
void by_mesh(double share, Print print) {
  for (const double alpha : {1.0, 0.1, 0.01}) {
    double previous = 0.0;
    for (const std::size_t elements : {27u, 54u, 108u, 216u}) {
      Case scene = paper_throw(alpha);
      scene.end = 2.4;
      scene.elements = elements;
      const double h = scene.mesh().spacing();
      scene.step = h * h / 50;
      const LimitRow row = study(scene, {share * h * h * h}).rows[0];
      print(alpha, elements, *scene.step, row,
            previous > 0.0 ? fmt::format("{:.2f}", std::log2(previous / row.difference_to_scheme)) : "-");
      previous = row.difference_to_scheme;
    }
  }
}

void joint_limit() {
  fmt::print(
      "\n### Joint limit on the consistent mass, undamped penalty, T = 2.4: epsilon = h^3 / 10, dt = h^2 / 50\n\n| "
      "alpha | elements | epsilon | dt "
      "| contact changes | difference to (2.8) | order in h |\n|---|---|---|---|---|---|---|\n");
  by_mesh(1.0 / 10, [](double alpha, std::size_t elements, double step, const LimitRow& row, const std::string& order) {
    fmt::print("| {} | {} | {:.1e} | {:.1e} | {} | {:.2e} | {} |\n", alpha, elements, row.epsilon, step, row.events,
               row.difference_to_scheme, order);
  });
}

// The plateau itself, epsilon far below what h asks for.
void plateau_by_mesh() {
  fmt::print(
      "\n### The plateau by the mesh, T = 2.4: epsilon = h^3 / 1000, dt = h^2 / 50\n\n| alpha | elements | difference "
      "to (2.8) | order in h |\n|---|---|---|---|\n");
  by_mesh(1.0 / 1000, [](double alpha, std::size_t elements, double, const LimitRow& row, const std::string& order) {
    fmt::print("| {} | {} | {:.2e} | {} |\n", alpha, elements, row.difference_to_scheme, order);
  });
}

void impact() {
  fmt::print(
      "\n### Impact on the penalty, alpha = 1, V = 0.7\n\n| epsilon | elements | largest penetration / (V "
      "epsilon^(2/3)) | by the law at this "
      "epsilon | as epsilon -> 0 |\n|---|---|---|---|---|\n");
  for (const double epsilon : {1e-3, 1e-4, 1e-5, 1e-6}) {
    const exact::ImpactLaw law{.bar = {1.0, 1.0, 1.0, 1.0}, .speed = 0.7, .epsilon = epsilon, .gap = 0.05};
    const double tau = std::pow(epsilon, 2.0 / 3.0);
    Case run;
    run.scene = law.scene();
    run.elements = static_cast<std::size_t>(10.0 / std::sqrt(tau));
    run.mass = Mass::redistributed;
    run.method = MethodName::ida;
    run.epsilon = epsilon;
    run.tolerance = {1e-8, 1e-11};
    run.end = run.output_every = law.closing() + 4 * tau;
    const double depth = simulate(resolve(run), {}).max_penetration;
    fmt::print("| {:.0e} | {} | {:.4f} | {:.4f} | 0.8580 |\n", epsilon, run.elements, depth / (0.7 * tau),
               law.peak()->penetration / (0.7 * tau));
  }
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
  const double mass = system.effective_masses().front(), stiffness = 1.0 / *run.epsilon;
  const double damping = 2.0 * law.ratio * std::sqrt(stiffness * mass), gap = 0.1;
  State state = system.initial_state();
  std::vector<double> a(n), u(n), v(n), du(n), dv(n);
  const auto accelerate = [&](const std::vector<double>& at, const std::vector<double>& rate) {
    system.internal_force(at, rate, a);
    for (const std::size_t i : {std::size_t{0}, n - 1}) {
      const double d = -(at[i] + gap);
      if (d > 0.0) a[i] += std::max(0.0, stiffness * d - damping * rate[i]);
    }
    system.accelerate(a);
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
  papers_pair();
  massless_nodes();
  layer();
  common_restitution();
  joint_limit();
  plateau_by_mesh();
  impact();
  pulling_or_cut_off();
}
