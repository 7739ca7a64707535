// Prints the tables of docs/orders.md: observed orders in h and dt on exact solutions of contact and on an impact. Run:
// cmake --build --preset release --target measure_orders && build/release/tests/measure_orders
#include "viscobar/studies/orders/orders.hpp"

#include <fmt/format.h>

#include "support/contact_with_wave.hpp"
#include "support/paper_throw.hpp"

namespace {

using namespace viscobar;

exact::ManufacturedContact contact(bool both) {
  exact::ManufacturedContact found;
  if (both) found.right = exact::ManufacturedContact::End{0.3, 3.0};
  return found;
}

Case coarse(const Scene& scene, MethodName method, Mass mass) {
  Case run;
  run.scene = scene;
  run.method = method;
  run.mass = mass;
  run.elements = 20;
  run.end = 3.0;
  run.output_every = 0.05;
  run.tolerance = {1e-9, 1e-12};
  return run;
}

// The slope over all levels, settled or not: the tables say which levels these are.
std::string fitted(const OrderStudy& study, double exact::Error::*quantity) {
  const Sequence errors = study.errors(quantity);
  const auto order = observed_order(errors.x, errors.distance);
  return order ? fmt::format("{:.2f}", order->order) : "-";
}

void print_head(const char* title, const char* first) {
  fmt::print(
      "\n### {}\n\n| {} | u, L2 | order | end traces | order | v, L2 | order | reactions, L1 | order |\n"
      "|---|---|---|---|---|---|---|---|---|\n",
      title, first);
}

void print_row(const std::string& label, const OrderStudy& study) {
  const auto range = [&](double exact::Error::*quantity) {
    return fmt::format("{:.2e} ... {:.2e}", study.rows.front().error.*quantity, study.rows.back().error.*quantity);
  };
  fmt::print("| {} | {} | {} | {} | {} | {} | {} | {} | {} |\n", label, range(&exact::Error::displacement_l2),
             fitted(study, &exact::Error::displacement_l2), range(&exact::Error::end_trace),
             fitted(study, &exact::Error::end_trace), range(&exact::Error::velocity_l2),
             fitted(study, &exact::Error::velocity_l2), range(&exact::Error::reaction_l1),
             fitted(study, &exact::Error::reaction_l1));
}

constexpr Mass masses[] = {Mass::consistent, Mass::lumped, Mass::paper, Mass::redistributed};

void in_h(bool both) {
  const exact::Solution solution = exact::contact_with_wave(contact(both), 0.1);
  print_head(both ? "Orders in h, two ends, 20 to 160 elements" : "Orders in h, one end, 20 to 160 elements",
             "method, mass");
  const auto study = [&](MethodName method, Mass mass) {
    std::vector<Case> cases = refinements(coarse(solution.scene, method, mass), Refine::mesh, 4);
    for (Case& run : cases) {
      const double h = run.mesh().spacing();
      run.epsilon = 1e-3 * h * h;
      run.step = h / 32;
      run.start = Start::second_order;
    }
    print_row(fmt::format("{}, {}", name(method), name(mass)), order_study(record, solution, cases, Refine::mesh));
  };
  for (const MethodName method : {MethodName::fully_discrete, MethodName::cvode, MethodName::ida})
    for (const Mass mass : masses) study(method, mass);
  study(MethodName::rigid, Mass::redistributed);
}

const char* name(Start start) { return start == Start::first_order ? "first_order" : "second_order"; }

void print_steps_head(const char* title) {
  fmt::print("\n### {}\n\n| mass | start | u, L2 | order | end traces | order |\n|---|---|---|---|---|---|\n", title);
}

void print_steps(Mass mass, Start start, const OrderStudy& study) {
  const OrderStudy::Row &first = study.rows.front(), &last = study.rows.back();
  fmt::print("| {} | {} | {:.2e} ... {:.2e} | {} | {:.2e} ... {:.2e} | {} |\n", name(mass), name(start),
             first.error.displacement_l2, last.error.displacement_l2, fitted(study, &exact::Error::displacement_l2),
             first.error.end_trace, last.error.end_trace, fitted(study, &exact::Error::end_trace));
}

constexpr Start starts[] = {Start::first_order, Start::second_order};

void in_dt(bool both) {
  print_steps_head(both ? "Orders in dt, two ends, 40 elements, change from dt to dt/2, dt = 1/400 to 1/12800"
                        : "Orders in dt, one end, 40 elements, change from dt to dt/2, dt = 1/400 to 1/12800");
  for (const Mass mass : masses)
    for (const Start start : starts) {
      Case run = coarse(exact::contact_with_wave(contact(both), 0.1).scene, MethodName::fully_discrete, mass);
      run.elements = 40;
      run.step = 1.0 / 400;
      run.start = start;
      print_steps(mass, start, self_study(record, refinements(run, Refine::step, 7)));
    }
}

// A bar thrown against both obstacles.
Case thrown(double alpha, Mass mass, Start start) {
  Case run = paper_throw(alpha);
  run.mass = mass;
  run.end = 3.0;
  run.output_every = 0.01;
  run.method = MethodName::fully_discrete;
  run.tolerance = {1e-11, 1e-13};
  run.step = 1.0 / 500;
  run.start = start;
  return run;
}

void impact(double alpha) {
  print_steps_head(
      fmt::format("Impact, alpha = {}, 27 elements, change from dt to dt/2, dt = 1/500 to 1/64000", alpha).c_str());
  for (const Mass mass : masses)
    for (const Start start : starts)
      print_steps(mass, start, self_study(record, refinements(thrown(alpha, mass, start), Refine::step, 9)));
}

}  // namespace

int main() {
  in_h(false);
  in_h(true);
  in_dt(false);
  in_dt(true);
  for (const double alpha : {0.1, 0.01}) impact(alpha);
}
