#include "integration/bernstein.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "discretisation/dense.hpp"
#include "run/step_failure.hpp"

namespace viscobar {

namespace {

double binomial(std::size_t n, std::size_t k) {
  double value = 1.0;
  for (std::size_t i = 0; i < k; ++i) value = value * static_cast<double>(n - i) / static_cast<double>(i + 1);
  return value;
}

// Samples at equidistant points to coefficients: what each sample adds to them. 0 behind the degree, so that sums are
// of one length, in whole vectors.
constexpr std::size_t padded = 16;
static_assert(Bernstein::max_degree < padded && padded <= Bernstein::max_power + 1);
using Padded = Eigen::Array<double, padded, 1>;
using OfSamples = std::array<Padded, Bernstein::max_degree + 1>;

const OfSamples& coefficients_of_samples(std::size_t degree) {
  static const std::vector<OfSamples> tables = [] {
    std::vector<OfSamples> list(Bernstein::max_degree + 1);
    for (OfSamples& of : list) of.fill(Padded::Zero());
    for (std::size_t q = 0; q <= Bernstein::max_degree; ++q) {
      const auto size = static_cast<Eigen::Index>(q + 1);
      Eigen::MatrixXd values(size, size);
      for (std::size_t i = 0; i <= q; ++i) {
        const double s = q ? static_cast<double>(i) / static_cast<double>(q) : 0.0;
        for (std::size_t j = 0; j <= q; ++j)
          values(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
              binomial(q, j) * std::pow(s, static_cast<double>(j)) * std::pow(1.0 - s, static_cast<double>(q - j));
      }
      const Eigen::MatrixXd of_samples = inverse(values);
      for (Eigen::Index j = 0; j < size; ++j) list[q][static_cast<std::size_t>(j)].head(size) = of_samples.col(j);
    }
    return list;
  }();
  return tables[degree];
}

double de_casteljau(std::array<double, Bernstein::max_power + 1> c, std::size_t degree, double s) {
  for (std::size_t r = degree; r > 0; --r)
    for (std::size_t j = 0; j < r; ++j) c[j] += s * (c[j + 1] - c[j]);
  return c[0];
}

}  // namespace

Bernstein Bernstein::through(std::span<const double> samples) {
  assert(!samples.empty() && samples.size() <= max_degree + 1);
  Bernstein p;
  p.degree_ = samples.size() - 1;
  const OfSamples& of = coefficients_of_samples(p.degree_);
  // Sums of their own, which stay in registers.
  using Four = Eigen::Array4d;
  const auto part = [&](std::size_t j, Eigen::Index k) { return Four::Map(of[j].data() + 4 * k) * samples[j]; };
  Four a = part(0, 0), b = part(0, 1), c = part(0, 2);
  for (std::size_t j = 1; j < samples.size(); ++j) {
    a += part(j, 0);
    b += part(j, 1);
    c += part(j, 2);
  }
  for (const auto& [k, sum] : {std::pair{0, &a}, {4, &b}, {8, &c}}) Four::Map(p.c_.data() + k) = *sum;
  for (std::size_t j = 0; p.degree_ >= 12 && j < samples.size(); ++j) p.c_[12] += of[j][12] * samples[j];
  return p;
}

Bernstein Bernstein::between(double from, double to) const {
  Bernstein part = *this;
  double* const c = part.c_.data();
  for (std::size_t r = degree_; r > 0; --r)
    for (std::size_t j = 0; j < r; ++j) c[j] += from * (c[j + 1] - c[j]);
  const double share = (to - from) / (1.0 - from);
  for (std::size_t first = 1; first <= degree_ && share < 1.0; ++first)
    for (std::size_t j = degree_; j >= first; --j) c[j] = c[j - 1] + share * (c[j] - c[j - 1]);
  return part;
}

Bernstein Bernstein::negative() const {
  Bernstein other = *this;
  for (double& c : other.c_) c = -c;
  return other;
}

double Bernstein::mean() const {
  return std::accumulate(c_.begin(), c_.begin() + static_cast<std::ptrdiff_t>(degree_) + 1, 0.0) /
         static_cast<double>(degree_ + 1);
}

Bernstein Bernstein::of_powers(std::span<const double> coefficients) {
  assert(!coefficients.empty() && coefficients.size() <= max_power + 1);
  Bernstein p;
  p.degree_ = coefficients.size() - 1;
  std::ranges::copy(coefficients, p.c_.begin());
  double binomial = 1.0;
  for (std::size_t k = 1; k <= p.degree_; ++k) {
    binomial *= static_cast<double>(p.degree_ - k + 1) / static_cast<double>(k);
    p.c_[k] /= binomial;
  }
  for (std::size_t first = 1; first <= p.degree_; ++first)
    for (std::size_t k = p.degree_; k >= first; --k) p.c_[k] += p.c_[k - 1];
  return p;
}

double Bernstein::operator()(double s) const { return de_casteljau(c_, degree_, s); }

double Bernstein::mean(std::span<const double> samples) {
  static const std::array<std::array<double, max_degree + 1>, max_degree + 1> weights = [] {
    std::array<std::array<double, max_degree + 1>, max_degree + 1> all{};
    for (std::size_t q = 0; q <= max_degree; ++q)
      for (std::size_t j = 0; j <= q; ++j) all[q][j] = coefficients_of_samples(q)[j].sum() / static_cast<double>(q + 1);
    return all;
  }();
  return std::inner_product(samples.begin(), samples.end(), weights[samples.size() - 1].begin(), 0.0);
}

// By Lagrange's form: with w_j = (-1)^j binom(q,j) it is q (w_j / w_i) / (i - j) that sample j adds at i, and at itself
// what makes a constant's derivative 0.
std::array<double, 16> Bernstein::slopes(std::span<const double> samples) {
  static const std::array<OfSamples, max_degree + 1> tables = [] {
    std::array<OfSamples, max_degree + 1> all;
    for (OfSamples& of : all) of.fill(Padded::Zero());
    for (std::size_t q = 1; q <= max_degree; ++q)
      for (std::size_t i = 0; i <= q; ++i)
        for (std::size_t j = 0; j <= q; ++j) {
          if (i == j) continue;
          const double apart = static_cast<double>(i) - static_cast<double>(j), sign = (i + j) % 2 == 0 ? 1.0 : -1.0;
          const double slope = sign * static_cast<double>(q) * binomial(q, j) / (binomial(q, i) * apart);
          all[q][j][static_cast<Eigen::Index>(i)] = slope;
          all[q][i][static_cast<Eigen::Index>(i)] -= slope;
        }
    return all;
  }();
  const OfSamples& of = tables[samples.size() - 1];
  std::array<double, padded> out;
  Padded::Map(out.data()) = of[0] * samples[0];
  for (std::size_t j = 1; j < samples.size(); ++j) Padded::Map(out.data()) += of[j] * samples[j];
  return out;
}

double Bernstein::excess(std::size_t degree) {
  // Lebesgue's constants of equidistant points, rounded up.
  constexpr std::array<double, max_degree + 1> lebesgue = {1.0,  1.0,   1.26,  1.64,  2.21,  3.11, 4.55,
                                                           6.93, 10.95, 17.85, 29.91, 51.22, 89.33};
  return 0.5 * (lebesgue[degree] - 1.0);
}

double Bernstein::steepest(std::size_t degree) {
  static const std::array<double, max_degree + 1> largest = [] {
    std::array<double, max_degree + 1> all{};
    for (std::size_t q = 0; q <= max_degree; ++q) {
      std::array<double, max_degree + 1> samples{};
      Padded sum = Padded::Zero();
      for (std::size_t j = 0; j <= q; ++j) {
        samples[j] = 1.0;
        sum += Padded::Map(slopes(std::span(samples).first(q + 1)).data()).abs();
        samples[j] = 0.0;
      }
      all[q] = sum.maxCoeff();
    }
    return all;
  }();
  return largest[degree];
}

namespace {

struct Interval {
  std::array<double, Bernstein::max_power + 1> c;
  double begin, length;

