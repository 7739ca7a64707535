#include "campaign/estimates.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "campaign/draw.hpp"
#include "studies/accuracy/sample.hpp"

namespace viscobar::campaign {

namespace {

accuracy::Sample sample(const Case& run) {
  return accuracy::sample_of(run, run.output_times(), {.stop = {}, .steps = 400'000});
}

// With the law of contact of the run, where that is not the rigid one that all laws at an end without mass tend to.
Case truth_of(const Case& run, std::size_t finer, double looser = 1.0) {
  Case truth = run;
  truth.automatic = false;
  truth.elements = run.elements * finer;
  truth.grading = 1.0;
  truth.restitution.reset();
  if (run.scene.left_input.mass) truth.restitution = run.restitution.value_or(is_penalised(run.method) ? 1.0 : 0.0);
  truth.mass.reset();
  truth.epsilon.reset();
  truth.step.reset();
  truth.tolerance = Tolerance{1e-10 * looser};
  truth.method = automatic_method(truth).method;
  if (!run.scene.span) {
    if (truth.method != MethodName::characteristics) truth.method = MethodName::rigid;
    return truth;
  }
  truth.method = MethodName::arkode;
  truth.mass = Mass::lumped;
  truth.restitution = 0.0;
  truth.tolerance = Tolerance{1e-9 * looser};
  truth.epsilon = 1e-13 * looser * natural_epsilon(run.scene);
  return truth;
}

const std::string six_methods[] = {"cvode", "rigid", "ida", "fully_discrete", "arkode", "automatic"};

std::string settings(Draw& draw, const std::string& method, double end, const char* third_mass) {
  std::string text = fmt::format("[time]\nend = {:.3g}\n[output]\nevery = {:.4g}\n[method]\nname = \"{}\"\n", end,
                                 end / 100.0, method);
  text += fmt::format("[mesh]\nelements = {}\n", static_cast<int>(draw.between(15.0, 50.0)));
  const bool penalised = method == "cvode" || method == "ida" || method == "arkode";
  const char* mass = draw.one_of({"consistent", "lumped", third_mass});
  text += penalised ? fmt::format("mass = \"{}\"\n[contact]\nepsilon = {:.2g}\n", mass, draw.decades(1e-6, 1e-3))
                    : "[contact]\n";
  if ((penalised || method == "fully_discrete") && draw.chance(0.6))
    text += fmt::format("restitution = {}\n", draw.one_of({0.0, 0.5, 0.8, 1.0}));
  return text;
}

}  // namespace

std::string thrown_scene(std::uint64_t seed, std::size_t index) {
  Draw draw(seed, index);
  const bool span = index % 12 == 11;
  const double viscosity = !span && draw.chance(0.15) ? 0.0 : draw.decades(span ? 0.03 : 0.002, 2.0);
  std::string text = fmt::format("[bar]\nlength = 1.0\nviscosity = {:.4g}\n", viscosity);
  const int ends = static_cast<int>(draw.between(0.0, 6.0));
  bool obstacles = span;
  const auto end = [&](const char* which, bool obstacle, const char* otherwise) {
    if (obstacle) {
      text += fmt::format("[{}]\nkind = \"obstacle\"\ngap = {:.3g}\n", which,
                          draw.chance(0.1) ? 0.0 : draw.between(0.02, 0.4));
      obstacles = true;
    } else {
      text += fmt::format("[{}]\nkind = \"{}\"\n", which, otherwise);
    }
  };
  const char* otherwise = draw.chance(0.3) && viscosity > 0.0 ? "fixed" : "free";
  if (!span) {
    end("left", ends != 5, "free");
    end("right", ends == 0 || ends == 1 || ends == 5, otherwise);
  } else {
    text += fmt::format("[span]\ngap = {:.3g}\n", draw.between(0.1, 0.4));
  }
  const bool held = text.find("fixed") != std::string::npos;
  const double bend = draw.chance(0.5) ? draw.between(0.0, 0.5) : 0.0, speed = draw.between(0.2, 1.5);
  text += fmt::format("[initial]\ndisplacement = \"{:.3g}*{}\"\n", bend,
                      draw.one_of({"x*(1-x)", "(1-cos(2*pi*x))", "x^2*(1-x)^2"}));
  text += fmt::format("velocity = \"{:.3g}*({})*{}\"\n", -speed,
                      draw.one_of({"1", "1+0.3*x", "1-0.5*cos(pi*x)", "0.5+x^2", "1"}), held ? "(1-x)" : "1");
  if (draw.chance(0.4))
    text += fmt::format("[load]\nprofile = \"{}\"\nhistory = \"{:.3g}*{}\"\n", draw.one_of({"1", "1+x", "cos(pi*x)"}),
                        -draw.between(0.2, 3.0), draw.one_of({"1", "sin(3*t)", "cos(2*t)"}));
  const double time = draw.between(0.8, 6.0);
  const int elements = static_cast<int>(draw.between(10.0, span ? 24.0 : 60.0));
  const std::string methods[] = {"automatic", "cvode", "arkode",    "ida",    "rigid",       "fully_discrete",
                                 "automatic", "cvode", "automatic", "odeint", "exponential", "finite_difference"};
  std::string method = span ? draw.one_of({"automatic", "arkode", "cvode"}) : methods[(index / 2) % 12];
  const bool scheme = method == "fully_discrete" || method == "finite_difference";
  const bool penalised =
      method == "cvode" || method == "arkode" || method == "ida" || method == "odeint" || method == "exponential";
  text += fmt::format("[time]\nend = {:.3g}\n[output]\nevery = {:.4g}\n[mesh]\nelements = {}\n{}", time,
                      time / draw.decades(7.0, 700.0), elements, span && penalised ? "mass = \"lumped\"\n" : "");
  std::string contact;
  if (penalised && draw.chance(0.7)) contact += fmt::format("epsilon = {:.2g}\n", draw.decades(1e-7, 1e-2));
  if (span)
    contact += penalised ? "restitution = 0.0\n" : "";
  else if ((penalised || scheme) && draw.chance(0.4))
    contact += fmt::format("restitution = {}\n", draw.one_of({0.0, 0.5, 0.9, 1.0}));
  if (!contact.empty()) text += "[contact]\n" + contact;

  std::string options;
  if (!scheme && draw.chance(0.3)) options += fmt::format("relative_tolerance = {:.1g}\n", draw.decades(1e-8, 1e-3));
  if (scheme && draw.chance(0.7)) options += fmt::format("step = {:.2g}\n", draw.decades(0.05, 1.0) / elements);
  return text + "[method]\nname = \"" + method + "\"\n" + options;
}

std::string chattering_scene(std::uint64_t seed, std::size_t index) {
  Draw draw(seed, index);
  const double viscosity = draw.decades(0.001, 0.02), left = draw.between(0.02, 0.2), right = draw.between(0.02, 0.2);
  const double bend = draw.between(0.5, 1.0), speed = draw.between(0.5, 1.0), end = draw.between(2.0, 6.0);
  const std::string text = fmt::format(
      "[bar]\nlength = 1.0\nviscosity = {:.3g}\n[left]\nkind = \"obstacle\"\ngap = {:.3g}\n[right]\nkind = "
      "\"obstacle\"\ngap = {:.3g}\n[initial]\ndisplacement = \"{:.3g}*x*(1-x)\"\nvelocity = \"{:.3g}*x*(1-x)\"\n",
      viscosity, left, draw.chance(0.5) ? left : right, bend, -speed);
  return text + settings(draw, six_methods[index % 6], end, "redistributed");
}

std::string bouncing_scene(std::uint64_t seed, std::size_t index) {
  Draw draw(seed, index);
  const std::string& method = six_methods[index % 6];
  const bool masses = method != "fully_discrete";
  const double viscosity = draw.decades(0.01, 1.0), gap = draw.between(0.02, 0.3), speed = draw.between(0.0, 1.0),
               load = draw.between(0.3, 3.0), rate = draw.between(1.0, 5.0), end = draw.between(3.0, 10.0),
               left = draw.decades(0.01, 2.0), right = draw.decades(0.01, 2.0);
  std::string text = fmt::format("[bar]\nlength = 1.0\nviscosity = {:.3g}\n[left]\nkind = \"obstacle\"\ngap = {:.3g}\n",
                                 viscosity, gap);
  if (masses && draw.chance(0.6)) text += fmt::format("mass = {:.3g}\n", left);
  text += "[right]\nkind = \"free\"\n";
  if (masses && draw.chance(0.5)) text += fmt::format("mass = {:.3g}\n", right);
  text += draw.chance(0.5) ? fmt::format("force = \"{:.3g}*(sin({:.3g}*t)-0.5)\"\n", load, rate)
                           : fmt::format("[load]\ndensity = {:.3g}\n", -load);
  text += fmt::format("[initial]\nvelocity = {:.3g}\n", -speed);
  return text + settings(draw, method, end, "fourth_order");
}

std::optional<TrueError> true_error(const Case& run) try {
  Case own = run;
  own.output_every = run.end / 1000.0;
  const accuracy::Sample found = sample(own);
  const auto motion = [&](std::size_t finer, double looser) {
    Case truth = truth_of(own, finer, looser);
    if (!sound(truth)) throw TooLong();
    return sample(truth);
  };
  const std::size_t finer = run.scene.span ? 4 : run.elements < 30 ? 8 : 4;
  const accuracy::Sample truth = motion(2 * finer, 1.0);
  TrueError result;
  result.error = accuracy::difference(found, truth, Goal::displacement);
  if (!truth.statistics.representation)
    result.own = accuracy::difference(motion(finer, 100.0), truth, Goal::displacement);
  return result;
} catch (const TooLong&) {
  return std::nullopt;
} catch (const IntegrationError&) {
  return std::nullopt;
}

}  // namespace viscobar::campaign
