// Prints the table of docs/fourth-order.md that compares the mass fourth_order with quadratic elements whose inner
// nodes are condensed. Legs are exact in time (matrix exponentials), so that all of the error is that of space. Run:
// cmake --build --preset release --target measure_quadratic_elements && build/release/tests/measure_quadratic_elements
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "support/falling_bar.hpp"
#include "viscobar/case/case.hpp"
#include "viscobar/case/end_traces.hpp"
#include "viscobar/discretisation/tridiagonal.hpp"

namespace {

using namespace viscobar;
using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

// rho = E = L = 1, left end over an obstacle, right end free.
struct Bar1 {
  double viscosity, gap, load, end;
};

// rho M u'' + K (u + eta u') = b + R e_0
struct Space {
  Matrix mass, stiffness;
  Vector load;  // of f = 1
  std::size_t elements;
};

Space fourth_order(std::size_t elements) {
  const auto n = static_cast<Eigen::Index>(elements + 1);
  const double h = 1.0 / static_cast<double>(elements);
  Space space{Matrix::Zero(n, n), Matrix::Zero(n, n), {}, elements};
  for (Eigen::Index i = 0; i + 1 < n; ++i) {
    space.stiffness.block<2, 2>(i, i) += (Eigen::Matrix2d() << 1, -1, -1, 1).finished() / h;
    if (i > 0) space.mass.row(i).segment<3>(i - 1) = h / 12 * Eigen::RowVector3d(1, 10, 1);
  }
  space.mass.row(0).head<3>() = h / 24 * Eigen::RowVector3d(7, 6, -1);
  space.mass.row(n - 1).tail<3>() = h / 24 * Eigen::RowVector3d(-1, 6, 7);
  space.load = space.mass * Vector::Ones(n);
  return space;
}

Space quadratic(std::size_t elements) {
  const auto n = static_cast<Eigen::Index>(2 * elements + 1);
  const double h = 1.0 / static_cast<double>(elements);
  Space space{Matrix::Zero(n, n), Matrix::Zero(n, n), Vector::Zero(n), elements};
  for (Eigen::Index i = 0; i + 2 < n; i += 2) {
    space.stiffness.block<3, 3>(i, i) += (Eigen::Matrix3d() << 7, -8, 1, -8, 16, -8, 1, -8, 7).finished() / (3 * h);
    space.mass.block<3, 3>(i, i) += h / 30 * (Eigen::Matrix3d() << 4, 2, -1, 2, 16, 2, -1, 2, 4).finished();
    space.load.segment<3>(i) += h / 6 * Eigen::Vector3d(1, 4, 1);
  }
  return space;
}

// y' = A y on a leg, y = (u, v, 1), by e^(A s) at s = longest / 2^k and Taylor's series below the last of them.
class Leg {
 public:
  Leg() = default;
  Leg(Matrix rate, double longest) : rate_(std::move(rate)), longest_(longest) {
    const double norm = rate_.cwiseAbs().rowwise().sum().maxCoeff();
    levels_ = std::max(0, static_cast<int>(std::ceil(std::log2(norm * longest)))) + 1;
    Matrix last = Matrix::Identity(rate_.rows(), rate_.cols()), term = last;
    const double s = std::ldexp(longest, -levels_);
    for (int k = 1; k < 18; ++k) last += term = rate_ * term * (s / k);
    powers_.assign(static_cast<std::size_t>(levels_) + 1, last);
    for (std::size_t k = static_cast<std::size_t>(levels_); k > 0; --k) powers_[k - 1] = powers_[k] * powers_[k];
  }

  double length(int k) const { return std::ldexp(longest_, -k); }
  int levels() const { return levels_; }
  Vector step(const Vector& y, int k) const { return powers_[static_cast<std::size_t>(k)] * y; }
  /// Over s, at most the shortest.
  Vector taylor(const Vector& y, double s) const {
    Vector sum = y, term = y;
    for (int k = 1; k < 18; ++k) sum += term = rate_ * term * (s / k);
    return sum;
  }

