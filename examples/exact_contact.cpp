// Three methods against an exact solution with contact.
//
//     u_tt - u_xx - 0.5 u_xxt = f             0 < x < 1, t < 3
//     obstacles at both ends, gaps 0.25 and 0.3
//     u = sum over the ends of (g - gap) A + p phi,    g = sin(omega t)_+^3,   reaction r = (sin(omega t)_-)^2
//
// Each end opens and closes once a period, without impact (viscobar/studies/exact/exact_solutions.hpp). The mesh and
// the step are halved together and epsilon falls with h^2, so that every error falls like h^2.
//
// Run: build/release/examples/exact_contact
#include <iostream>
#include <viscobar/viscobar.hpp>

int main() {
  using namespace viscobar;
  exact::ManufacturedContact contact{{.length = 1.0, .viscosity = 0.5}, {}, {}};
  contact.left = {.gap = 0.25, .omega = 6.0};
  contact.right = {.gap = 0.3, .omega = 3.0};
  const exact::Solution solution = exact::solution(contact);

  Case run;
  run.scene = solution.scene;
  run.elements = 20;
  run.end = 3.0;
  run.output_every = 0.05;
  run.step = 0.0025;
  run.tolerance = {1e-8, 1e-11};
  run.start = Start::second_order;
  run.mass = Mass::consistent;

  bool as_expected = true;
  for (const MethodName method : {MethodName::cvode, MethodName::fully_discrete, MethodName::finite_difference}) {
    run.method = method;
    std::vector<Case> cases = refinements(run, Refine::both, 4);
    for (Case& refined : cases) refined.epsilon = 0.01 * refined.mesh().spacing() * refined.mesh().spacing();
    const OrderStudy study = order_study(record, solution, cases, Refine::both);
    std::cout << name(method) << "\n" << order_text(study) << "\n";
    as_expected = as_expected && study.displacement_l2 && std::abs(study.displacement_l2->order - 2.0) < 0.1;
  }
  return as_expected ? 0 : 1;
}
