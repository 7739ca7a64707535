#include "studies/precision/field.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace viscobar::precision {

Statistics simulate_within(double seconds, const Case& run, const BarSystem& system, Observers observers) {
  using Clock = std::chrono::steady_clock;
  observers.progress = [started = Clock::now(), seconds](double) {
    const double passed = std::chrono::duration<double>(Clock::now() - started).count();
    return passed > seconds ? RunControl::stop : RunControl::go_on;
  };
  const Statistics statistics = simulate(run, system, observers);
  if (!statistics.completed) throw TooLong();
  return statistics;
}

void interpolate(const Mesh& from, std::span<const double> u, const Mesh& to, std::span<double> out) {
  for (std::size_t j = 0; j < to.nodes(); ++j) {
    const std::size_t scaled = j * from.elements, element = scaled / to.elements, rest = scaled % to.elements;
    out[j] = u[element];
    if (rest == 0) continue;
    if (from.uniform())
      out[j] += (u[element + 1] - u[element]) * static_cast<double>(rest) / static_cast<double>(to.elements);
    else
      out[j] += (u[element + 1] - u[element]) * (to.node(j) - from.node(element)) / from.element(element);
  }
}

std::vector<Field> fields_of(const Case& run, std::span<const Mesh> meshes, double seconds, Statistics* done) {
  std::vector<Field> fields;
  for (const Mesh& mesh : meshes) fields.push_back({mesh, {}});
  Observers observers;
  observers.snapshot = [&](const Snapshot& now) {
    for (Field& field : fields) {
      const std::size_t begin = field.u.size();
      field.u.resize(begin + field.mesh.nodes());
      interpolate(run.mesh(), now.u, field.mesh, std::span(field.u).subspan(begin));
    }
  };
  const Statistics statistics = simulate_within(seconds, run, make_system(run), observers);
  if (done) *done = statistics;
  return fields;
}

Field field_of(const SpaceTimeFunction& u, const Mesh& mesh, std::span<const double> times) {
  Field field{mesh, {}};
  field.u.reserve(times.size() * mesh.nodes());
  for (const double t : times)
    for (std::size_t j = 0; j < mesh.nodes(); ++j) field.u.push_back(u(mesh.node(j), t));
  return field;
}

double distance(std::span<const double> a, std::span<const double> b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

double distance(const Field& a, const Field& b) {
  const std::size_t start = a.mesh.nodes();
  return distance(std::span(a.u).subspan(start), std::span(b.u).subspan(start));
}

Field extrapolated(const Field& fine, const Field& coarse, double ratio) {
  Field result = fine;
  for (std::size_t i = 0; i < result.u.size(); ++i) result.u[i] += (fine.u[i] - coarse.u[i]) / (ratio - 1.0);
  return result;
}

}  // namespace viscobar::precision