 private:
  Matrix rate_;
  double longest_ = 0.0;
  int levels_ = 0;
  std::vector<Matrix> powers_;
};

struct Motion {
  std::vector<double> left, right, changes;
  double momentum = 0.0;  // at the last opening
};

Motion follow(const Space& space, const Bar1& bar) {
  const Eigen::Index n = space.load.size();
  constexpr double every = 0.05, rounding = 1e-13;
  const Vector load = bar.load * space.load;
  const auto leg = [&](bool closed) {
    const Eigen::Index first = closed ? 1 : 0, m = n - first;
    const Matrix inverse = space.mass.bottomRightCorner(m, m).inverse();
    Matrix rate = Matrix::Zero(2 * n + 1, 2 * n + 1);
    rate.block(first, n + first, m, m).setIdentity();
    rate.block(n + first, 0, m, n) = -inverse * space.stiffness.bottomRows(m);
    rate.block(n + first, n, m, n) = -bar.viscosity * inverse * space.stiffness.bottomRows(m);
    rate.block(n + first, 2 * n, m, 1) = inverse * load.tail(m);
    return Leg(rate, every);
  };
  const Leg open = leg(false), held = leg(true);
  // Falls through zero at the end of the leg: the clearance, or what row 0 lacks, (M a)_0 + (K (u + eta v))_0 - b_0.
  Vector clearance = Vector::Zero(2 * n + 1), reaction = clearance;
  clearance[0] = 1.0, clearance[2 * n] = bar.gap;
  {
    const Eigen::Index m = n - 1;
    const Eigen::RowVectorXd beside = space.mass.row(0).tail(m) * space.mass.bottomRightCorner(m, m).inverse();
    reaction.head(n) = (space.stiffness.row(0) - beside * space.stiffness.bottomRows(m)).transpose();
    reaction.segment(n, n) = bar.viscosity * reaction.head(n);
    reaction[2 * n] = beside.dot(load.tail(m)) - load[0];
  }
  Vector y = Vector::Zero(2 * n + 1);
  y.segment(n, n).setConstant(-1.0);
  y[2 * n] = 1.0;
  Motion motion;
  double t = 0.0;
  bool closed = false;
  const auto change = [&] {
    motion.changes.push_back(t);
    closed = !closed;
    if (!closed) {
      motion.momentum = (space.mass * y.segment(n, n)).sum();
      return;
    }
    // The other rows keep their momentum.
    const Eigen::Index m = n - 1;
    const Vector kept = (space.mass * y.segment(n, n)).tail(m);
    y[0] = -bar.gap, y[n] = 0.0;
    y.segment(n + 1, m) = space.mass.bottomRightCorner(m, m).partialPivLu().solve(kept);
  };
  if (bar.gap == 0.0) change();
  for (std::size_t k = 1; static_cast<double>(k) * every <= bar.end * (1 + 1e-12); ++k) {
    motion.left.push_back(y[0]), motion.right.push_back(y[n - 1]);
    double rest = every;
    while (rest > 0.0) {
      const Leg& now = closed ? held : open;
      const Vector& indicator = closed ? reaction : clearance;
      const auto holds = [&](const Vector& state) { return indicator.dot(state) >= (closed ? 0.0 : -rounding); };
      int level = 0;  // of the largest step that fits and does not pass a change
      while (level <= now.levels() && (now.length(level) > rest || !holds(now.step(y, level)))) ++level;
      if (level <= now.levels()) {
        y = now.step(y, level), rest -= now.length(level), t += now.length(level);
        continue;
      }
      const double shortest = std::min(rest, now.length(now.levels()));
      if (const Vector next = now.taylor(y, shortest); holds(next)) {
        y = next, rest -= shortest, t += shortest;
        if (rest < 1e-15) rest = 0.0;
        continue;
      }
      double low = 0.0, high = shortest;
      for (int halving = 0; halving < 60; ++halving) {
        const double middle = 0.5 * (low + high);
        (holds(now.taylor(y, middle)) ? low : high) = middle;
      }
      y = now.taylor(y, high), rest -= high, t += high;
      change();
    }
    t = static_cast<double>(k) * every;
  }
  motion.left.push_back(y[0]), motion.right.push_back(y[n - 1]);
  return motion;
}

// Microseconds of what a step of a multistep formula does: a solve, and a sum of ten vectors of (u, v).
double microseconds(std::size_t elements, bool quadratic) {
  const double h = 1.0 / static_cast<double>(elements), k = 1e-3;
  const std::size_t nodes = elements + 1, unknowns = quadratic ? 2 * elements + 1 : nodes;
  BandedMatrix matrix{std::vector<double>(nodes), std::vector<double>(elements)};
  // Entries of D = M + k K on an element.
  const double corner = h / 30 * 4 + k * 7 / (3 * h), side = h / 30 * 2 - k * 8 / (3 * h);
  const double inner = h / 30 * 16 + k * 16 / (3 * h), across = -h / 30 + k / (3 * h), share = side / inner;
  for (std::size_t i = 0; i < nodes; ++i) {
    const double sides = i == 0 || i == elements ? 1.0 : 2.0;
    matrix.diagonal[i] = sides * (quadratic ? corner - share * side : h * 5 / 12 + k / h);
    if (i < elements) matrix.off_diagonal[i] = quadratic ? across - share * side : h / 12 - k / h;
  }
  if (!quadratic)
    matrix.one_sided = {{0, false, {-3 * h / 24, 4 * h / 24, -h / 24}},
                        {matrix.size() - 1, true, {-3 * h / 24, 4 * h / 24, -h / 24}}};
  const TridiagonalFactor factor(matrix);
  std::vector<double> right(unknowns, 1.0), corners(nodes);
  std::vector<std::vector<double>> history(10, std::vector<double>(2 * unknowns, 1e-3));
  std::vector<double> state(2 * unknowns, 0.0);
  const auto step = [&] {
    if (quadratic) {
      for (std::size_t i = 0; i < nodes; ++i)
        corners[i] =
            right[2 * i] - share * ((i > 0 ? right[2 * i - 1] : 0.0) + (i < elements ? right[2 * i + 1] : 0.0));
      factor.solve(corners);
      for (std::size_t i = 0; i < nodes; ++i) {
        right[2 * i] = corners[i];
        if (i < elements) right[2 * i + 1] = right[2 * i + 1] / inner - share * (corners[i] + corners[i + 1]);
      }
    } else {
      factor.solve(right);
    }
    for (const auto& past : history)
      for (std::size_t i = 0; i < state.size(); ++i) state[i] += 1e-3 * past[i];
    for (std::size_t i = 0; i < unknowns; ++i) right[i] = 1.0 + 1e-6 * state[i];
  };
  double best = 1e9;
  for (int attempt = 0; attempt < 15; ++attempt) {
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i < 400; ++i) step();
    best = std::min(best, std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
  }
  return best / 400;
}

struct Row {
  double error, cost;
};

// The cost at which the error is reached, straight between the rows in the logarithms.
double cost_of(const std::vector<Row>& rows, double error) {
  for (std::size_t k = 0; k + 1 < rows.size(); ++k)
    if (rows[k + 1].error <= error && error <= rows[k].error) {
      const double s = std::log(error / rows[k].error) / std::log(rows[k + 1].error / rows[k].error);
      return std::exp((1 - s) * std::log(rows[k].cost) + s * std::log(rows[k + 1].cost));
    }
  return std::nan("");
}

void compare(const std::string& words, const std::function<double(const Motion&)>& error, const Bar1& bar,
             const std::vector<std::size_t>& elements) {
  std::vector<Row> fourth, second;
  std::string cells_fourth, cells_second;
  for (const std::size_t j : elements) {
    fourth.push_back({error(follow(fourth_order(j), bar)), microseconds(j, false)});
    second.push_back({error(follow(quadratic(j / 2), bar)), microseconds(j / 2, true)});
    cells_fourth += fmt::format(" {:.1e}, {:.2f} |", fourth.back().error, fourth.back().cost);
    cells_second += fmt::format(" {:.1e}, {:.2f} |", second.back().error, second.back().cost);
  }
  const double middle = std::sqrt(std::max(fourth.front().error, second.front().error) * 1e-3 *
                                  std::max(fourth.front().error, second.front().error));
  const double ratio = cost_of(second, middle) / cost_of(fourth, middle);
  fmt::print("| {} | fourth_order, J |{} |\n| | quadratic, J/2 |{} {:.2f} at {:.0e} |\n", words, cells_fourth,
             cells_second, ratio, middle);
  std::fflush(stdout);
}

}  // namespace

