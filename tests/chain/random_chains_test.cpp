// Random elastic chains by characteristics: against a mesh and its half, and against their mirror image.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "viscobar/case/recording.hpp"
#include "viscobar/input/scene_file.hpp"

namespace viscobar {
namespace {

struct RandomMember {
  double mass = 0.0, length = 0.0, density = 1.0, modulus = 1.0, section = 1.0, velocity = 0.0, pulse = 0.0;
};
struct RandomEnd {
  const char* kind = "free";
  double gap = 0.0, stiffness = 0.0, dashpot = 0.0, mass = 0.0, force = 0.0;
  bool above = false;
};

// Bars, rigid bodies between and beside them, joints and ends of all kinds. Two rigid bodies are neighbours at the left
// end alone, where nothing meets the first on its other side.
class RandomElasticChain {
 public:
  explicit RandomElasticChain(unsigned seed, bool stops = false) : engine_(seed) {
    const int count = pick(2, 5);
    for (int k = 0; k < count; ++k) {
      RandomMember member{.velocity = number(-1.0, 1.0)};
      const bool after_rigid = members_.size() > 1 && members_.back().mass > 0.0;
      if (pick(0, 3) == 0 && !after_rigid && !(k + 1 == count && bars_ == 0)) {
        member.mass = number(0.2, 2.0);
      } else {
        ++bars_;
        member.length = number(0.4, 1.5), member.density = number(0.5, 3.0), member.modulus = number(0.5, 3.0);
        member.section = pick(0, 2) == 0 ? number(0.5, 2.0) : 1.0;
        member.pulse = number(-1.0, 1.0);
      }
      members_.push_back(member);
    }
    for (int k = 0; k + 1 < count; ++k) {
      const int kind = pick(0, 3);
      const std::string data = kind == 0 ? "kind = \"bonded\"\n"
                               : kind == 1
                                   ? fmt::format("kind = \"spring\"\nstiffness = {}\ndamping = {}\n", number(1.0, 30.0),
                                                 pick(0, 1) * number(0.0, 1.0))
                                   : fmt::format("kind = \"contact\"\ngap = {}\n", pick(0, 1) * number(0.0, 0.2));
      if (kind == 0)
        members_[static_cast<std::size_t>(k) + 1].velocity = members_[static_cast<std::size_t>(k)].velocity;
      const std::string law =
          fmt::format("law = \"spring_damper\"\nstiffness = {}\ndamping = {}\n", number(1.0, 30.0), number(0.0, 1.0));
      joints_.push_back("[[joint]]\n" + data + (stops && kind > 1 && pick(0, 1) == 0 ? law : ""));
    }
    for (RandomEnd* end : {&left_, &right_}) {
      const bool bar = (end == &left_ ? members_.front() : members_.back()).mass == 0.0;
      const int kind = bar ? pick(0, 2) : 0;
      end->kind = kind == 0 ? "free" : kind == 1 ? "fixed" : "obstacle";
      if (kind == 2) end->gap = number(0.0, 0.3), end->above = pick(0, 1) == 1;
      if (kind == 1) continue;
      if (pick(0, 2) == 0) end->stiffness = number(1.0, 20.0);
      if (pick(0, 2) == 0) end->dashpot = number(0.0, 2.0);
      if (kind == 0 && pick(0, 2) == 0) end->mass = number(0.2, 2.0);
      if (pick(0, 2) == 0) end->force = number(-1.0, 1.0);
    }
  }

  // Mirrored, x and u have their signs turned.
  std::string text(int elements, bool mirrored = false) const {
    std::string text;
    const double sign = mirrored ? -1.0 : 1.0;
    for (std::size_t k = 0; k < members_.size(); ++k) {
      const RandomMember& m = members_[mirrored ? members_.size() - 1 - k : k];
      if (m.mass > 0.0)
        text += fmt::format("[[bar]]\nmass = {}\nvelocity = {}\n", m.mass, sign * m.velocity);
      else
        text += fmt::format(
            "[[bar]]\nlength = {}\ndensity = {}\nmodulus = {}\nsection = {}\nelements = {}\nvelocity = "
            "\"{}+{}*sin(3.141592653589793*x/{})^4\"\n",
            m.length, m.density, m.modulus, m.section, elements, sign * m.velocity, sign * m.pulse, m.length);
    }
    for (std::size_t k = 0; k < joints_.size(); ++k) text += joints_[mirrored ? joints_.size() - 1 - k : k];
    const auto end = [&](const char* table, const RandomEnd& e) {
      text += fmt::format("[{}]\nkind = \"{}\"\n", table, e.kind);
      if (e.kind == std::string("obstacle"))
        text += fmt::format("gap = {}\nside = \"{}\"\n", e.gap, e.above != mirrored ? "above" : "below");
      if (e.stiffness > 0.0) text += fmt::format("stiffness = {}\n", e.stiffness);
      if (e.dashpot > 0.0) text += fmt::format("dashpot = {}\n", e.dashpot);
      if (e.mass > 0.0) text += fmt::format("mass = {}\n", e.mass);
      if (e.force != 0.0) text += fmt::format("force = \"{}*sin(2*t)^2\"\n", sign * e.force);
    };
    end("left", mirrored ? right_ : left_);
    end("right", mirrored ? left_ : right_);
    return text +
           "[initial]\nvelocity = 0.0\ndisplacement = 0.0\n[time]\nend = 3.0\n[output]\nevery = 0.1\n[method]\n"
           "relative_tolerance = 1e-7\n";
  }

