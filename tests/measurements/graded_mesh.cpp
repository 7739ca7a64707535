// Prints the tables of docs/graded-meshes.md: do elements that shrink towards the contact end lower the error at an
// equal number of elements? Scheme (2.8) with a rigid left end is written out here, for the reactions of its single
// steps; the bar on its penalty is integrated by ida. Run: cmake --build --preset release --target measure_graded_mesh
// && build/release/tests/measure_graded_mesh
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "viscobar/discretisation/tridiagonal.hpp"
#include "viscobar/studies/exact/exact_solutions.hpp"

namespace {

using namespace viscobar;
using Vector = std::vector<double>;

// Nodes on [0, 1], elements shrinking towards 0.
struct Grading {
  std::string label;
  std::function<double(double)> node;  // of j / J
};

// Element sizes h_0 q^j with h_{J-1} / h_0 close to `ratio`: x = (ratio^(j/J) - 1) / (ratio - 1).
Grading geometric(double ratio) {
  return {fmt::format("geometric, 1 : {}", ratio),
          [=](double xi) { return std::expm1(xi * std::log(ratio)) / (ratio - 1); }};
}
// Element sizes h_0 + j s, h_{J-1} / h_0 close to `ratio`; algebraic with power 2 as the ratio grows.
Grading arithmetic(double ratio) {
  return {fmt::format("arithmetic, 1 : {}", ratio),
          [=](double xi) { return xi * (2 + (ratio - 1) * xi) / (1 + ratio); }};
}
const std::vector<Grading>& gradings() {
  static const std::vector<Grading> all{
      {"uniform", [](double xi) { return xi; }}, arithmetic(4), arithmetic(16), arithmetic(64)};
  return all;
}

Vector nodes(const Grading& grading, std::size_t elements) {
  Vector x(elements + 1);
  for (std::size_t j = 0; j <= elements; ++j)
    x[j] = grading.node(static_cast<double>(j) / static_cast<double>(elements));
  return x;
}

// P1 matrices of unit density and modulus.
struct Matrices {
  Vector x;
  BandedMatrix mass, stiffness;
};

Matrices assemble(Vector x) {
  const std::size_t n = x.size();
  const BandedMatrix zero{Vector(n, 0.0), Vector(n - 1, 0.0)};
  Matrices found{std::move(x), zero, zero};
  for (std::size_t j = 0; j + 1 < n; ++j) {
    const double h = found.x[j + 1] - found.x[j];
    for (const std::size_t node : {j, j + 1}) {
      found.mass.diagonal[node] += h / 3;
      found.stiffness.diagonal[node] += 1 / h;
    }
    found.mass.off_diagonal[j] = h / 6;
    found.stiffness.off_diagonal[j] = -1 / h;
  }
  return found;
}

// The contact node without mass: its velocity in the kinetic energy of its element is extrapolated, v_0 = (1 + a) v_1 -
// a v_2, a = h_0 / h_1. Linear velocity fields keep their energy, so mass, centre of mass and moment of inertia stay.
BandedMatrix redistributed(const Matrices& bar) {
  BandedMatrix m = bar.mass;
  const double h = bar.x[1] - bar.x[0], a = h / (bar.x[2] - bar.x[1]);
  m.diagonal[0] = m.off_diagonal[0] = 0.0;
  m.diagonal[1] += h / 3 * (a * a + 3 * a + 3) - h / 3;
  m.off_diagonal[1] -= h / 6 * (2 * a * a + 3 * a);
  m.diagonal[2] += h / 3 * a * a;
  return m;
}

// p A + q B
BandedMatrix sum(double p, const BandedMatrix& A, double q, const BandedMatrix& B) {
  BandedMatrix C = A;
  for (std::size_t i = 0; i < C.diagonal.size(); ++i) C.diagonal[i] = p * A.diagonal[i] + q * B.diagonal[i];
  for (std::size_t i = 0; i < C.off_diagonal.size(); ++i)
    C.off_diagonal[i] = p * A.off_diagonal[i] + q * B.off_diagonal[i];
  return C;
}

double l2_norm(const Vector& x, const Vector& u) {
  double total = 0.0;
  for (std::size_t j = 0; j + 1 < x.size(); ++j)
    total += (x[j + 1] - x[j]) / 3 * (u[j] * u[j] + u[j] * u[j + 1] + u[j + 1] * u[j + 1]);
  return std::sqrt(total);
}

// Values at `points` of the P1 function with nodal values u.
Vector interpolated(const Vector& x, const Vector& u, const Vector& points) {
  Vector values(points.size());
  std::size_t j = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    while (j + 2 < x.size() && x[j + 1] < points[i]) ++j;
    const double share = (points[i] - x[j]) / (x[j + 1] - x[j]);
    values[i] = (1 - share) * u[j] + share * u[j + 1];
  }
  return values;
}

// Called by a run with t, nodal u, and the reaction.
using Observer = std::function<void(double, const Vector&, double)>;

