#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "support/decompositions.hpp"
#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

// Random bars that are resisted along their length, by every method against a code that shares nothing with them: dense
// matrices written down from docs/side.md, propagated by matrix exponentials from contact change to contact change.
namespace viscobar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct RandomScene {
  int elements;
  std::string mass;
  double eta, k0, k1, c0, c1, load, u0, u1, v, spring, dashpot, end_mass;
  bool left_fixed, right_fixed, obstacle;
  static constexpr double length = 1.3, rho = 1.2, E = 0.9, end = 2.0, epsilon = 0.02, gap = 0.15;

  explicit RandomScene(unsigned seed) {
    std::mt19937 random(seed);
    const auto number = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    const auto sometimes = [&] { return number(0.0, 1.0) < 0.5; };
    elements = 3 + static_cast<int>(number(0.0, 7.0));
    const int which = static_cast<int>(number(0.0, 3.0));
    mass = which == 0 ? "consistent" : which == 1 ? "lumped" : "fourth_order";
    // No jump filter acts on so viscous a bar, and the initial data are those of the nodes.
    eta = mass == "fourth_order" || sometimes() ? number(0.3, 0.8) : 0.0;
    k0 = number(0.0, 8.0), k1 = sometimes() ? number(0.0, 5.0) : 0.0;
    c0 = number(0.0, 2.0), c1 = sometimes() ? number(0.0, 2.0) : 0.0;
    load = sometimes() ? number(-1.0, 1.0) : 0.0;
    left_fixed = sometimes(), right_fixed = sometimes();
    obstacle = !left_fixed && sometimes();
    u0 = number(-0.1, 0.1), u1 = number(-0.2, 0.2), v = number(-1.5, 1.5);
    spring = right_fixed ? 0.0 : sometimes() ? number(0.0, 3.0) : 0.0;
    dashpot = right_fixed ? 0.0 : sometimes() ? number(0.0, 0.4) : 0.0;
    end_mass = right_fixed ? 0.0 : sometimes() ? number(0.0, 1.0) : 0.0;
  }

  double displacement(double x) const { return u0 + u1 * x; }
  // At rest where an end is held, a quadratic, which enters each mass by its values.
  double velocity(double x) const { return v * (left_fixed ? x : 1.0) * (right_fixed ? length - x : 1.0); }

  std::string text(const std::string& method, double step = 1e-3) const {
    std::string scene = fmt::format(
        "[bar]\nlength = {}\ndensity = {}\nmodulus = {}\nviscosity = {}\n[side]\nstiffness = \"{}+{}*x\"\ndrag = "
        "\"{}+{}*x\"\n[initial]\ndisplacement = \"{}+{}*x\"\nvelocity = \"{}{}{}\"\n",
        length, rho, E, eta, k0, k1, c0, c1, u0, u1, v, left_fixed ? "*x" : "",
        right_fixed ? fmt::format("*({}-x)", length) : "");
    if (left_fixed) scene += "[left]\nkind = \"fixed\"\n";
    if (obstacle) scene += fmt::format("[left]\nkind = \"obstacle\"\ngap = {}\n", gap);
    if (right_fixed) scene += "[right]\nkind = \"fixed\"\n";
    if (spring + dashpot + end_mass > 0.0)
      scene +=
          fmt::format("[right]\nkind = \"free\"\nstiffness = {}\ndashpot = {}\nmass = {}\n", spring, dashpot, end_mass);
    if (load != 0.0) scene += fmt::format("[load]\ndensity = {}\n", load);
    return scene +
           fmt::format(
               "[time]\nend = {}\n[mesh]\nelements = {}\nmass = \"{}\"\n[contact]\nepsilon = {}\n[method]\nname = "
               "\"{}\"\nrelative_tolerance = 1e-9\nstep = {}\nstart = \"second_order\"\n[output]\nevery = {}\n",
               end, elements, mass, epsilon, method, step, end);
  }
};

MatrixXd exponential_of(const MatrixXd& a) {
  int halvings = 0;
  MatrixXd x = a;
  while (x.cwiseAbs().rowwise().sum().maxCoeff() > 0.5) x /= 2.0, ++halvings;
  MatrixXd sum = MatrixXd::Identity(a.rows(), a.cols()), term = sum;
  for (int k = 1; k < 20; ++k) sum += term = term * x / k;
  for (int k = 0; k < halvings; ++k) sum = sum * sum;
  return sum;
}

