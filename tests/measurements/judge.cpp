// Judges the judge: the exponential method against a simulation of the same penalised bars with 113-bit numbers, which
// shares with it the matrices' entries and nothing else. Two bars that are thrown between two obstacles, pressed to one
// and come to rest. Run:
//     cmake --build --preset release --target measure_judge && build/release/tests/measure_judge
#include <fmt/format.h>

#include <algorithm>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <map>
#include <vector>

#include "dynamics/penalised_system.hpp"
#include "support/pressed_bar.hpp"
#include "viscobar/case/recording.hpp"

namespace {

using namespace viscobar;
using Real = boost::multiprecision::cpp_bin_float_quad;
using Vector = std::vector<Real>;
using Matrix = std::vector<Vector>;

/// y' = A y for y = (u, w, 1), constant while no contact changes; u of the two end nodes is measured from their
/// obstacles. Steps by exp(A tau) - I, a Taylor sum squared; a change is found by bisection of a Taylor step.
class Simulation {
 public:
  explicit Simulation(const Case& run) : bar_(resolve(run).system()), n_(bar_.size()), m_(2 * n_ + 1) {
    const Penalty law{run.epsilon, run.restitution.value_or(1.0)};
    Matrix inertia(n_, Vector(n_, 0));
    inverse_ = inertia;
    for (std::size_t i = 0; i < n_; ++i) {
      inertia[i][i] = bar_.inertia().matrix().diagonal[i];
      inverse_[i][i] = 1;
      if (i + 1 < n_ && !bar_.inertia().matrix().off_diagonal.empty())
        inertia[i][i + 1] = inertia[i + 1][i] = bar_.inertia().matrix().off_diagonal[i];
    }
    for (std::size_t p = 0; p < n_; ++p) {
      const Real pivot = inertia[p][p];
      for (std::size_t j = 0; j < n_; ++j) inertia[p][j] /= pivot, inverse_[p][j] /= pivot;
      for (std::size_t i = 0; i < n_; ++i) {
        if (i == p) continue;
        const Real factor = inertia[i][p];
        for (std::size_t j = 0; j < n_; ++j)
          inertia[i][j] -= factor * inertia[p][j], inverse_[i][j] -= factor * inverse_[p][j];
      }
    }
    for (const Contact& contact : bar_.contacts())
      laws_.push_back(penalty_law(law, contact.weight, bar_.inertia().contact_mass(contact)));
    load_.assign(n_, 0);
    PenalisedSystem loaded(bar_, law);
    for (std::size_t i = 0; i < n_; ++i) load_[i] = loaded.load().at(i, 0.0);  // steady
    y_.assign(m_, 1);
    for (std::size_t i = 0; i < n_; ++i) {
      y_[i] = Real(bar_.initial_state().u[i]) + offset(i);
      y_[n_ + i] = bar_.initial_state().v[i];
    }
    for (std::size_t c = 0; c < 2; ++c)
      if (y_[node(c)] <= 0 && y_[n_ + node(c)] < 0) closed_ |= 1u << c;
  }

  /// To the given time; u of all nodes there.
  Vector at(const Real& time) {
    while (t_ < time) advance(time);
    Vector u(n_);
    for (std::size_t i = 0; i < n_; ++i) u[i] = y_[i] - offset(i);
    return u;
  }
  std::size_t changes() const { return changes_; }

 private:
  struct Leg {
    Matrix a;
    Real finest, rate = 0, decay = 0;
    std::vector<Matrix> increments;  // exp(A finest 2^k) - I
  };

  std::size_t node(std::size_t c) const { return bar_.contacts()[c].unknown; }
  Real offset(std::size_t i) const {
    for (std::size_t c = 0; c < 2; ++c)
      if (node(c) == i) return bar_.contacts()[c].gap;
    return 0;
  }

