// Random bars between random stops, by five methods and by an integration of the plain nodal equations.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <boost/numeric/odeint.hpp>
#include <cmath>
#include <random>

#include "laws/scene.hpp"
#include "support/decompositions.hpp"

namespace viscobar::laws {
namespace {

struct End {
  std::string law;  // "penalty", or empty: free
  double stiffness = 0.0, damping = 0.0, gap = 0.0, mass = 0.0;
};

struct Scene {
  double length, density, modulus, viscosity, speed, force, frequency, end;
  int elements;
  std::string mass;
  std::array<End, 2> ends;
};

Scene draw(unsigned seed) {
  std::mt19937 generator(seed);
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(generator); };
  const auto log = [&](double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); };
  const auto one_of = [&](auto... all) {
    const std::array words{std::string(all)...};
    return words[std::uniform_int_distribution<std::size_t>(0, words.size() - 1)(generator)];
  };
  Scene scene;
  scene.length = uniform(0.5, 2.0), scene.density = uniform(0.5, 2.0), scene.modulus = uniform(0.5, 2.0);
  scene.viscosity = uniform(0.0, 1.0) < 0.3 ? 0.0 : log(0.01, 0.5);
  scene.speed = uniform(-1.0, 1.0);
  scene.force = uniform(0.0, 1.0) < 0.5 ? 0.0 : uniform(-0.5, 0.5), scene.frequency = uniform(1.0, 4.0);
  scene.end = uniform(3.0, 6.0);
  scene.elements = static_cast<int>(uniform(3.0, 12.0));
  scene.mass = one_of("fourth_order", "consistent", "lumped");
  for (End& end : scene.ends) {
    end.law = one_of("", "penalty", "spring_damper", "hertz", "hunt_crossley");
    if (&end == &scene.ends[0] && (end.law.empty() || end.law == "penalty")) end.law = "spring_damper";
    end.stiffness = log(3.0, 1000.0);
    if (end.law == "spring_damper") end.damping = uniform(0.0, 1.0) < 0.2 ? 0.0 : log(0.01, 3.0);
    if (end.law == "hunt_crossley") end.damping = log(0.05, 3.0);
    end.gap = uniform(0.0, 0.3);
    end.mass = uniform(0.0, 1.0) < 0.3 ? log(0.01, 2.0) : 0.0;
  }
  return scene;
}

std::string text_of(const Scene& scene, const char* method) {
  std::string text = fmt::format("[bar]\nlength = {:.17g}\ndensity = {:.17g}\nmodulus = {:.17g}\nviscosity = {:.17g}\n",
                                 scene.length, scene.density, scene.modulus, scene.viscosity);
  for (const bool right : {false, true}) {
    const End& end = scene.ends[right];
    text += right ? "[right]\n" : "[left]\n";
    text += fmt::format("mass = {:.17g}\n", end.mass);
    if (!right && scene.force != 0.0)
      text += fmt::format("force = \"{:.17g}*(1-cos({:.17g}*t))\"\n", scene.force, scene.frequency);
    if (end.law.empty()) {
      text += "kind = \"free\"\n";
      continue;
    }
    text += fmt::format("kind = \"obstacle\"\ngap = {:.17g}\nside = \"{}\"\n", end.gap, right ? "above" : "below");
    if (end.law != "penalty") text += contact(end.law, end.stiffness, end.damping);
  }
  if (scene.ends[1].law == "penalty")
    text += fmt::format("[contact]\nepsilon = {:.17g}\n", 1.0 / scene.ends[1].stiffness);
  return text + fmt::format(
                    "[initial]\nvelocity = {:.17g}\n[time]\nend = {:.17g}\n[mesh]\nelements = {}\nmass = "
                    "\"{}\"\n[method]\nname = \"{}\"\nrelative_tolerance = 1e-9\n[output]\nevery = {:.17g}\n",
                    scene.speed, scene.end, scene.elements, scene.mass, method, scene.end);
}

