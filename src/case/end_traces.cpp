#include "viscobar/case/end_traces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace viscobar {

namespace {

constexpr std::size_t intervals = 16;  // of the traces between the ends

EndTraces empty_traces(const Case& run, std::size_t times) {
  EndTraces traces;
  traces.left.reserve(times);
  traces.right.reserve(times);
  if (run.scene.span) traces.between.resize(intervals - 1);
  for (std::size_t k = 0; k + 1 < run.scene.chain.size(); ++k)
    if (run.scene.chain[k].joint.kind != JointKind::bonded) traces.between.resize(traces.between.size() + 2);
  return traces;
}

void keep(const BarSystem& system, std::span<const double> u, EndTraces& traces) {
  traces.left.push_back(u.front());
  traces.right.push_back(u.back());
  for (std::size_t k = 0; k < system.elements().joints().size(); ++k)
    for (const std::size_t side : {0, 1})
      traces.between[2 * k + side].push_back(u[system.elements().joints()[k].node - 1 + side]);
  if (system.elements().is_chain()) return;
  const Mesh& mesh = system.mesh();
  for (std::size_t i = 0, e = 0; i < traces.between.size(); ++i) {
    const double x = mesh.length * static_cast<double>(i + 1) / intervals;
    while (mesh.node(e + 1) < x) ++e;
    const double part = (x - mesh.node(e)) / mesh.element(e);
    traces.between[i].push_back(std::lerp(u[e], u[e + 1], part));
  }
}

}  // namespace

EndTraces trace_ends(const Case& run, std::span<const double> times,
                     const std::function<RunControl(double time)>& progress) {
  const Setup setup = resolve(run);
  const BarSystem system = setup.system();
  EndTraces traces = empty_traces(run, times.size());
  Observers observers;
  observers.off_the_clock = observers.reactions = false;
  observers.snapshot = [&](const Snapshot& s) { keep(system, s.u, traces); };
  observers.event = [&](const Event& event) { traces.events.push_back(event); };
  observers.progress = progress;
  traces.statistics = simulate(setup, system, times, observers);
  return traces;
}

std::vector<Event> contact_changes(const Case& run) { return trace_ends(run, std::array{0.0, run.end}).events; }

double largest_difference(std::span<const double> a, std::span<const double> b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

double largest_difference(const EndTraces& a, const EndTraces& b) {
  double largest = 0.0;
  const auto of_a = EndTraces::all(a), of_b = EndTraces::all(b);
  for (std::size_t i = 0; i < of_a.size(); ++i) largest = std::max(largest, largest_difference(*of_a[i], *of_b[i]));
  return largest;
}

std::vector<double> comparison_times(double end, std::size_t uniform, std::span<const Event> changes) {
  constexpr double decades = 6.0;
  const double interval = end / static_cast<double>(uniform);
  std::vector<double> times;
  for (std::size_t k = 0; k < uniform; ++k) times.push_back(static_cast<double>(k) * interval);
  // A hundred a change are 15 % apart: a smooth maximum is then missed by less than 1 %. A chattering contact has its
  // largest differences after its hardest impacts.
  constexpr std::size_t most = 400;
  std::vector<Event> hardest(changes.begin(), changes.end());
  std::ranges::stable_sort(hardest, std::greater(), [](const Event& change) { return std::abs(change.velocity); });
  const auto together = [](const Event& a, const Event& b) { return a.time == b.time; };
  hardest.erase(std::unique(hardest.begin(), hardest.end(), together), hardest.end());
  if (hardest.size() > most) hardest.resize(most);
  constexpr std::size_t each = 100;
  for (const Event& change : hardest)
    for (std::size_t k = 0; k < each; ++k)
      times.push_back(change.time +
                      interval * std::pow(10.0, -decades * static_cast<double>(k) / static_cast<double>(each)));
  std::sort(times.begin(), times.end());
  const double closest = 1e-12 * end;
  std::vector<double> apart = {0.0};
  for (const double t : times)
    if (t - apart.back() > closest && end - t > closest) apart.push_back(t);
  apart.push_back(end);
  return apart;
}

}  // namespace viscobar