  Leg& leg() {
    const auto [found, fresh] = legs_.try_emplace(closed_);
    Leg& leg = found->second;
    if (!fresh) return leg;
    const Real stiffness = Real(bar_.bar().modulus) / bar_.mesh().spacing();
    const Real viscosity = Real(bar_.bar().viscosity) / bar_.mesh().spacing();
    Matrix of_u(n_, Vector(n_, 0)), of_w = of_u;
    Vector constant = load_;
    for (std::size_t i = 0; i + 1 < n_; ++i) {
      const Real apart = stiffness * (offset(i) - offset(i + 1));
      constant[i] += apart, constant[i + 1] -= apart;
      for (const auto& [row, sign] : {std::pair{i, -1}, std::pair{i + 1, 1}}) {
        of_u[row][i] += sign * stiffness, of_u[row][i + 1] -= sign * stiffness;
        of_w[row][i] += sign * viscosity, of_w[row][i + 1] -= sign * viscosity;
      }
    }
    for (std::size_t c = 0; c < 2; ++c) {
      if (!(closed_ >> c & 1u)) continue;
      const std::size_t i = node(c);
      of_u[i][i] -= laws_[c].stiffness, of_w[i][i] -= laws_[c].damping;
      const Real rate = sqrt(laws_[c].stiffness * inverse_[i][i]);
      const Real decay = std::min(rate, Real(laws_[c].damping * inverse_[i][i] / 2));
      leg.decay = leg.rate == 0 ? decay : std::min(leg.decay, decay);
      leg.rate = std::max(leg.rate, rate);
    }
    leg.a.assign(m_, Vector(m_, 0));
    for (std::size_t i = 0; i < n_; ++i) {
      leg.a[i][n_ + i] = 1;
      for (std::size_t k = 0; k < n_; ++k) {
        for (std::size_t j = 0; j < n_; ++j) {
          leg.a[n_ + i][j] += inverse_[i][k] * of_u[k][j];
          leg.a[n_ + i][n_ + j] += inverse_[i][k] * of_w[k][j];
        }
        leg.a[n_ + i][2 * n_] += inverse_[i][k] * constant[k];
      }
    }
    const Real fastest = 4 * leg.rate + sqrt(16 * stiffness * inverse_[0][0]) + 8 * viscosity * inverse_[0][0];
    leg.finest = 1;
    while (leg.finest * fastest > 0.5) leg.finest /= 2;
    return leg;
  }

  Matrix product(const Matrix& a, const Matrix& b) const {
    Matrix c(m_, Vector(m_, 0));
    for (std::size_t i = 0; i < m_; ++i)
      for (std::size_t k = 0; k < m_; ++k)
        if (a[i][k] != 0)
          for (std::size_t j = 0; j < m_; ++j) c[i][j] += a[i][k] * b[k][j];
    return c;
  }

  Vector step(Leg& leg, std::size_t level, const Vector& y) const {
    while (leg.increments.size() <= level) {
      Matrix next(m_, Vector(m_, 0));
      if (leg.increments.empty()) {
        Matrix power = next;
        for (std::size_t i = 0; i < m_; ++i) power[i][i] = 1;
        for (int j = 1; j < 40; ++j) {
          power = product(power, leg.a);
          for (std::size_t a = 0; a < m_; ++a)
            for (std::size_t b = 0; b < m_; ++b) next[a][b] += power[a][b] *= leg.finest / j;
        }
      } else {
        const Matrix& last = leg.increments.back();
        next = product(last, last);
        for (std::size_t a = 0; a < m_; ++a)
          for (std::size_t b = 0; b < m_; ++b) next[a][b] += 2 * last[a][b];
      }
      leg.increments.push_back(std::move(next));
    }
    Vector z = y;
    for (std::size_t i = 0; i < m_; ++i)
      for (std::size_t j = 0; j < m_; ++j) z[i] += leg.increments[level][i][j] * y[j];
    return z;
  }

  Vector taylor(const Leg& leg, const Real& s, const Vector& y) const {
    Vector sum = y, term = y;
    for (int k = 1; k < 40; ++k) {
      Vector next(m_, 0);
      for (std::size_t i = 0; i < m_; ++i)
        for (std::size_t j = 0; j < m_; ++j) next[i] += leg.a[i][j] * term[j];
      for (std::size_t i = 0; i < m_; ++i) sum[i] += term[i] = next[i] * (s / k);
    }
    return sum;
  }