// Scheme (2.8) in the acceleration a, (M + dt/2 eta K + dt^2/2 K) a = M f - K (u + eta p), with the left end rigid.
// Observed at every `every`-th step.
void rigid_run(const Scene& scene, const Matrices& bar, const BandedMatrix& inertia, double dt, std::size_t steps,
               std::size_t every, const Observer& observe) {
  const std::size_t n = bar.x.size();
  const double gap = std::get<Obstacle>(scene.left).gap, eta = scene.bar.viscosity;
  const TridiagonalFactor factor(sum(1.0, inertia, dt / 2 * (eta + dt), bar.stiffness));
  Vector column(n, 0.0), u(n), p(n), a(n), stress(n), force(n), weighted(n, 0.0);
  column[0] = 1.0;
  factor.solve(column);
  const auto* load = scene.load ? &std::get<GeneralLoad>(*scene.load) : nullptr;
  const auto accelerate = [&](double t) {
    for (std::size_t i = 0; i < n; ++i) stress[i] = u[i] + eta * p[i];
    bar.stiffness.multiply(stress, a);
    if (load) {
      for (std::size_t i = 0; i < n; ++i) force[i] = load->density(bar.x[i], t);
      bar.mass.multiply(force, weighted);
    }
    for (std::size_t i = 0; i < n; ++i) a[i] = weighted[i] - a[i];
    factor.solve(a);
  };
  for (std::size_t i = 0; i < n; ++i) {
    u[i] = scene.displacement(bar.x[i]);
    p[i] = scene.velocity(bar.x[i]);
  }
  observe(0.0, u, 0.0);
  // Half the acceleration in the first step: second order.
  for (std::size_t k = 0; k < steps; ++k) {
    accelerate(static_cast<double>(k) * dt);
    const double share = k == 0 ? 0.5 : 1.0;
    const double passed = -gap - (u[0] + dt * (p[0] + dt * share * a[0]));
    const double reaction = std::max(0.0, passed / (dt * dt * share * column[0]));
    for (std::size_t i = 0; i < n; ++i) {
      p[i] += dt * share * (a[i] + reaction * column[i]);
      u[i] += dt * p[i];
    }
    if ((k + 1) % every == 0) observe(static_cast<double>(k + 1) * dt, u, reaction);
  }
}

void print_head(const std::string& title, const std::vector<std::string>& columns) {
  fmt::print("\n### {}\n\n| mesh |", title);
  for (const std::string& column : columns) fmt::print(" {} |", column);
  fmt::print("\n|---|");
  for (std::size_t i = 0; i < columns.size(); ++i) fmt::print("---|");
  fmt::print("\n");
}

const std::vector<std::size_t> sizes{20, 40, 80, 160};
std::vector<std::string> size_columns() {
  std::vector<std::string> columns;
  for (const std::size_t elements : sizes) columns.push_back(fmt::format("{}", elements));
  return columns;
}

// Largest error of the left end and in L2 (of the nodal interpolant).
void against_solution(const char* title, const exact::Solution& solution, double end, std::size_t steps) {
  print_head(title, size_columns());
  for (const Grading& grading : gradings()) {
    fmt::print("| {} |", grading.label);
    for (const std::size_t elements : sizes) {
      const Matrices bar = assemble(nodes(grading, elements));
      double trace = 0.0, norm = 0.0;
      Vector difference(bar.x.size());
      rigid_run(solution.scene, bar, bar.mass, end / static_cast<double>(steps), steps, steps / 300,
                [&](double t, const Vector& u, double) {
                  for (std::size_t i = 0; i < u.size(); ++i) difference[i] = u[i] - solution.u(bar.x[i], t);
                  trace = std::max(trace, std::abs(difference[0]));
                  norm = std::max(norm, l2_norm(bar.x, difference));
                });
      fmt::print(" {:.2e}, {:.2e} |", trace, norm);
    }
    fmt::print("\n");
  }
}

// As contact_with_wave, but on top of the contact b cos(omega t) 16 x^2 (1 - x)^2, whose third derivative differs from
// end to end: the mesh error of the wave's load has a resultant, h^2/12 times that difference. That of sin^2(pi x) has
// none on a uniform mesh, and only there.
exact::Solution contact_with_hump(const exact::ManufacturedContact& contact, double t0) {
  constexpr double b = 0.1, omega = 3.0;
  const Bar bar = contact.bar;
  const auto psi = [](double x) { return 16 * x * x * (1 - x) * (1 - x); };
  const auto psi_xx = [](double x) { return 32 * (1 - 6 * x * (1 - x)); };
  exact::Solution found = exact::solution(contact);
  found.u = [=](double x, double t) { return contact.u(x, t) + b * std::cos(omega * t) * psi(x); };
  found.v = [=](double x, double t) { return contact.v(x, t) - b * omega * std::sin(omega * t) * psi(x); };
  found.scene.load = GeneralLoad{[=](double x, double t) {
    const double c = b * std::cos(omega * t), s = b * std::sin(omega * t);
    return contact.f(x, t) - (bar.modulus * c - bar.viscosity * omega * s) * psi_xx(x) -
           bar.density * omega * omega * c * psi(x);
  }};
  return exact::later(std::move(found), t0);
}

