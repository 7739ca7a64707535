#include "campaign/sound.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "campaign/draw.hpp"
#include "case/alarm.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar::campaign {

namespace {

constexpr std::size_t longest = 100'000;

constexpr std::array methods = {"cvode",
                                "ida",
                                "arkode",
                                "odeint",
                                "rigid",
                                "exponential",
                                "characteristics",
                                "fully_discrete",
                                "finite_difference"};

struct Ran {
  Sounded sounded;
  std::optional<Case> run;
  Statistics statistics;
};

void judge(Ran& ran) {
  ran.sounded = {};
  for (const Alarm& alarm : alarms(resolve(*ran.run), resolve(*ran.run).system(), ran.statistics)) {
    ran.sounded.said += alarm.what + "; ";
    ran.sounded.end = std::max(ran.sounded.end, alarm.ruinous ? End::failed : End::warned);
  }
}

Ran run_of(const std::string& scene) {
  Ran ran;
  try {
    ran.run = parse_scene(scene, "sound.toml").run;
    Observers observers;
    std::size_t steps = 0;
    observers.energy = observers.account = true;
    observers.progress = [&](double) { return ++steps > longest ? RunControl::stop : RunControl::go_on; };
    ran.statistics = simulate(resolve(*ran.run), observers);
    if (!ran.statistics.completed) {
      ran.sounded.end = End::too_long;
      return ran;
    }
    judge(ran);
  } catch (const SceneError& error) {
    ran.sounded = {End::refused, error.what()};
  } catch (const std::exception& error) {
    ran.sounded = {End::failed, error.what()};
  }
  return ran;
}

}  // namespace