  bool passed(std::size_t c, const Vector& y) const { return closed_ >> c & 1u ? y[node(c)] > 0 : y[node(c)] < 0; }
  bool passed(const Vector& y) const { return passed(0, y) || passed(1, y); }

  // Eight samples of a step that is short beside the motion of an element, and while a spring oscillates beside that.
  void advance(const Real& end) {
    Leg& now = leg();
    const Bar& bar = bar_.bar();
    Real longest = bar_.mesh().spacing() * bar.slowness() / 16;
    if (now.rate > 0 && since_ * now.decay < 90) longest = std::min(longest, Real(1 / now.rate));
    std::size_t level = 0;
    while (level < level_ && ldexp(now.finest, static_cast<int>(level) + 1) <= longest) ++level;
    while (level > 0 && ldexp(now.finest, static_cast<int>(level)) > end - t_) --level;
    Real length = ldexp(now.finest, static_cast<int>(level));
    const bool cut = length > end - t_;
    if (cut) length = end - t_;
    Vector y = y_;
    bool change = false;
    if (level == 0) {
      for (int p = 1; p <= 4 && !change; ++p) change = passed(y = taylor(now, length * p / 4, y_));
    } else {
      const std::size_t part = level >= 3 ? level - 3 : 0, pieces = std::size_t{1} << (level - part);
      for (std::size_t p = 0; p < pieces && !change; ++p) change = passed(y = step(now, part, y));
    }
    if (change && level > 0) {
      level_ = level - 1;
    } else if (change) {
      Real low = 0, high = length;
      for (int p = 1; p <= 4; ++p)
        if (passed(taylor(now, length * p / 4, y_))) {
          low = length * (p - 1) / 4, high = length * p / 4;
          break;
        }
      for (int halving = 0; halving < 112; ++halving) {
        const Real middle = (low + high) / 2;
        (passed(taylor(now, middle, y_)) ? high : low) = middle;
      }
      y = taylor(now, high, y_);
      unsigned after = closed_;
      for (std::size_t c = 0; c < 2; ++c)
        if (passed(c, y)) after ^= 1u << c, y[node(c)] = 0, ++changes_;
      y_ = y, t_ += high, closed_ = after, since_ = 0, level_ = 0;
    } else {
      y_ = y, since_ += length, level_ = std::min<std::size_t>(level + 1, 60);
      t_ = cut ? end : t_ + length;
    }
  }

  BarSystem bar_;
  std::size_t n_, m_;
  Matrix inverse_;
  std::vector<PenaltyLaw> laws_;
  Vector load_, y_;
  std::map<unsigned, Leg> legs_;
  unsigned closed_ = 0;
  Real t_ = 0, since_ = 0;
  std::size_t level_ = 0, changes_ = 0;
};

void judge(const char* what, Case run, double epsilon, double restitution) {
  run.method = MethodName::exponential;
  run.epsilon = epsilon;
  run.restitution = restitution;
  const Recording recording = record(run);
  Simulation simulation(run);
  double off = 0.0, largest = 0.0;
  for (std::size_t k = 0; k < recording.times.size(); ++k) {
    const Vector u = simulation.at(Real(recording.times[k]));
    for (std::size_t i = 0; i < u.size(); ++i) {
      off = std::max(off, std::abs(static_cast<double>(u[i] - recording.displacement(k)[i])));
      largest = std::max(largest, std::abs(static_cast<double>(u[i])));
    }
  }
  fmt::print("| {} | {:g} | {:g} | {} | {} | {:.1e} |\n", what, epsilon, restitution, recording.events.size(),
             simulation.changes(), off / largest);
}

}  // namespace

int main() {
  const Case two = pressed_bar_of_two(), four = pressed_bar_of_four();
  fmt::print("| bar | epsilon | restitution | changes | of the simulation | largest error of u, relative |\n");
  fmt::print("|---|---|---|---|---|---|\n");
  judge("2 elements", two, 1e-9, 0.3);
  judge("4 elements", four, 1e-7, 0.0);
  judge("4 elements", four, 1e-10, 0.3);
  judge("4 elements", four, 1.36e-11, 0.5);
}