// y = (u, v, 1) over all nodes, those of fixed ends at rest.
class Judge {
 public:
  explicit Judge(const RandomScene& scene) : scene_(scene), n_(scene.elements + 1) {
    const double h = scene.length / scene.elements;
    MatrixXd M = MatrixXd::Zero(n_, n_), K = M;
    for (Index e = 0; e + 1 < n_; ++e) {
      K(e, e) += 1 / h, K(e + 1, e + 1) += 1 / h, K(e, e + 1) -= 1 / h, K(e + 1, e) -= 1 / h;
      const double own = scene.mass == "lumped" ? h / 2 : h / 3, other = scene.mass == "lumped" ? 0.0 : h / 6;
      M(e, e) += own, M(e + 1, e + 1) += own, M(e, e + 1) += other, M(e + 1, e) += other;
    }
    if (scene.mass == "fourth_order") {
      M.setZero();
      for (Index i = 1; i + 1 < n_; ++i) M(i, i) = 10 * h / 12, M(i, i - 1) = M(i, i + 1) = h / 12;
      for (const Index k : {0, 1, 2})
        M(0, k) = M(n_ - 1, n_ - 1 - k) = std::array{7.0, 6.0, -1.0}[static_cast<std::size_t>(k)] * h / 24;
    }
    const auto place = [h](Index j) { return h * static_cast<double>(j); };
    VectorXd k(n_), c(n_);
    for (Index j = 0; j < n_; ++j) k[j] = scene.k0 + scene.k1 * place(j), c[j] = scene.c0 + scene.c1 * place(j);
    inertia_ = scene.rho * M;
    stiffness_ = scene.E * K + M * k.asDiagonal();
    damping_ = scene.eta * K + M * c.asDiagonal();
    inertia_(n_ - 1, n_ - 1) += scene.end_mass;
    stiffness_(n_ - 1, n_ - 1) += scene.spring;
    damping_(n_ - 1, n_ - 1) += scene.dashpot;
    load_ = M * VectorXd::Constant(n_, scene.load);
    y_ = VectorXd::Zero(2 * n_ + 1);
    for (Index j = 0; j < n_; ++j) y_[j] = scene.displacement(place(j)), y_[n_ + j] = scene.velocity(place(j));
    y_[2 * n_] = 1.0;
    open_ = matrix(false), closed_ = matrix(true);
  }

  int run() {
    const double dt = scene_.end / 512;
    const MatrixXd steps[] = {exponential_of(open_ * dt), exponential_of(closed_ * dt)};
    bool closed = false;
    int changes = 0;
    for (int s = 0; s < 512; ++s) {
      for (double left = dt;;) {
        const VectorXd next = left == dt ? VectorXd(steps[closed] * y_)
                                         : VectorXd(exponential_of((closed ? closed_ : open_) * left) * y_);
        const auto crossed = [&](const VectorXd& y) { return scene_.obstacle && (y[0] + scene_.gap < 0.0) != closed; };
        if (!crossed(next)) {
          y_ = next;
          break;
        }
        double low = 0.0, high = left;
        for (int k = 0; k < 50; ++k) {
          const double middle = (low + high) / 2;
          (crossed(exponential_of((closed ? closed_ : open_) * middle) * y_) ? high : low) = middle;
        }
        y_ = exponential_of((closed ? closed_ : open_) * high) * y_;
        slowest = std::min(slowest, std::abs(y_[n_]));
        left -= high;
        closed = !closed, ++changes;
      }
    }
    return changes;
  }

  VectorXd u() const { return y_.head(n_); }
  VectorXd v() const { return y_.segment(n_, n_); }
  // The force that holds a fixed end: the remainder of its row.
  double reaction(bool right) const {
    const Index e = right ? n_ - 1 : 0;
    const VectorXd a = (open_ * y_).segment(n_, n_);
    return inertia_.row(e).dot(a) + damping_.row(e).dot(v()) + stiffness_.row(e).dot(u()) - load_[e];
  }

  double slowest = 1e9;  // velocity at which a contact changes