// M u'' = F e_0 - E K u - eta K u' + N_0 e_0 - N_J e_J, the reactions cut off by hand; the last two unknowns are the
// impulses.
std::vector<double> reference(const Scene& scene) {
  const int n = scene.elements + 1;
  const double h = scene.length / scene.elements;
  Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(n, n), stiffness = mass;
  for (int e = 0; e < n - 1; ++e) {
    for (const int i : {e, e + 1})
      for (const int j : {e, e + 1}) {
        stiffness(i, j) += (i == j ? 1.0 : -1.0) / h;
        if (scene.mass == "consistent") mass(i, j) += h * (i == j ? 2.0 : 1.0) / 6.0;
        if (scene.mass == "lumped" && i == j) mass(i, j) += 0.5 * h;
      }
  }
  if (scene.mass == "fourth_order") {
    for (int i = 1; i < n - 1; ++i) {
      mass(i, i) = 10.0 * h / 12.0;
      mass(i, i - 1) = mass(i, i + 1) = h / 12.0;
    }
    const double row[] = {7.0 * h / 24.0, h / 4.0, -h / 24.0};
    for (int k = 0; k < 3; ++k) mass(0, k) = mass(n - 1, n - 1 - k) = row[k];
  }
  mass *= scene.density;
  mass(0, 0) += scene.ends[0].mass, mass(n - 1, n - 1) += scene.ends[1].mass;
  const Eigen::MatrixXd inverse = testing_support::inverse(mass);
  const auto push = [](const End& end, double depth, double rate) {
    if (end.law.empty() || depth <= 0.0) return 0.0;
    const double spring = end.stiffness * (end.law[0] == 'h' ? depth * std::sqrt(depth) : depth);
    const double force = end.law == "hunt_crossley" ? spring * (1.0 + end.damping * rate) : spring + end.damping * rate;
    return std::max(force, 0.0);
  };
  const auto rates = [&](const std::vector<double>& y, std::vector<double>& out, double t) {
    const Eigen::Map<const Eigen::VectorXd> u(y.data(), n), v(y.data() + n, n);
    Eigen::VectorXd force = -stiffness * (scene.modulus * u + scene.viscosity * v);
    const double left = push(scene.ends[0], -u(0) - scene.ends[0].gap, -v(0));
    const double right = push(scene.ends[1], u(n - 1) - scene.ends[1].gap, v(n - 1));
    force(0) += left + scene.force * (1.0 - std::cos(scene.frequency * t));
    force(n - 1) -= right;
    Eigen::Map<Eigen::VectorXd>(out.data(), n) = v;
    Eigen::Map<Eigen::VectorXd>(out.data() + n, n) = inverse * force;
    out[2 * static_cast<std::size_t>(n)] = left, out[2 * static_cast<std::size_t>(n) + 1] = -right;
  };
  std::vector<double> y(2 * static_cast<std::size_t>(n) + 2, 0.0);
  std::fill_n(y.begin() + n, n, scene.speed);
  using namespace boost::numeric::odeint;
  integrate_adaptive(make_controlled(1e-13, 1e-13, runge_kutta_dopri5<std::vector<double>>()), rates, y, 0.0, scene.end,
                     1e-4);
  return y;
}

TEST(RandomStops, HaveOneMotionByAllMethodsAndByThePlainEquations) {
  std::size_t contacts = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    const Scene scene = draw(seed);
    const std::vector<double> truth = reference(scene);
    const auto n = static_cast<std::size_t>(scene.elements) + 1;
    std::vector<Event> first;
    const bool linear = std::ranges::none_of(scene.ends, [](const End& end) { return end.law.starts_with('h'); });
    for (const char* method : linear_methods) {
      if (!linear && method == std::string_view("exponential")) continue;
      SCOPED_TRACE(fmt::format("seed {} {}\n{}", seed, method, text_of(scene, method)));
      const Case run = parse_scene(text_of(scene, method), "").run;
      std::vector<double> last(2 * n);
      std::vector<Event> events;
      Observers observers;
      observers.energy = observers.account = true;
      observers.event = [&](const Event& event) { events.push_back(event); };
      observers.snapshot = [&](const Snapshot& now) {
        std::ranges::copy(now.u, last.begin());
        std::ranges::copy(now.v, last.begin() + static_cast<std::ptrdiff_t>(n));
      };
      const Statistics done = simulate(resolve(run), observers);
      // The tolerance of the solution is 1e-9 of u and v, both of which are about 1, its promised multiple 100; what
      // an impact magnifies is bounded by the stops' stiffness.
      for (std::size_t i = 0; i < 2 * n; ++i) EXPECT_NEAR(last[i], truth[i], 1e-7);
      EXPECT_NEAR(done.account->left.impulse, truth[2 * n], 1e-7);
      EXPECT_NEAR(done.account->right.impulse, truth[2 * n + 1], 1e-7);
      EXPECT_NEAR(done.energy->balance_error(), 0.0, 1e-7);
      if (first.empty()) first = events, contacts += events.size();
      EXPECT_EQ(events.size(), first.size());
      for (std::size_t k = 0; k < std::min(events.size(), first.size()); ++k)
        EXPECT_NEAR(events[k].time, first[k].time, 1e-6);
    }
  }
  EXPECT_GT(contacts, 200u);
}

}  // namespace
}  // namespace viscobar::laws
