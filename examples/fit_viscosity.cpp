// The viscosity of a bar, fitted to a measured trace of its end.
//
//     u_tt - u_xx - alpha u_xxt = 0           0 < x < 1, t < 3
//     0 <= u(0,t) + 0.1  _|_  R(t) >= 0       obstacle below the left end, right end free
//     u(x,0) = 0,  u_t(x,0) = -1
//
// The measurement y_k is made here: by another method on a finer mesh at alpha = 0.07, with noise of 1e-3. Sought is
//
//     min over alpha of  J(alpha) = sum over k of (u(0, t_k; alpha) - y_k)^2
//
// by golden section in log alpha: J is smooth, for the run's error is far below the noise, but nobody has to
// differentiate through contacts. The standard error is sigma / |du/dalpha|, both taken from the fit.
//
// Run: build/release/examples/fit_viscosity
#include <cmath>
#include <cstdio>
#include <random>
#include <viscobar/viscobar.hpp>

namespace {

using namespace viscobar;
using Trace = std::vector<double>;

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
  return run;
}

Trace measured(double alpha) {
  Case run = bar(alpha);
  run.elements = 400;
  run.method = MethodName::fully_discrete;
  run.step = 5e-4;
  Trace trace = trace_ends(run, run.output_times()).left;
  std::minstd_rand random(1);
  std::normal_distribution<double> noise(0.0, 1e-3);
  for (double& value : trace) value += noise(random);
  return trace;
}

Trace model(double alpha) {
  const Case run = bar(alpha);
  return trace_ends(run, run.output_times()).left;
}

double squares(const Trace& a, const Trace& b) {
  double sum = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return sum;
}

template <class Function>
double golden_section(Function f, double low, double high, double width) {
  const double ratio = (std::sqrt(5.0) - 1) / 2;
  double a = high - ratio * (high - low), b = low + ratio * (high - low), at_a = f(a), at_b = f(b);
  while (high - low > width) {
    if (at_a < at_b) {
      high = b, b = a, at_b = at_a;
      at_a = f(a = high - ratio * (high - low));
    } else {
      low = a, a = b, at_a = at_b;
      at_b = f(b = low + ratio * (high - low));
    }
  }
  return (low + high) / 2;
}

}  // namespace

int main() {
  const double truth = 0.07;
  const Trace trace = measured(truth);
  std::size_t runs = 0;
  const auto misfit = [&](double log_alpha) { return ++runs, squares(model(std::exp(log_alpha)), trace); };
  const double alpha = std::exp(golden_section(misfit, std::log(0.01), std::log(1.0), 1e-3));

  const double sigma = std::sqrt(squares(model(alpha), trace) / static_cast<double>(trace.size() - 1));
  const double step = 0.01 * alpha;
  const double slope = std::sqrt(squares(model(alpha + step), model(alpha - step))) / (2 * step);
  const double standard_error = sigma / slope;
  std::printf("alpha = %.5f +- %.5f after %zu runs (the bar was made with %g); noise %.2e (1e-3)\n", alpha,
              standard_error, runs, truth, sigma);
  // Four standard errors, and the width at which the search stopped.
  return std::abs(alpha - truth) < 4 * standard_error + 1e-3 * alpha ? 0 : 1;
}