 private:
  MatrixXd matrix(bool closed) const {
    std::vector<Index> moving;
    for (Index j = 0; j < n_; ++j)
      if (!(j == 0 && scene_.left_fixed) && !(j == n_ - 1 && scene_.right_fixed)) moving.push_back(j);
    MatrixXd stiffness = stiffness_;
    VectorXd load = load_;
    if (closed) stiffness(0, 0) += 1 / scene_.epsilon, load[0] -= scene_.gap / scene_.epsilon;
    const MatrixXd inverse = testing_support::inverse(MatrixXd(inertia_(moving, moving)));
    MatrixXd a = MatrixXd::Zero(2 * n_ + 1, 2 * n_ + 1);
    const MatrixXd of_u = -inverse * stiffness(moving, Eigen::all), of_v = -inverse * damping_(moving, Eigen::all);
    const VectorXd of_load = inverse * VectorXd(load(moving));
    for (std::size_t i = 0; i < moving.size(); ++i) {
      const auto row = static_cast<Index>(i);
      a(moving[i], n_ + moving[i]) = 1.0;
      a.block(n_ + moving[i], 0, 1, n_) = of_u.row(row);
      a.block(n_ + moving[i], n_, 1, n_) = of_v.row(row);
      a(n_ + moving[i], 2 * n_) = of_load[row];
    }
    return a;
  }

  RandomScene scene_;
  Index n_;
  MatrixXd inertia_, stiffness_, damping_, open_, closed_;
  VectorXd load_, y_;
};

double distance(const Recording& run, const Judge& judge) {
  const std::size_t last = run.times.size() - 1;
  double most = 0.0;
  for (std::size_t j = 0; j < run.mesh.nodes(); ++j) {
    most = std::max(most, std::abs(run.displacement(last)[j] - judge.u()[static_cast<Index>(j)]));
    most = std::max(most, std::abs(run.velocity(last)[j] - judge.v()[static_cast<Index>(j)]));
  }
  return most;
}

TEST(Side, RandomBarsMoveAsMatrixExponentialsSayInEveryMethod) {
  int touched = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    const RandomScene scene(seed);
    Judge judge(scene);
    touched += judge.run() > 0;
    if (judge.slowest < 0.02) continue;  // a graze magnifies every error
    for (const char* method : {"cvode", "ida", "arkode", "odeint", "exponential", "rigid"}) {
      if (scene.obstacle && method == std::string("rigid")) continue;
      const std::string text = scene.text(method);
      SCOPED_TRACE(fmt::format("{} {}\n{}", seed, method, text));
      const Recording run = record(parse_scene(text, "").run);
      // A hundred times the tolerance of numbers up to 2, as docs/methods.md promises, and ten times that for what a
      // contact change makes of it.
      EXPECT_LT(distance(run, judge), scene.obstacle ? 2e-6 : 2e-7);
      if (scene.left_fixed) {
        EXPECT_NEAR(run.reaction_left.back(), judge.reaction(false), 2e-6);
      }
      if (scene.right_fixed) {
        EXPECT_NEAR(run.reaction_right.back(), judge.reaction(true), 2e-6);
      }
      const EnergyAccount& energy = *run.statistics.energy;
      EXPECT_NEAR(energy.final, energy.initial + energy.work - energy.dissipated, 1e-6);
    }
    if (scene.obstacle) continue;
    for (const char* method : {"fully_discrete", "finite_difference"}) {
      if (method == std::string("finite_difference") && scene.mass != "lumped") continue;
      const Recording coarse = record(parse_scene(scene.text(method, 2e-3), "").run);
      Recording fine = record(parse_scene(scene.text(method, 1e-3), "").run);
      for (std::size_t i = 0; i < fine.u.size(); ++i) fine.u[i] += (fine.u[i] - coarse.u[i]) / 3.0;
      for (std::size_t i = 0; i < fine.v.size(); ++i) fine.v[i] += (fine.v[i] - coarse.v[i]) / 3.0;
      // Order 2, so what is left is of the third order in the step, times the third power of the highest frequency.
      EXPECT_LT(distance(fine, judge), 2e-4) << seed << " " << method << "\n" << scene.text(method);
      const EnergyAccount& energy = *coarse.statistics.energy;
      EXPECT_NEAR(energy.final, energy.initial + energy.work - energy.dissipated, 1e-12) << seed << " " << method;
    }
  }
  EXPECT_GT(touched, 10);
}

