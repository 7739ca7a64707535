#include <fmt/format.h>

#include <cmath>

#include "hard/catalogue.hpp"

namespace viscobar::hard {

namespace {

// Those that a uniform load accelerates as one point.
const std::vector<Mass> full_masses = {Mass::consistent, Mass::lumped};
const std::vector<Mass> two_masses = {Mass::consistent, Mass::redistributed};

std::string history(const char* formula) { return std::string("load.history=") + formula; }

}  // namespace

std::vector<HardScene> load_scenes() {
  const auto jump = [](double, double t) {
    return t < 0.3 ? t * t / 2 : 0.045 + 0.3 * (t - 0.3) - std::pow(t - 0.3, 2) / 2;
  };
  const auto ripple = [](double, double t) { return t / 1000 - std::sin(1000 * t) / 1e6; };
  // It lasts a 50th of the run: a blow of less than a 64th may be missed (docs/methods.md).
  const auto blow = [](double, double t) {
    return t < 0.5 ? 0.0 : t < 0.52 ? 25 * std::pow(t - 0.5, 2) : 0.01 + t - 0.52;
  };
  const auto root = [](double, double t) {
    const double s = t - 0.5;  // u'' = |s|^(-1/2)
    return 4.0 / 3 * std::pow(std::abs(s), 1.5) + 2 * std::sqrt(0.5) * t - 4.0 / 3 * std::pow(0.5, 1.5);
  };
  std::vector<HardScene> scenes;
  scenes.push_back({"load jumps", "flight", {}, full_masses, {exact(jump, 1.0)}});
  scenes.push_back({"load jumps, in and out of contact", "load", {}, two_masses, {agreement()}});
  for (const char* viscosity : {"0.1", "30", "1e3"})
    for (const char* epsilon : {"1e-8", "1e-12", "1e-14"})
      scenes.push_back({fmt::format("load turns and pulls, viscosity {}, epsilon {}", viscosity, epsilon),
                        "pull",
                        {fmt::format("bar.viscosity={}", viscosity), fmt::format("contact.epsilon={}", epsilon)},
                        {Mass::redistributed},
                        {agreement()}});
  scenes.push_back({"load jumps at a contact change",
                    "load",
                    {history("t < 0.4472135954999579 ? -1 : 3")},  // u = -t^2/2 is there at -0.1
                    full_masses,
                    {agreement()}});
  scenes.push_back({"load that is a short blow",
                    "flight",
                    {history("t > 0.5 && t < 0.52 ? 50 : 0"), "method.step=0.00006103515625"},
                    full_masses,
                    {exact(blow, 50.0)}});
  scenes.push_back({"load oscillates fast",
                    "flight",
                    {history("sin(1000*t)"), "method.step=0.00006103515625"},
                    full_masses,
                    {exact(ripple, 1.0)}});
  scenes.push_back(
      {"load oscillates fast, in contact", "load", {history("30*sin(300*t)-1")}, two_masses, {agreement()}});
  scenes.push_back({"load grows until it overflows", "load", {history("exp(1000*t)")}, two_masses, {}, {{"t = 0.7"}}});
  scenes.push_back(
      {"load becomes infinite", "load", {history("t < 0.5 ? -1 : exp(1e4*t)")}, two_masses, {}, {{"infinite"}}});
  scenes.push_back({"load becomes NaN", "load", {history("-sqrt(0.5-t)")}, two_masses, {}, {{"not a number"}}});
  scenes.push_back(
      {"load is NaN on half of the bar", "fall", {"load.density=sqrt(1 - t*x)"}, two_masses, {}, {{"not a number"}}});
  scenes.push_back({"load with a pole",
                    "flight",
                    {history("1/(t-0.5)^2")},
                    full_masses,
                    {},
                    {{"stopped"}, {"infinite", {MethodName::fully_discrete, MethodName::finite_difference}}}});
  scenes.push_back({"load with a pole that can be integrated",
                    "flight",
                    {history("abs(t-0.5)^(-0.5)")},
                    full_masses,
                    {exact(root, 1000.0)},
                    {{"t = 0.5", {}, false}, {"at that pace", {MethodName::exponential}, false}}});
  return scenes;
}

}  // namespace viscobar::hard
