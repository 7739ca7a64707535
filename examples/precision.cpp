// How long for which error, and what the error consists of: the study of `viscobar precision` by the library.
//
//     u_tt - u_xx = 0                         0 < x < 1, t < 3
//     0 <= u(0,t)  _|_  R(t) >= 0             obstacle at the left end, u(1,t) = 0
//     u(x,0) = (1 - x)/2,  u_t(x,0) = 0
//
// This bar of period 3 has a closed form, which the study recognises. Its error is
//
//     u - u_*  =  (u - u_h)  +  (u_h - u_*),     time + space,
//
// and the time part is what a tolerance buys: the solution keeps a hundred times the tolerance (docs/methods.md).
//
// Run: build/release/examples/precision
#include <cstdio>
#include <viscobar/viscobar.hpp>

int main() {
  using namespace viscobar;
  PrecisionStudy study;
  study.scene.scene = exact::PeriodThree::scene();
  study.scene.elements = 50;
  study.scene.mass = Mass::redistributed;
  study.scene.end = exact::PeriodThree::period;
  study.scene.output_every = 0.01;
  study.methods = {MethodName::rigid, MethodName::fully_discrete};
  study.tolerances = {1e-3, 1e-4, 1e-5, 1e-6};
  study.halvings = 5;
  study.repeat = 3;
  const PrecisionResult result = precision_of(study);

  bool as_expected = result.reference && result.reference->closed_form;
  std::printf("errors against %s\n", result.reference ? result.reference->what.c_str() : "nothing");
  std::printf("method          setting               seconds      error       time      space\n");
  for (const PrecisionRow& row : result.rows) {
    const auto space = result.parts_of(row).space;
    std::printf("%-14s  %-18s  %9.2e  %9.2e  %9.2e  %9.2e\n", name(row.method).data(), row.label.c_str(), row.seconds,
                row.error.value_or(0), row.time_error.value_or(0), space.value_or(0));
    as_expected = as_expected && row.failure.empty() && row.error && row.time_error && space &&
                  // no error is more than its parts
                  *row.error <= *row.time_error + *space + 1e-9;
    if (is_adaptive(row.method))
      as_expected = as_expected && *row.time_error <= 100 * row.setting * result.reference->largest_displacement;
  }
  return as_expected ? 0 : 1;
}
