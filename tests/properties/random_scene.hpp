#pragma once

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "viscobar/input/scene_file.hpp"

namespace viscobar::properties {

/// base + amplitude cos(waves pi s), s the place on the bar from 0 to 1.
struct Shape {
  double base = 0.0, amplitude = 0.0;
  int waves = 0;

  std::string formula(std::string_view s) const {
    return fmt::format("{}+({})*cos({}*pi*{})", base, amplitude, waves, s);
  }
};

struct End {
  std::string kind = "free";
  double gap = 0.0;  ///< of an obstacle
};

/// A scene as numbers that properties can transform, and that RapidCheck can shrink. It is run by way of its text, so
/// that the text of a failing one, which RapidCheck prints, is what failed.
struct RandomScene {
  double length = 1.0, density = 1.0, modulus = 1.0, viscosity = 0.0;
  End left, right;
  std::optional<double> span_gap;
  Shape displacement, velocity;
  std::optional<Shape> load;  ///< profile
  double frequency = 0.0;     ///< of the load: sin(frequency t); 0: steady
  double delay = 0.0;         ///< of the load: sin(frequency (t - delay))
  double end = 1.0;
  int outputs = 8;            ///< intervals
  int steps_per_output = 16;  ///< of methods with a fixed step
  int elements = 4;
  std::string mass = "consistent", method = "cvode";
  double epsilon = 0.125;
  std::optional<double> restitution;
  std::string impact = "paoli_schatzman";  ///< of a scheme
  double relative = 1e-8, absolute = 1e-11;
  bool mirrored = false;  ///< s runs from the right

  double every() const { return end / outputs; }
  double step() const { return every() / steps_per_output; }
  bool obstacle() const { return left.kind == "obstacle" || right.kind == "obstacle" || span_gap; }

  /// The scene as a file.
  std::string toml() const {
    const std::string s = mirrored ? fmt::format("(1-x/{})", length) : fmt::format("(x/{})", length);
    const auto end_table = [](const char* side, const End& which) {
      return fmt::format("[{}]\nkind = \"{}\"\n{}", side, which.kind,
                         which.kind == "obstacle" ? fmt::format("gap = {}\n", number(which.gap)) : "");
    };
    std::string text = fmt::format("[bar]\nlength = {}\ndensity = {}\nmodulus = {}\nviscosity = {}\n", number(length),
                                   number(density), number(modulus), number(viscosity));
    text += end_table("left", left) + end_table("right", right);
    if (span_gap) text += fmt::format("[span]\ngap = {}\n", number(*span_gap));
    text += fmt::format("[initial]\ndisplacement = \"{}\"\nvelocity = \"{}\"\n", displacement.formula(s),
                        velocity.formula(s));
    if (load)
      text += fmt::format("[load]\nprofile = \"{}\"\nhistory = \"{}\"\n", load->formula(s),
                          frequency == 0.0 ? "1" : fmt::format("sin({}*(t-({})))", frequency, delay));
    text += fmt::format("[time]\nend = {}\n[mesh]\nelements = {}\nmass = \"{}\"\n", number(end), elements, mass);
    text += fmt::format("[contact]\nepsilon = {}\n", number(epsilon));
    if (restitution) text += fmt::format("restitution = {}\n", number(*restitution));
    text += fmt::format("[method]\nname = \"{}\"\nrelative_tolerance = {}\nabsolute_tolerance = {}\nstep = {}\n",
                        method, number(relative), number(absolute), number(step()));
    if (impact != "paoli_schatzman") text += fmt::format("impact = \"{}\"\n", impact);
    return text + fmt::format("[output]\nevery = {}\n", number(every()));
  }

  SceneFile read() const { return parse_scene(toml(), "random.toml"); }

 private:
  static std::string number(double value) { return fmt::format("{}", value); }
};

inline std::ostream& operator<<(std::ostream& out, const RandomScene& scene) { return out << "\n" << scene.toml(); }

}  // namespace viscobar::properties
