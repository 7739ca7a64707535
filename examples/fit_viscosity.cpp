// The viscosity of a bar, fitted to a measured trace of its end.
//
//     u_tt - u_xx - alpha u_xxt = 0           0 < x < 1, t < 3
//     0 <= u(0,t) + 0.1  _|_  R(t) >= 0       obstacle below the left end, right end free
//     u(x,0) = 0,  u_t(x,0) = -1
//
// The measurement y_k is made here: by another method on a finer mesh at alpha = 0.07, with noise of 1e-3. fit() finds
//
//     min over alpha of  sum over k of (u(0, t_k; alpha) - y_k)^2
//
// on the derivatives of the run through contact, and the standard deviation of alpha. The same from a shell:
//
//     viscobar fit SCENE --data trace.csv --parameters bar.viscosity
//
// Run: build/release/examples/fit_viscosity
#include <cmath>
#include <cstdio>
#include <random>
#include <viscobar/viscobar.hpp>

namespace {

using namespace viscobar;

Case bar(double alpha) {
  Case run;
  run.scene.bar.viscosity = alpha;
  run.scene.left = Obstacle{0.1};
  run.scene.displacement = [](double) { return 0.0; };
  run.scene.velocity = [](double) { return -1.0; };
  run.elements = 100;
  run.method = MethodName::rigid;  // no epsilon to choose
  run.end = 3.0;
  run.output_every = 0.02;
  run.directions = {direction(run, "bar.viscosity")};
  return run;
}

std::vector<double> measured(double alpha) {
  Case run = bar(alpha);
  run.elements = 400;
  run.method = MethodName::fully_discrete;
  run.step = 5e-4;
  run.directions.clear();  // a scheme has no derivatives, and a measurement none
  std::vector<double> trace = trace_ends(run, run.output_times()).left;
  std::minstd_rand random(1);
  std::normal_distribution<double> noise(0.0, 1e-3);
  for (double& value : trace) value += noise(random);
  return trace;
}

}  // namespace

int main() {
  const double truth = 0.07;
  FitStudy study;
  study.model = [](std::span<const double> values) { return bar(values[0]); };
  study.parameters = {{"bar.viscosity", 0.3, 0.0}};
  study.times = bar(truth).output_times();
  study.traces = {{TraceColumn::u_left, measured(truth)}};
  const FitResult found = fit(study);

  const auto [key, alpha, deviation, at_bound] = found.parameters.front();
  std::printf("%s = %.5f +- %.5f after %zu runs (the bar was made with %g); noise %.2e (1e-3)\n", key.c_str(), alpha,
              deviation, found.runs, truth, found.residual);
  return found.converged && !at_bound && std::abs(alpha - truth) < 4 * deviation ? 0 : 1;
}