struct Track {
  Vector trace, reaction;
  std::vector<Vector> field;  // at `points`
};

// A bar that flies into the obstacle and leaves again, against itself on a mesh of 2000 elements and the same dt.
void impact_and_rebound(double eta) {
  print_head(fmt::format("Rigid impact and rebound, eta = {}, V = 1, to t = 3: left end, L2, reaction in L1, against "
                         "2000 elements",
                         eta)
                 .c_str(),
             size_columns());
  const Scene scene = exact::RigidFlight{{1.0, 1.0, 1.0, eta}, 1.0, 0.1}.scene();
  const Vector points = nodes(gradings()[0], 1000);
  constexpr double end = 3.0;
  constexpr std::size_t steps = 60000;
  const auto track = [&](const Grading& grading, std::size_t elements) {
    const Matrices bar = assemble(nodes(grading, elements));
    Track found;
    rigid_run(scene, bar, redistributed(bar), end / steps, steps, 20, [&](double, const Vector& u, double reaction) {
      found.trace.push_back(u[0]);
      found.reaction.push_back(reaction);
      if (found.trace.size() % 10 == 0) found.field.push_back(interpolated(bar.x, u, points));
    });
    return found;
  };
  const Track reference = track(geometric(16), 2000);
  for (const Grading& grading : gradings()) {
    fmt::print("| {} |", grading.label);
    for (const std::size_t elements : sizes) {
      const Track found = track(grading, elements);
      double trace = 0.0, norm = 0.0, reaction = 0.0;
      for (std::size_t k = 0; k < found.trace.size(); ++k) {
        trace = std::max(trace, std::abs(found.trace[k] - reference.trace[k]));
        reaction += std::abs(found.reaction[k] - reference.reaction[k]) * 20 * end / steps;
      }
      Vector difference(points.size());
      for (std::size_t k = 0; k < found.field.size(); ++k) {
        for (std::size_t i = 0; i < points.size(); ++i) difference[i] = found.field[k][i] - reference.field[k][i];
        norm = std::max(norm, l2_norm(points, difference));
      }
      fmt::print(" {:.1e}, {:.1e}, {:.1e} |", trace, norm, reaction);
    }
    fmt::print("\n");
  }
}

constexpr double ratios[] = {1.0, 4.0, 16.0, 64.0};

// Largest |d - exact| / max d up to 5 tau.
double impact_error(const exact::ImpactLaw& law, Mass mass, std::size_t elements, double ratio) {
  const double tau = std::cbrt(law.epsilon * law.epsilon * law.bar.viscosity);
  Case run;
  run.scene = law.scene();
  run.method = MethodName::ida;
  run.mass = mass;
  run.elements = elements;
  run.grading = ratio;
  run.epsilon = law.epsilon;
  run.tolerance = {1e-8, 1e-12};
  run.end = law.closing() + 5.0 * tau;
  run.output_every = tau / 50.0;
  const Recording found = record(run);
  double worst = 0.0;
  for (std::size_t k = 0; k < found.times.size(); ++k)
    if (const double since = found.times[k] - law.closing(); since > 0.0)
      worst = std::max(worst, std::abs(-(found.displacement(k).front() + law.gap) - law.penetration(since)));
  return worst / law.peak()->penetration;
}

void penalised(double eta, Mass mass, std::size_t elements) {
  constexpr double epsilons[] = {1e-3, 1e-4, 1e-5, 1e-6};
  std::vector<std::string> columns;
  for (const double epsilon : epsilons)
    columns.push_back(fmt::format("epsilon {:.0e}, layer {:.1e}", epsilon, std::cbrt(epsilon * eta * eta)));
  print_head(fmt::format("Penalised impact, eta = {}, {} mass, {} elements: max |d - exact| / max d to 5 tau", eta,
                         name(mass), elements),
             columns);
  for (const double ratio : ratios) {
    fmt::print("| {} |", ratio);
    for (const double epsilon : epsilons)
      fmt::print(" {:.1e} |", impact_error({{1.0, 1.0, 1.0, eta}, 1.0, epsilon, 1e-3}, mass, elements, ratio));
    fmt::print("\n");
  }
}

}  // namespace

int main() {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // tables as they come, also into a file
  exact::ManufacturedContact contact;
  for (const double eta : {0.5, 0.02}) {
    contact.bar.viscosity = eta;
    against_solution(fmt::format("Manufactured contact with a hump, eta = {}: left end, L2, to t = 3", eta).c_str(),
                     contact_with_hump(contact, 0.1), 3.0, 19200);
  }
  against_solution("Elastic impact, eta = 0: left end, L2, to t = 3",
                   exact::solution(exact::ElasticImpact{{1.0, 1.0, 1.0, 0.0}, 1.0, 0.1}), 3.0, 60000);
  for (const double eta : {1.0, 0.1, 0.01}) impact_and_rebound(eta);
  for (const Mass mass : {Mass::consistent, Mass::redistributed})
    for (const double eta : {1.0, 0.1})
      for (const std::size_t elements : {50u, 200u}) penalised(eta, mass, elements);
}
