// Prints the errors of several redistributed masses against exact solutions: behind "which redistribution" of
// docs/penalty-limit.md. The inertia is the only difference: the time stepping is scheme (2.8) with a small step,
// written out here because the library has one redistribution, the first of the list. Run:
// build/release/tests/measure_redistribution
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "viscobar/discretisation/mass.hpp"
#include "viscobar/schemes/schemes.hpp"
#include "viscobar/studies/compare/difference.hpp"
#include "viscobar/studies/exact/exact_solutions.hpp"

namespace {

using namespace viscobar;

// Unit density, contact at the left end, entries of the rows 0, 1, 2 in units of h.
BandedMatrix extrapolated(const Mesh& mesh) { return inertia_matrix(mesh, Mass::redistributed, true, false); }

BandedMatrix diagonal_correction(const Mesh& mesh) {
  BandedMatrix m = mass_matrix(mesh, Mass::consistent);
  const double h = mesh.spacing();
  m.diagonal[0] = m.off_diagonal[0] = 0.0;
  m.diagonal[1] += 7 * h / 6;
  m.diagonal[2] -= h / 2;
  return m;
}

BandedMatrix lumped_patch(const Mesh& mesh) {
  BandedMatrix m = mass_matrix(mesh, Mass::consistent);
  const double h = mesh.spacing();
  m.diagonal[0] = m.off_diagonal[0] = m.off_diagonal[1] = 0.0;
  m.diagonal[1] = 2 * h;
  m.diagonal[2] = h / 3;
  return m;
}

BandedMatrix lumped_throughout(const Mesh& mesh) {
  BandedMatrix m = mass_matrix(mesh, Mass::lumped);
  const double h = mesh.spacing();
  m.off_diagonal.assign(mesh.elements, 0.0);
  m.diagonal[0] = 0.0;
  m.diagonal[1] = 2 * h;
  m.diagonal[2] = h / 2;
  return m;
}

// Keeps the total mass only.
BandedMatrix to_the_neighbour(const Mesh& mesh) {
  BandedMatrix m = mass_matrix(mesh, Mass::consistent);
  const double h = mesh.spacing();
  m.diagonal[0] = m.off_diagonal[0] = 0.0;
  m.diagonal[1] += 2 * h / 3;
  return m;
}

struct Candidate {
  const char* label;
  BandedMatrix (*inertia)(const Mesh&);
};

constexpr Candidate candidates[] = {{"extrapolated, v_0 = 2 v_1 - v_2", extrapolated},
                                    {"diagonal, M_11 + 7h/6, M_22 - h/2", diagonal_correction},
                                    {"lumped patch, 0, 2h, h/3", lumped_patch},
                                    {"lumped throughout, 0, 2h, h/2, h ...", lumped_throughout},
                                    {"to the neighbour, M_11 + 2h/3", to_the_neighbour}};

// Scheme (2.8) on a left obstacle (and a free right end), rigid or with a spring that stays attached from t = 0 on.
Recording run(const Scene& scene, const Mesh& mesh, const BandedMatrix& unit_inertia, double dt, std::size_t steps,
              double spring = 0.0) {
  const BarSystem system(scene, mesh, Mass::consistent);
  const std::size_t n = mesh.nodes();
  const double gap = std::get<Obstacle>(scene.left).gap;
  BandedMatrix inertia = unit_inertia;
  for (double& m : inertia.diagonal) m *= scene.bar.density;
  for (double& m : inertia.off_diagonal) m *= scene.bar.density;
  BandedMatrix stiffness;  // E K / 2 + eta K / (2 dt)
  system.dynamic_stiffness(0.0, 0.5 / dt, 0.5, stiffness);
  BandedMatrix matrix = stiffness;
  for (std::size_t i = 0; i < n; ++i) matrix.diagonal[i] += inertia.diagonal[i] / (dt * dt);
  for (std::size_t i = 0; i + 1 < n; ++i) matrix.off_diagonal[i] += inertia.off_diagonal[i] / (dt * dt);
  matrix.diagonal[0] += spring / 2;
  TridiagonalFactor factor;
  factor.factorise(matrix);
  std::vector<double> compliance(n, 0.0);
  compliance[0] = 1.0;
  factor.solve(compliance);

  Recording recording;
  recording.mesh = mesh;
  std::optional<LoadVector> load;
  if (system.loaded()) load.emplace(system);
  std::vector<double> before = system.initial_state().u, now = before, next(n), product(n),
                      v = system.initial_state().v;
  for (std::size_t i = 0; i < n; ++i) now[i] += dt * v[i];
  now[0] = std::max(now[0], spring > 0.0 ? now[0] : -gap);
  const auto keep = [&](double t, const std::vector<double>& u, double reaction) {
    recording.times.push_back(t);
    recording.u.insert(recording.u.end(), u.begin(), u.end());
    recording.v.insert(recording.v.end(), v.begin(), v.end());
    recording.reaction_left.push_back(reaction);
    recording.reaction_right.push_back(0.0);
  };
  keep(0.0, before, 0.0);
  std::vector<double> difference(n), damping(n), elastic(n), zero(n, 0.0);
  for (std::size_t k = 1; k < steps; ++k) {
    // S next = M (2 now - before) / dt^2 - (E K / 2 - eta K / (2 dt)) before + M f.
    for (std::size_t i = 0; i < n; ++i) difference[i] = 2 * now[i] - before[i];
    inertia.multiply(difference, product);
    system.internal_force(before, zero, elastic);
    system.internal_force(zero, before, damping);
    for (std::size_t i = 0; i < n; ++i) next[i] = product[i] / (dt * dt) + elastic[i] / 2 - damping[i] / (2 * dt);
    next[0] -= spring * (before[0] / 2 + gap);
    const double t = static_cast<double>(k) * dt;
    if (load) {
      const auto f = load->at(t);
      for (std::size_t i = 0; i < n; ++i) next[i] += f[i];
    }
    factor.solve(next);
    double reaction = 0.0;
    if (spring == 0.0 && next[0] < -gap) {
      reaction = (-gap - next[0]) / compliance[0];
      for (std::size_t i = 0; i < n; ++i) next[i] += reaction * compliance[i];
    }
    for (std::size_t i = 0; i < n; ++i) v[i] = (next[i] - before[i]) / (2 * dt);
    keep(t, now, reaction);
    std::swap(before, now);
    std::swap(now, next);
  }
  return recording;
}

void against_solution(const char* title, const exact::Solution& solution, double end, double step_share) {
  fmt::print(
      "\n### {}\n\n| redistribution | elements | u, L2 | order | u at the ends | order | v, L2 | order | reaction, "
      "L1 | order |\n|---|---|---|---|---|---|---|---|---|---|\n",
      title);
  for (const Candidate& candidate : candidates) {
    std::optional<exact::Error> coarse;
    for (const std::size_t elements : {20u, 40u, 80u, 160u}) {
      const Mesh mesh{solution.scene.bar.length, elements};
      const auto steps = static_cast<std::size_t>(std::ceil(end / (step_share * mesh.spacing())));
      const auto found = exact::error(
          run(solution.scene, mesh, candidate.inertia(mesh), end / static_cast<double>(steps), steps), solution);
      const auto order = [&](double exact::Error::*member) {
        return coarse ? fmt::format("{:.2f}", std::log2((*coarse).*member / found.*member)) : std::string("-");
      };
      fmt::print("| {} | {} | {:.3e} | {} | {:.3e} | {} | {:.3e} | {} | {:.3e} | {} |\n", candidate.label, elements,
                 found.displacement_l2, order(&exact::Error::displacement_l2), found.end_trace,
                 order(&exact::Error::end_trace), found.velocity_l2, order(&exact::Error::velocity_l2),
                 found.reaction_l1, order(&exact::Error::reaction_l1));
      coarse = found;
    }
  }
}

// Largest relative error of d(t) up to three times the peak's time.
void against_impact_law(double viscosity, double epsilon) {
  const exact::ImpactLaw law{{1.0, 1.0, 1.0, viscosity}, 1.0, epsilon, 0.0};
  const double tau = viscosity > 0.0 ? std::cbrt(epsilon * epsilon * viscosity) : epsilon, end = 5 * tau;
  const double top = viscosity > 0.0 ? law.peak()->penetration : epsilon;
  fmt::print(
      "\n### Penalised impact, eta = {}, epsilon = {}: max |d - d_exact| / max d_exact to 5 tau\n\n"
      "| redistribution | 50 | 100 | 200 | 400 elements |\n|---|---|---|---|---|\n",
      viscosity, epsilon);
  for (const Candidate& candidate : candidates) {
    fmt::print("| {} |", candidate.label);
    for (const std::size_t elements : {50u, 100u, 200u, 400u}) {
      const Mesh mesh{1.0, elements};
      constexpr std::size_t steps = 8000;
      const Recording recording = run(law.scene(), mesh, candidate.inertia(mesh), end / steps, steps, 1 / epsilon);
      double worst = 0.0;
      for (std::size_t k = 0; k < recording.times.size(); k += 20)
        worst = std::max(worst, std::abs(-recording.displacement(k)[0] - law.penetration(recording.times[k])));
      fmt::print(" {:.2e} |", worst / top);
    }
    fmt::print("\n");
  }
}

}  // namespace

int main() {
  exact::ManufacturedContact viscous;
  against_solution("Manufactured contact, eta = 0.5, dt = h / 8, to t = 3", exact::solution(viscous), 3.0, 0.125);
  viscous.bar.viscosity = 0.02;
  against_solution("Manufactured contact, eta = 0.02, dt = h / 8, to t = 3", exact::solution(viscous), 3.0, 0.125);
  against_solution("Elastic impact, dt = h / 8, to t = 3",
                   exact::solution(exact::ElasticImpact{{1.0, 1.0, 1.0, 0.0}, 1.0, 0.1}), 3.0, 0.125);
  against_impact_law(1.0, 1e-3);
  against_impact_law(0.1, 1e-3);
  against_impact_law(0.0, 1e-2);
}
