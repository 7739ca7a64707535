#pragma once

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cstdlib>
#include <sstream>

#include "properties/random_scene.hpp"

namespace viscobar::properties {

/// k/16 for k from `low` to `high`: exact in binary and short in decimal. Shrinks towards `low`.
inline rc::Gen<double> sixteenths(int low, int high) {
  return rc::gen::map(rc::gen::inRange(low, high + 1), [](int k) { return k / 16.0; });
}

/// 0, or -k/16 up to `down`, or k/16 up to `up`; shrinks towards 0.
inline rc::Gen<double> signed_sixteenths(int down, int up) {
  return rc::gen::map(rc::gen::inRange(0, down + up + 1), [down](int k) { return (k <= down ? -k : k - down) / 16.0; });
}

/// One of the words; shrinks towards the first.
inline rc::Gen<std::string> word(std::vector<std::string> words) {
  const auto count = static_cast<int>(words.size());
  return rc::gen::map(rc::gen::inRange(0, count), [words = std::move(words)](int i) { return words[i]; });
}

/// 2^k; shrinks towards 2^from.
inline rc::Gen<double> power_of_two(int from, int to) {
  if (from <= to) return rc::gen::map(rc::gen::inRange(from, to + 1), [](int k) { return std::ldexp(1.0, k); });
  return rc::gen::map(rc::gen::inRange(-from, -to + 1), [](int k) { return std::ldexp(1.0, -k); });
}

/// 1, 2, 1/2, 4, ... 8, 1/8; shrinks towards 1.
inline rc::Gen<double> scale() {
  return rc::gen::map(rc::gen::inRange(0, 7), [](int k) { return std::ldexp(1.0, k % 2 == 1 ? (k + 1) / 2 : -k / 2); });
}

/// The methods that take a scene and would not need more than 1e5 steps of an explicit formula for it.
inline std::vector<std::string> fitting_methods(RandomScene scene, const std::vector<MethodName>& among) {
  std::vector<std::string> fitting;
  for (const MethodName method : among) {
    scene.method = name(method);
    try {
      const Case run = scene.read().run;
      if (method == MethodName::odeint &&
          plan(resolve(run).system(), run.end, std::get<Odeint>(resolve(run).method)).least_steps > 1e5)
        continue;
      fitting.push_back(scene.method);
    } catch (const SceneError&) {
    }
  }
  return fitting;
}

/// Demands of a property on its scenes.
struct Asked {
  bool obstacles = true, loads = true, restitution = true;
  bool in_motion = false;  ///< neither displacement nor velocity is zero everywhere at the start
  std::vector<MethodName> methods{std::begin(all_methods), std::end(all_methods)};
};

/// Sound scenes of up to 24 elements: any ends, mass, viscosity, load, penalty and gap, any method that takes them. The
/// initial displacement is nowhere negative, so no obstacle is penetrated; at gap 0 it may touch one.
inline rc::Gen<RandomScene> scenes(Asked asked = {}) {
  return rc::gen::exec([asked] {
    RandomScene scene;
    scene.elements = *rc::gen::inRange(3, 25);
    scene.outputs = *rc::gen::map(rc::gen::inRange(0, 5), [](int k) { return 1 << k; });
    scene.end = *sixteenths(4, 64);
    scene.steps_per_output = *rc::gen::map(rc::gen::inRange(4, 8), [](int k) { return 1 << k; });
    scene.length = *sixteenths(16, 40);
    scene.density = *sixteenths(16, 32);
    scene.modulus = *sixteenths(16, 32);
    scene.viscosity = *rc::gen::map(rc::gen::inRange(0, 12), [](int k) { return k == 0 ? 0.0 : std::ldexp(2.0, -k); });
    const auto end = [&] {
      End one{*word(asked.obstacles ? std::vector<std::string>{"free", "obstacle", "obstacle", "fixed"}
                                    : std::vector<std::string>{"free", "fixed"})};
      if (one.kind == "obstacle") one.gap = *sixteenths(0, 8);
      return one;
    };
    scene.left = end();
    scene.right = end();
    if (asked.obstacles && *rc::gen::inRange(0, 8) == 7) scene.span_gap = *sixteenths(0, 8);
    const double wave = *sixteenths(0, 8);
    // Above the rounding of cos(pi), which would penetrate an obstacle at gap 0.
    scene.displacement = {*sixteenths(0, 4) + 1.0625 * wave, wave, *rc::gen::inRange(0, 5)};
    scene.velocity = {*signed_sixteenths(32, 16), *sixteenths(0, 16), *rc::gen::inRange(0, 5)};
    for (Shape* shape : {&scene.displacement, &scene.velocity}) {
      const double constant = shape->base + (shape->waves == 0 ? shape->amplitude : 0.0);
      if (asked.in_motion && constant == 0.0) shape->base += 0.0625;
    }
    if (asked.loads && *rc::gen::inRange(0, 2) == 1) {
      scene.load = Shape{*signed_sixteenths(16, 16), *sixteenths(0, 16), *rc::gen::inRange(0, 4)};
      scene.frequency = *sixteenths(0, 64);
    }
    scene.epsilon = *power_of_two(-2, -20);
    if (asked.restitution && *rc::gen::inRange(0, 3) == 2) scene.restitution = *sixteenths(0, 16);
    scene.mass = *word({"consistent", "lumped", "paper", "redistributed", "fourth_order"});
    std::vector<std::string> methods = fitting_methods(scene, asked.methods);
    if (methods.empty()) {  // a span obstacle on the redistributed mass
      scene.mass = "consistent";
      methods = fitting_methods(scene, asked.methods);
    }
    scene.method = *word(methods);
    return scene;
  });
}

/// Tries a property on 500 scenes from a fixed seed, or as RC_PARAMS in the environment says, such as
/// RC_PARAMS="max_success=1000": then the seed is another one each time, and a failure prints it.
template <class Property>
void expect_always(Property&& property) {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  rc::detail::TestMetadata metadata;
  metadata.id = std::string(info->test_suite_name()) + "/" + info->name();
  metadata.description = info->name();
  rc::detail::TestParams parameters = rc::detail::configuration().testParams;
  if (!std::getenv("RC_PARAMS")) {
    parameters.seed = 1;
    parameters.maxSuccess = 500;
  }
  const auto result = rc::detail::checkTestable(std::forward<Property>(property), metadata, parameters);
  std::ostringstream words;
  rc::detail::printResultMessage(result, words);
  if (result.template is<rc::detail::SuccessResult>()) {
    std::cout << words.str() << "\n";
    return;
  }
  FAIL() << words.str() << "\nSeed " << parameters.seed << "; docs/internals/testing.md says how to run it again.";
}

}  // namespace viscobar::properties
