#pragma once

#include <array>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "viscobar/discretisation/tridiagonal.hpp"
#include "viscobar/dynamics/bar_system.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// M f of a scene on the nodes of a system, as LoadVector evaluates it. Forces on the ends that are always the same are
/// part of a steady one.
struct NodalLoad {
  /// M f
  struct Steady {
    std::vector<double> weighted;  ///< of the unknowns
    std::array<double, 2> held{};  ///< of the ends, where they are fixed
  };
  /// history(t) M profile, and what is added to it
  struct Separable {
    std::vector<double> weighted;  ///< M profile of the unknowns
    std::array<double, 2> held;    ///< of the ends, where they are fixed
    TimeFunction history;
    NextBreak breaks;
    std::shared_ptr<const Separable> plus;
  };
  /// M f(x, t)
  struct General {
    SpaceTimeFunction density;
    NextBreak breaks;
    NextBreakAt breaks_at, breaks_in_x;
    BandedMatrix mass;  ///< over all nodes
  };

  std::optional<std::variant<Steady, Separable, General>> distributed;
  bool end_forces = false;      ///< the scene has some
  bool varying_forces = false;  ///< they are to be added
  std::optional<LoadDifference> difference;

  /// True if there is any.
  bool acts() const { return distributed || end_forces || (difference && difference->after->loaded()); }
};

/// The load of a scene; null: none.
std::shared_ptr<const NodalLoad> nodal_load(const Scene& scene, const BarSystem& system);

}  // namespace viscobar