 private:
  int pick(int from, int to) { return std::uniform_int_distribution<int>(from, to)(engine_); }
  double number(double from, double to) { return std::uniform_real_distribution<double>(from, to)(engine_); }

  std::mt19937 engine_;
  int bars_ = 0;
  std::vector<RandomMember> members_;
  std::vector<std::string> joints_;
  RandomEnd left_, right_;
};

Recording run(const std::string& text, const char* method) {
  return record(parse_scene(text, "", std::vector<std::string>{fmt::format("method.name={}", method)}).run);
}

// Largest difference of displacements, at the nodes of the coarser mesh: each bar has its own number of elements, a
// multiple of `few`.
double difference(const Recording& a, const Recording& b) {
  const Mesh &coarse = a.mesh.elements <= b.mesh.elements ? a.mesh : b.mesh,
             &fine = a.mesh.elements <= b.mesh.elements ? b.mesh : a.mesh;
  std::vector<std::pair<std::size_t, std::size_t>> nodes;
  std::size_t i = 0, j = 0;
  for (std::size_t m = 0; m < coarse.members->size(); ++m) {
    const std::size_t few = (*coarse.members)[m].elements, many = (*fine.members)[m].elements;
    for (std::size_t k = 0; k <= few; ++k) nodes.emplace_back(i + k, j + (few > 0 ? k * (many / few) : 0));
    i += few, j += many;
    if (m + 1 < coarse.members->size() && coarse.element(i) == 0.0) ++i, ++j;
  }
  const Recording &on_coarse = &coarse == &a.mesh ? a : b, &on_fine = &coarse == &a.mesh ? b : a;
  double most = 0.0;
  for (std::size_t k = 0; k < a.times.size(); ++k)
    for (const auto& [at, other] : nodes)
      most = std::max(most, std::abs(on_coarse.displacement(k)[at] - on_fine.displacement(k)[other]));
  return most;
}

// A mesh of order p errs by d / (2^p - 1), d its difference from its half; elastic bars have p = 1/2 or more.
TEST(RandomElasticChains, AreWhatMeshesComeTo) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    const RandomElasticChain chain(seed);
    try {
      const Recording exact = run(chain.text(20), "characteristics");
      const Recording coarse = run(chain.text(20), "rigid"), fine = run(chain.text(40), "rigid");
      const double halved = difference(coarse, fine);
      EXPECT_LT(difference(exact, fine), 2.5 * halved + 1e-6) << seed << '\n' << chain.text(20);
      const EnergyAccount& energy = *exact.statistics.energy;
      EXPECT_NEAR(energy.balance_error(), 0.0, 1e-12 * std::max({1.0, energy.initial, std::abs(energy.work)})) << seed;
    } catch (const std::exception& error) {
      ADD_FAILURE() << seed << ' ' << error.what() << '\n' << chain.text(20);
    }
  }
}

// With checkpoints a run begins anew at each.
std::vector<double> in_parts(const std::string& text) {
  const Setup setup = resolve(parse_scene(text, "").run);
  std::vector<double> u;
  Observers observers;
  observers.snapshot = [&](const Snapshot& now) { u.insert(u.end(), now.u.begin(), now.u.end()); };
  observers.checkpoints = {.every = 0.37, .asked = {}, .take = [](const Checkpoint&) { return RunControl::go_on; }};
  simulate(setup, setup.system(), observers);
  return u;
}

// Roundings of breaks and values; contacts magnify them a little.
TEST(RandomElasticChains, AreTheirMirrorImages) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    const RandomElasticChain chain(seed, true);
    try {
      const Recording one = run(chain.text(8), "characteristics"), other = run(chain.text(8, true), "characteristics");
      const std::size_t nodes = one.mesh.nodes();
      ASSERT_EQ(nodes, other.mesh.nodes());
      double most = 0.0;
      for (std::size_t k = 0; k < one.times.size(); ++k)
        for (std::size_t j = 0; j < nodes; ++j)
          most = std::max(most, std::abs(one.displacement(k)[j] + other.displacement(k)[nodes - 1 - j]));
      EXPECT_LT(most, 1e-11) << seed << '\n' << chain.text(8);
      const EnergyAccount& energy = *one.statistics.energy;
      EXPECT_NEAR(energy.balance_error(), 0.0, 1e-12 * std::max({1.0, energy.initial, std::abs(energy.work)})) << seed;
      if (seed < 25) {
        EXPECT_EQ(in_parts(chain.text(8) + "name = \"characteristics\"\n"), one.u) << seed;
      }
    } catch (const std::exception& error) {
      ADD_FAILURE() << seed << ' ' << error.what();
    }
  }
}

}  // namespace
}  // namespace viscobar
