// A scheme of one's own compared with built-in methods: central differences in space and Boost.Odeint's dopri5 in time.
//
//     rho u_tt - E u_xx - eta u_xxt = f,    at an obstacle  R = (-(u + gap))_+ / epsilon
//
//     rho w_j u_j'' = s_{j+1/2} - s_{j-1/2} + w_j f_j + R_j,    s = (E + eta d/dt) (u_{j+1} - u_j)/h,
//
// w = h, and h/2 at the ends: what viscobar calls the lumped mass. Two questions are put to it.
//
//  1. A bar thrown against two obstacles: does it agree with cvode, ida and the matrix exponentials, which know nothing
//     of it but the equation, to what its tolerance allows?
//  2. A manufactured contact with a known solution: does its error fall like h^2?
//
// Run: build/release/examples/own_scheme
#include <boost/numeric/odeint.hpp>
#include <iostream>
#include <viscobar/viscobar.hpp>

namespace {

using namespace viscobar;
using Vector = std::vector<double>;

// The right-hand side for y = (u, v).
class CentralDifferences {
 public:
  explicit CentralDifferences(const Case& run) : run_(run), n_(run.mesh().nodes()), h_(run.mesh().spacing()) {
    if (run.scene.load) load_ = std::get<GeneralLoad>(*run.scene.load).density;
  }

  void operator()(const Vector& y, Vector& rate, double t) const {
    const Bar& bar = run_.scene.bar;
    const double *u = y.data(), *v = u + n_;
    double stress_before = 0.0;
    for (std::size_t j = 0; j < n_; ++j) {
      const bool last = j + 1 == n_;
      const double stress = last ? 0.0 : (bar.modulus * (u[j + 1] - u[j]) + bar.viscosity * (v[j + 1] - v[j])) / h_;
      const double weight = j == 0 || last ? h_ / 2 : h_;
      double force = stress - stress_before;
      if (j == 0) force += reaction(run_.scene.left, u[j]);
      if (last) force += reaction(run_.scene.right, u[j]);
      if (load_) force += weight * load_(run_.mesh().node(j), t);
      rate[j] = v[j];
      rate[n_ + j] = force / (bar.density * weight);
      stress_before = stress;
    }
  }

  double reaction(const EndCondition& end, double u) const {
    const auto* obstacle = std::get_if<Obstacle>(&end);
    return obstacle ? std::max(0.0, -(u + obstacle->gap)) / *run_.epsilon : 0.0;
  }

 private:
  const Case& run_;
  std::size_t n_;
  double h_;
  SpaceTimeFunction load_;
};

// The solver that viscobar calls: Case in, Recording out.
Recording own_scheme(const Case& run) {
  namespace odeint = boost::numeric::odeint;
  const Mesh mesh = run.mesh();
  const std::size_t n = mesh.nodes();
  Vector y(2 * n);
  for (std::size_t j = 0; j < n; ++j) {
    y[j] = run.scene.displacement(mesh.node(j));
    y[n + j] = run.scene.velocity(mesh.node(j));
  }
  const CentralDifferences bar(run);
  Recorder recorder(run, "own_scheme");
  struct Contact {
    const Obstacle* obstacle;
    std::size_t node;
    Where where;
    bool closed = false;
  };
  Contact contacts[] = {{std::get_if<Obstacle>(&run.scene.left), 0, Where::left},
                        {std::get_if<Obstacle>(&run.scene.right), n - 1, Where::right}};
  // After each step of the integrator; Recorder interpolates to the output times.
  const auto keep = [&](const Vector& now, double t) {
    const std::span<const double> state(now);
    recorder.step(t, state.first(n), state.last(n), bar.reaction(run.scene.left, now[0]),
                  bar.reaction(run.scene.right, now[n - 1]));
    for (Contact& contact : contacts) {
      if (!contact.obstacle) continue;
      const double clearance = now[contact.node] + contact.obstacle->gap, velocity = now[n + contact.node];
      if (contact.closed == (clearance < 0.0)) continue;
      contact.closed = !contact.closed;
      recorder.change({t - clearance / velocity, contact.where, contact.node,
                       contact.closed ? Change::closing : Change::opening, velocity});
    }
  };
  odeint::integrate_adaptive(odeint::make_controlled(run.tolerance.absolute.value_or(1e-9), run.tolerance.relative,
                                                     odeint::runge_kutta_dopri5<Vector>()),
                             std::cref(bar), y, 0.0, run.end, 1e-6, keep);
  return recorder.recording();
}

Case on_lumped_mass(Scene scene) {
  Case run;
  run.scene = std::move(scene);
  run.mass = Mass::lumped;
  run.elements = 20;
  run.epsilon = 1e-3;
  run.tolerance = {1e-9, 1e-11};
  run.end = 2.0;
  run.output_every = 0.02;
  return run;
}

}  // namespace

int main() {
  Scene thrown;
  thrown.bar.viscosity = 0.1;
  thrown.left = thrown.right = Obstacle{0.1};
  thrown.displacement = [](double x) { return x * (1 - x); };
  thrown.velocity = [](double x) { return -x * (1 - x); };
  // Errors of 1e-9 a step add up over 1e3 steps at worst, and what is off by 1e-6 meets the obstacle at a velocity
  // above 1e-2 at a time that is off by 1e-4.
  const Trial trial{"thrown bar",
                    on_lumped_mass(thrown),
                    {},
                    {MethodName::exponential, MethodName::cvode, MethodName::ida},
                    Bounds{.displacement_l2 = 1e-6, .velocity_l2 = 1e-5, .end_trace = 1e-6, .event_shift = 1e-4}};
  const TrialResult result = examine("own_scheme", own_scheme, {&trial, 1}).front();
  std::cout << trial_text(result) << (result.passed() ? "passed\n\n" : "not passed\n\n");

  exact::ManufacturedContact contact;
  contact.right = exact::ManufacturedContact::End{0.3, 3.0};
  const exact::Solution solution = exact::later(exact::solution(contact), 0.1);
  std::vector<Case> cases = refinements(on_lumped_mass(solution.scene), Refine::mesh, 3);
  for (Case& run : cases) run.epsilon = 1e-2 * run.mesh().spacing() * run.mesh().spacing();
  const OrderStudy study = order_study(own_scheme, solution, cases, Refine::mesh);
  std::cout << "manufactured contact at both ends\n" << order_text(study);
  return result.passed() && study.displacement_l2 && std::abs(study.displacement_l2->order - 2.0) < 0.1 ? 0 : 1;
}