// A quadratic in x, which fourth-order rows hold exactly, driven at its left end.
TEST(Side, DrivenBarHasItsForcesInTheMovingFrame) {
  const std::string scene =
      "[bar]\nlength = 1\nviscosity = 0.2\n[left]\nkind = \"fixed\"\nmotion = \"sin(t)^2\"\n"
      "[side]\nstiffness = 3\ndrag = 0.5\n[load]\n"
      "density = \"(1+x-x^2/2)*(2*cos(2*t)+3*sin(t)^2+0.5*sin(2*t))+sin(t)^2+0.2*sin(2*t)\"\n"
      "[initial]\ndisplacement = 0\n[time]\nend = 2\n[mesh]\nelements = 9\nmass = \"fourth_order\"\n";
  for (const char* method : {"rigid", "cvode", "ida", "arkode", "odeint", "exponential", "fully_discrete"}) {
    SCOPED_TRACE(method);
    const Recording run = record(
        parse_scene(scene + fmt::format("[method]\nname = \"{}\"\nrelative_tolerance = 1e-10\nstep = 1e-3\n", method),
                    "")
            .run);
    const std::size_t last = run.times.size() - 1;
    const double s = std::pow(std::sin(2.0), 2), tolerance = method == std::string("fully_discrete") ? 2e-3 : 1e-8;
    for (std::size_t j = 0; j < run.mesh.nodes(); ++j) {
      const double x = run.mesh.node(j);
      EXPECT_NEAR(run.displacement(last)[j], (1.0 + x - x * x / 2.0) * s, tolerance);
    }
    // -(E u_x + eta u_xt) at x = 0.
    EXPECT_NEAR(run.reaction_left.back(), -(s + 0.2 * std::sin(4.0)), 5.0 * tolerance);
    const EnergyAccount& energy = *run.statistics.energy;
    EXPECT_NEAR(energy.final, energy.initial + energy.work - energy.dissipated, 1e-8);
  }
}

// By differences of runs, of the same nodes.
TEST(Side, SensitivitiesAreThoseOfDifferencesThroughContactToo) {
  const auto text = [](const std::string& method, double p, double q, double gap, double length) {
    return fmt::format(
        "[bar]\nlength = {}\nviscosity = 0.1\n[left]\nkind = \"obstacle\"\ngap = {}\n[right]\nkind = \"free\"\nforce = "
        "\"0.1*sin(3*t)\"\n[parameters]\nq = {}\n[side]\nstiffness = {}\ndrag = \"0.2+q*x\"\n"
        "[initial]\ndisplacement = \"0.1*x\"\nvelocity = -1\n[time]\nend = 2\n[mesh]\nelements = 12\nmass = "
        "\"fourth_order\"\n[contact]\nepsilon = 1e-2\n[method]\nname = \"{}\"\nrelative_tolerance = 1e-10\n[output]\nevery "
        "= 0.25\n[sensitivity]\nof = [\"side.stiffness\", \"parameters.q\", \"left.gap\", \"bar.length\"]\n",
        length, gap, q, p, method);
  };
  for (const char* method : {"rigid", "cvode", "ida", "arkode"}) {
    const Recording run = record(parse_scene(text(method, 2.0, 0.3, 0.1, 1.0), "").run);
    for (std::size_t k = 0; k < 4; ++k) {
      SCOPED_TRACE(fmt::format("{} {}", method, run.sensitivities[k].key));
      const double d = 1e-4;
      const auto moved = [&](double by) {
        return record(parse_scene(text(method, 2.0 + (k == 0 ? by : 0.0), 0.3 + (k == 1 ? by : 0.0),
                                       0.1 + (k == 2 ? by : 0.0), 1.0 + (k == 3 ? by : 0.0)),
                                  "")
                          .run);
      };
      const Recording less = moved(-d), more = moved(d);
      double most = 0.0;
      for (std::size_t i = 0; i < run.u.size(); ++i)
        most = std::max(most, std::abs(run.sensitivities[k].u[i] - (more.u[i] - less.u[i]) / (2.0 * d)));
      // d^2 of the third derivative, and the tolerance of u over d.
      EXPECT_LT(most, 2e-5);
      EXPECT_NEAR(run.statistics.sensitivity->impulse_left[k],
                  (more.statistics.account->left.impulse - less.statistics.account->left.impulse) / (2.0 * d), 2e-5);
      EXPECT_NEAR(run.statistics.sensitivity->energy[k],
                  (more.statistics.energy->final - less.statistics.energy->final) / (2.0 * d), 2e-5);
    }
  }
}

}  // namespace
}  // namespace viscobar