std::string sound_scene(std::uint64_t seed, std::size_t index) {
  constexpr std::size_t kinds = 10;
  Draw draw(seed, index);
  const bool steel = draw.chance(0.3);
  const double length = draw.decades(0.3, 3.0), density = steel ? 7800.0 : draw.decades(0.3, 3.0);
  const double modulus = steel ? 2.1e11 : draw.decades(0.1, 10.0);
  const double c = std::sqrt(modulus / density), transit = length / c;
  const double viscosity = draw.chance(0.4) ? 0.0 : draw.decades(1e-4, 3.0) * modulus * transit;
  const double strain = draw.decades(1e-5, 1e-1), u = strain * length, v = strain * c;
  const double force = modulus * strain, load = force / length;
  std::string left, right, initial, of_load, mesh, contact;
  double end = transit * draw.decades(2.0, 40.0), epsilon = length / modulus * draw.decades(1e-8, 1.0), soft = 1.0;
  int elements = static_cast<int>(draw.between(4.0, 13.0));
  const auto drawn_contact = [&] {
    mesh = draw.one_of({"", "mass = \"lumped\"\n", "mass = \"consistent\"\n"});
    contact = draw.one_of({"", "restitution = 0.0\n", "restitution = 0.5\n", "restitution = 0.9\n"});
  };
  switch (index % kinds) {
    case 0:  // pushed, and stopped
      of_load = fmt::format("profile = 1.0\nhistory = \"t<{} ? {} : {}\"\n", end / 2, load, -load);
      break;
    case 1:  // whole periods
      of_load = fmt::format("profile = \"1+{}*x\"\nhistory = \"{}*cos({}*t)\"\n", draw.one_of({0.0, 1.0 / length}),
                            load, 2.0 * std::numbers::pi * draw.one_of({1, 2, 5}) / end);
      break;
    case 2:  // springs
      left = fmt::format("[left]\nkind = \"free\"\nstiffness = {}\n", modulus / length * draw.decades(1e-3, 10.0));
      initial = fmt::format("velocity = {}\n", draw.one_of({-v, v}));
      if (draw.chance(0.5)) right = fmt::format("[right]\nkind = \"free\"\nforce = {}\n", force);
      break;
    case 3:  // forces that turn
      if (draw.chance(0.5)) left = fmt::format("[left]\nkind = \"obstacle\"\ngap = {}\n", u * draw.one_of({0.0, 0.3}));
      right = fmt::format("[right]\nkind = \"free\"\nforce = \"{}\"\n",
                          draw.chance(0.5) ? fmt::format("t<{} ? {} : {}", end * draw.between(0.2, 0.8), -force, force)
                                           : fmt::format("{}*sin({}*t)", force, draw.decades(0.3, 10.0) / transit));
      break;
    case 4:  // comes to rest
      left = fmt::format("[left]\nkind = \"obstacle\"\ngap = {}\n", u * draw.between(0.0, 1.0));
      initial = fmt::format("velocity = {}\n", -v * draw.between(0.0, 1.0));
      of_load = fmt::format("density = {}\n", -load);
      contact = "restitution = 0.0\n";
      break;
    case 5: {  // grazes: u comes to -v^2/(2 a)
      const double a = load / density, deepest = v * v / (2.0 * a);
      left = fmt::format("[left]\nkind = \"obstacle\"\ngap = {}\n",
                         deepest * (1.0 + draw.one_of({-1.0, 0.0, 1.0}) * draw.decades(1e-9, 1e-2)));
      initial = fmt::format("velocity = {}\n", -v);
      of_load = fmt::format("density = {}\n", load);
      end = std::min(end, 4.0 * v / a);
      break;
    }
    case 6:  // far
      end = transit * draw.decades(100.0, 1000.0);
      if (draw.chance(0.5))
        initial = fmt::format("velocity = {}\n", v);
      else
        of_load = fmt::format("profile = 1.0\nhistory = \"t<{} ? {} : 0\"\n", transit * draw.between(0.5, 5.0), load);
      break;
    case 7: {  // a force that jumps while its end lies on an obstacle
      const double first = draw.one_of({-1.0, 1.0}) * force;
      left = fmt::format("[left]\nkind = \"obstacle\"\ngap = {}\nforce = \"t<{} ? {} : {}\"\n",
                         draw.chance(0.7) ? 0.0 : 0.3 * u, end * draw.between(0.1, 0.9), first,
                         -first * draw.decades(0.1, 10.0));
      epsilon = length / modulus * draw.decades(1e-9, 0.1);
      drawn_contact();
      break;
    }
    case 8:  // a mass that its bar hardly holds is thrown, bounces, or comes to rest
      elements = 1, soft = 1e-12;
      left = fmt::format("[left]\nkind = \"obstacle\"\ngap = {}\n", u * draw.between(0.0, 1.0));
      right = "[right]\nkind = \"fixed\"\n";
      initial = fmt::format("velocity = \"{}*(x/{}-1)\"\n", v, length);
      if (draw.chance(0.5)) of_load = fmt::format("density = {}\n", -load);
      drawn_contact();
      mesh = "mass = \"lumped\"\n";
      break;
    default: {  // the end or obstacle comes back
      const std::string path =
          fmt::format("{}*(1-cos({}*t))", u, 2.0 * std::numbers::pi * draw.one_of({1, 2, 5}) / end);
      left = draw.chance(0.6) ? fmt::format("[left]\nkind = \"fixed\"\nmotion = \"{}\"\n", path)
                              : fmt::format("[left]\nkind = \"obstacle\"\ngap = \"{}+{}\"\n", 0.2 * u, path);
      right = draw.one_of({"", "[right]\nkind = \"fixed\"\n"});
      initial = fmt::format("velocity = {}\n", draw.one_of({0.0, -0.3 * v}));
    }
  }
  const std::string method = methods[(index / kinds) % methods.size()];
  return fmt::format("[bar]\nlength = {}\ndensity = {}\nmodulus = {}\nviscosity = {}\n{}{}[initial]\n{}", length,
                     density, soft * modulus, method == "characteristics" ? 0.0 : soft * viscosity, left, right,
                     initial) +
         (of_load.empty() ? "" : "[load]\n" + of_load) +
         fmt::format(
             "[time]\nend = {}\n[mesh]\nelements = {}\n{}[contact]\nepsilon = {}\n{}[method]\nname = \"{}\"\nstep = {}\n"
             "relative_tolerance = {}\n[output]\nevery = {}\n",
             end, elements, mesh, epsilon, contact, method, transit / elements / draw.decades(3.0, 30.0),
             draw.decades(1e-9, 1e-4), end / 10);
}

Sounded run_sound(const std::string& scene) { return run_of(scene).sounded; }

Sounded run_spoiled(const std::string& scene, std::uint64_t seed, std::size_t index) {
  Ran ran = run_of(scene);
  if (ran.sounded.end > End::warned || !ran.statistics.energy) return {End::refused, ran.sounded.said};
  Draw draw(seed + 1, index);
  EnergyAccount& energy = *ran.statistics.energy;
  double scale = std::max({energy.initial, energy.final, energy.largest});
  // Waves know no energy on the way, but the largest velocity.
  const Bar& bar = ran.run->scene.bar;
  if (const auto& waves = ran.statistics.representation)
    scale = std::max(scale, bar.density * bar.length * waves->velocity * waves->velocity);
  const double factor = draw.one_of({-1.0, 0.0, 0.5, 0.9, 1.1, 2.0, 100.0});
  double* parts[] = {&energy.initial, &energy.final, &energy.dissipated, &energy.work};
  std::rotate(parts, parts + static_cast<std::size_t>(draw.between(0.0, 4.0)) % 4, parts + 4);
  for (double* part : parts) {
    if (!(std::abs((factor - 1.0) * *part) > 0.02 * std::max(scale, std::abs(factor * *part)))) continue;
    *part *= factor;
    judge(ran);
    return ran.sounded;
  }
  return {End::refused, "no part is large enough"};
}

}  // namespace viscobar::campaign
