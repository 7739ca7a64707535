#include <fmt/format.h>

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "case/massless.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar {

namespace {

/// The words of those that help, as a list.
std::string choice(std::initializer_list<std::pair<bool, std::string>> all) {
  std::vector<std::string> words;
  for (const auto& [helps, word] : all)
    if (helps) words.push_back(word);
  std::string text;
  for (std::size_t k = 0; k < words.size(); ++k)
    text += fmt::format("{}{}", k == 0 ? "" : k + 1 == words.size() ? " or " : ", ", words[k]);
  return text;
}

// The key of the stiffness of the first stop with a law of its own; empty where there is none.
std::string stop_key(const Scene& scene) {
  for (const auto& [end, input] : {std::pair{"left", &scene.left_input}, {"right", &scene.right_input}})
    if (input->stop) return input->stop->key(end, "stiffness");
  for (std::size_t k = 0; k + 1 < scene.chain.size(); ++k)
    if (const auto& stop = scene.chain[k].joint.stop) return stop->key(fmt::format("joint.{}", k + 1), "stiffness");
  return {};
}

}  // namespace

std::string remedy(const Case& run, Failure why) {
  const bool penalty = has_penalty(run.scene);
  const std::string stop = stop_key(run.scene);
  const std::pair<bool, std::string> larger{penalty, "a larger contact.epsilon"},
      softer{!stop.empty(), "a smaller " + stop}, massless{may_be_massless(run), "mesh.mass = \"redistributed\""},
      gentler{penalty || !stop.empty(), "take " + choice({larger, softer})};
  switch (why) {
    case Failure::accuracy:
      return choice({{true, "loosen method.relative_tolerance and method.absolute_tolerance"},
                     gentler,
                     {true, "check the load for jumps"}});
    case Failure::digits: return "loosen method.relative_tolerance or raise method.absolute_tolerance";
    case Failure::stiffness:
      return fmt::format(
          "take {}; check initial data and load for values that are far too large",
          choice({larger, softer, massless, {run.method != MethodName::arkode, "method.name = \"arkode\""}}));
    case Failure::inertia:
      return fmt::format("{}, a smaller bar.viscosity or bar.modulus, or a larger bar.density",
                         is_scheme(run.method) ? "take a shorter method.step" : "choose an earlier time.end");
    case Failure::overflow:
      return fmt::format(
          "the numbers of the scene are too large, too small, or too far apart: bring initial data, load, bar.modulus, "
          "bar.density{}{} nearer to one by a choice of units",
          penalty ? ", contact.epsilon" : "", stop.empty() ? "" : ", " + stop);
    case Failure::load:
      return "change the formula that the message names: until time.end a load or force must be finite and smooth "
             "between jumps, a motion must not jump, and a gap only away from the bar";
    case Failure::short_end: return "choose a later time.end, or a longer output.every";
    case Failure::length:
      return choice({{true, "choose an earlier time.end"}, {true, "loosen method.relative_tolerance"}, gentler});
    case Failure::chatter:
      return fmt::format(
          "contact nodes bounce without end: take {}",
          choice({massless, {penalty && run.restitution != 0.0, "contact.restitution = 0"}, larger, softer}));
    case Failure::brief_contact: return fmt::format("take {}", choice({larger, softer, massless}));
    case Failure::toggling: return choice({gentler, {true, "measure displacements from the obstacle"}});
    case Failure::detail:
      return "choose an earlier time.end, a positive bar.viscosity with another method.name, or rigid";
    case Failure::memory: return "take fewer mesh.elements";
    case Failure::defect: break;
  }
  return "nothing in the scene is known to cause it: please report it as an error of viscobar, with the scene; another "
         "method.name may do";
}

}  // namespace viscobar
