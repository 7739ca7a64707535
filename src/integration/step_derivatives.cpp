// The derivatives by parameters in a StepPolynomial.
#include <array>
#include <cmath>

#include "integration/relaxed_powers.hpp"
#include "integration/step_polynomial.hpp"

namespace viscobar {

std::array<double, 2> StepPolynomial::derivative_at(std::size_t k, std::size_t i, double s) const {
  const std::size_t n = layout_.nodes;
  const double h = length();
  const auto y0 = layout_.derivative(std::span(begin_.y), k), y1 = layout_.derivative(std::span(end_.y), k);
  const double *r0 = begin_.derivative_rates.data() + k * layout_.block,
               *r1 = end_.derivative_rates.data() + k * layout_.block;
  const double half = 0.5 * h * (y0[n + i] + y1[n + i]), rise = y1[i] - y0[i], a1 = r1[n + i];
  const double a0 = forgotten_ ? a1 + 12.0 / (h * h) * (rise - half) : r0[n + i];
  const double missing = rise - half + h * h / 12.0 * (a1 - a0);
  const auto at = [&](const Weights& weight) {
    return h * (weight.w0 * y0[n + i] + weight.w1 * y1[n + i] + h * (weight.a0 * a0 + weight.a1 * a1)) +
           weight.defect * missing;
  };
  return {y0[i] + at(weights(s, 0)), at(weights(s, 1)) / h};
}

double StepPolynomial::relaxed_derivative(const Relaxation& relaxation, std::size_t k, double s) const {
  constexpr std::size_t points = 6;
  Derivative& derivative = *derivatives_[k];
  const std::size_t node = relaxation.row.unknown, next = relaxation.row.neighbours[0].unknown;
  for (const PenalisedSystem::RelaxingRow& row : derivative.motion().relaxing_rows()) {
    if (row.unknown != node) continue;
    const double h = length();
    // Newton's form through s = 0, 1/5, ..., 1, and its powers.
    std::array<double, points> f{}, drive{};
    for (std::size_t j = 0; j < points; ++j) {
      const double at = static_cast<double>(j) / (points - 1);
      const auto [of_next, rate_of_next] = derivative_at(k, next, at);
      const double u = value(node, at, 0);
      const double force =
          derivative.motion().load_alone(node, begin_.t + at * h) +
          derivative.drive_row(node, begin_.t + at * h, u, value(next, at, 0), value(node, at, 1), value(next, at, 1));
      f[j] = row.constant + row.neighbours[0].u_share * of_next + row.neighbours[0].w_share * rate_of_next +
             row.load_share * force;
    }
    for (std::size_t order = 1; order < points; ++order)
      for (std::size_t j = points - 1; j >= order; --j)
        f[j] = (f[j] - f[j - 1]) * (points - 1) / static_cast<double>(order);
    drive[0] = f[points - 1];
    for (std::size_t j = points - 1; j-- > 0;) {
      const double at = static_cast<double>(j) / (points - 1);
      for (std::size_t p = points - 1; p > 0; --p) drive[p] = drive[p - 1] - at * drive[p];
      drive[0] = f[j] - at * drive[0];
    }
    const std::array<double, 6> powers = relaxed_powers(row.rate * h, s);
    double sum = 0.0;
    for (std::size_t p = 0; p < points; ++p) sum += drive[p] * powers[p];
    return std::exp(-row.rate * h * s) * layout_.derivative(std::span(begin_.y), k)[node] + h * sum;
  }
  return derivative_at(k, node, s)[0];
}

void StepPolynomial::derivatives_at(double t, std::span<double> y) const {
  const std::size_t n = layout_.nodes;
  const double h = length(), s = (t - begin_.t) / h, back = 1.0 - s;
  for (std::size_t k = 0; k < layout_.derivatives; ++k) {
    const auto y0 = layout_.derivative(std::span(begin_.y), k), y1 = layout_.derivative(std::span(end_.y), k);
    const double *r0 = begin_.derivative_rates.data() + k * layout_.block,
                 *r1 = end_.derivative_rates.data() + k * layout_.block;
    const auto out = layout_.derivative(y, k);
    const auto cubic = [&](std::size_t i) {
      return y0[i] + s * s * (3.0 - 2.0 * s) * (y1[i] - y0[i]) + h * s * back * (back * r0[i] - s * r1[i]);
    };
    for (std::size_t i = 0; i < n; ++i) {
      const auto [displacement, velocity] = derivative_at(k, i, s);
      out[i] = displacement, out[n + i] = velocity;
    }
    for (std::size_t r = 0; r < relaxations_.size(); ++r) {
      const std::size_t i = relaxations_[r].row.unknown;
      out[i] = r < massless_ ? relaxed_derivative(relaxations_[r], k, s) : cubic(i);
      out[n + i] = y0[n + i] + s * (y1[n + i] - y0[n + i]);
    }
    for (std::size_t i = 2 * n; i < layout_.block; ++i) out[i] = cubic(i);
  }
}

}  // namespace viscobar