int main() {
  fmt::print(
      "| scene | elements | J = 20 | 40 | 80 | 160 | cost of quadratic over fourth_order, at the error |\n"
      "|---|---|---|---|---|---|---|\n");
  struct Exact {
    double viscosity, opening, speed;
  };
  for (const auto& [viscosity, opening, speed] :
       {Exact{1.0, 1.3692116746, 0.1503140958}, Exact{0.1, 1.9124710098, 0.6507936369},
        Exact{0.01, 1.9912495450, 0.8874003786}})
    compare(fmt::format("rebound, viscosity {}", viscosity),
            [opening = opening, speed = speed](const Motion& motion) {
              return std::max(std::abs(motion.changes[1] - opening), std::abs(motion.momentum - speed));
            },
            {viscosity, 0.0, 0.0, 2.5}, {20, 40, 80, 160});
  for (const double viscosity : {0.003, 0.001}) {
    Case run;
    run.scene = falling_bar(0.1, 1.0, viscosity);
    run.scene.load = SteadyLoad{[](double) { return -1.0; }};
    run.method = MethodName::rigid;
    run.mass = Mass::fourth_order;
    run.elements = 1000;
    run.tolerance = {1e-11, 1e-14};
    run.end = 6.0;
    run.output_every = 0.05;
    const EndTraces reference = trace_ends(run, run.output_times());
    compare(fmt::format("pressed by -1, viscosity {}", viscosity),
            [&](const Motion& motion) {
              double off = 0.0;
              for (std::size_t k = 0; k < motion.left.size(); ++k)
                off = std::max({off, std::abs(motion.left[k] - reference.left[k]),
                                std::abs(motion.right[k] - reference.right[k])});
              return off;
            },
            {viscosity, 0.1, -1.0, 6.0}, {20, 40, 80, 160});
  }
}