  // The left half; this becomes the right one.
  Interval split(std::size_t degree) {
    length /= 2;
    Interval left{{}, begin, length};
    begin += length;
    for (std::size_t r = 0; r <= degree; ++r) {
      left.c[r] = c[0];
      for (std::size_t j = 0; j + r < degree; ++j) c[j] = 0.5 * (c[j] + c[j + 1]);
    }
    return left;
  }
};

// The last place, to `finest`, where a polynomial that falls throughout, from the threshold or above to below it,
// is not below. Newton's method between two places on either side; each step goes a little too far, so that both close
// in.
double crossing(const Interval& on, std::size_t degree, double threshold, double finest) {
  double low = 0.0, high = 1.0, s = (on.c[0] - threshold) / (on.c[0] - on.c[degree]);
  const double apart = finest / on.length;
  for (int step = 0; step < 100 && high - low > apart; ++step) {
    if (!(s > low && s < high)) s = 0.5 * (low + high);
    if (s == low || s == high) break;
    auto c = on.c;
    for (std::size_t r = degree; r > 1; --r)
      for (std::size_t j = 0; j < r; ++j) c[j] += s * (c[j + 1] - c[j]);
    const double slope = c[1] - c[0], excess = c[0] + s * slope - threshold;
    (excess < 0.0 ? high : low) = s;
    s += (excess < 0.0 ? -0.5 : 0.5) * apart - excess / (static_cast<double>(degree) * slope);
  }
  return on.begin + low * on.length;
}

// The first descent below the threshold: an interval is given up once its hull stays above, or begins too late.
std::optional<double> descend(Interval on, std::size_t degree, double threshold, double finest, double before) {
  const auto end = on.c.begin() + static_cast<std::ptrdiff_t>(degree) + 1;
  if (on.begin >= before || *std::min_element(on.c.begin(), end) >= threshold) return std::nullopt;
  if (on.c[0] < threshold || on.length <= finest) return on.begin;
  if (on.c[degree] < threshold && std::is_sorted(on.c.begin(), end, std::greater<>())) {
    if (before < on.begin + on.length && de_casteljau(on.c, degree, (before - on.begin) / on.length) >= threshold)
      return std::nullopt;
    return crossing(on, degree, threshold, finest);
  }
  const Interval left = on.split(degree);
  if (const auto found = descend(left, degree, threshold, finest, before)) return found;
  return descend(on, degree, threshold, finest, before);
}

// Raises `known` to the largest value on the interval, unless its hull stays below.
void raise(Interval on, std::size_t degree, double rounding, double& known) {
  constexpr double finest = 1e-9;  // squared, it is what the value at a maximum loses by its place
  const auto end = on.c.begin() + static_cast<std::ptrdiff_t>(degree) + 1;
  if (*std::max_element(on.c.begin(), end) <= known + rounding || on.length < finest) return;
  Interval slope{{}, 0.0, 1.0};
  for (std::size_t j = 0; j < degree; ++j) slope.c[j] = on.c[j + 1] - on.c[j];
  const auto slope_end = slope.c.begin() + static_cast<std::ptrdiff_t>(degree);
  if (slope.c[0] > 0.0 && slope.c[degree - 1] < 0.0 && std::is_sorted(slope.c.begin(), slope_end, std::greater<>())) {
    known = std::max(known, de_casteljau(on.c, degree, crossing(slope, degree - 1, 0.0, finest)));
    return;
  }
  const Interval left = on.split(degree);
  known = std::max(known, on.c[0]);
  raise(on, degree, rounding, known);
  raise(left, degree, rounding, known);
}

}  // namespace

double Bernstein::largest(double known) const {
  double sum = c_[0], least = c_[0], most = c_[0];
  for (std::size_t j = 1; j <= degree_; ++j) sum += c_[j], least = std::min(least, c_[j]), most = std::max(most, c_[j]);
  if (most <= known) return known;
  if (!std::isfinite(sum)) throw not_finite();  // comparisons would halve for ever
  known = std::max({known, c_[0], c_[degree_]});
  const double rounding = std::numeric_limits<double>::epsilon() * std::max(std::abs(most), std::abs(least));
  if (most > known + rounding) raise({c_, 0.0, 1.0}, degree_, rounding, known);
  return known;
}

double Bernstein::smallest(double known) const { return -negative().largest(-known); }

std::optional<double> Bernstein::first_descent(double threshold, double finest, double before) const {
  // Mostly nothing descends: that is told before anything is copied.
  double sum = c_[0], least = c_[0];
  for (std::size_t j = 1; j <= degree_; ++j) sum += c_[j], least = std::min(least, c_[j]);
  if (!std::isfinite(sum)) throw not_finite();
  if (least >= threshold) return std::nullopt;
  return descend({c_, 0.0, 1.0}, degree_, threshold, finest, before);
}

}  // namespace viscobar
