#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "case/regime.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// Recognises chatter by listening to the contact changes of a run, whatever the method.
///
/// A bar that bounces stays in contact until a wave has been to its other end and back, for 2 L sqrt(rho / E). A
/// contact that closes `closings` times within that time does not bounce with the bar: its node rebounds by itself, on
/// the penalty spring or by the restitution of a scheme. A front that passes under a span obstacle closes each node
/// once. A node that goes from one obstacle to another on its other side does not rebound by itself.
class ChatterWatch {
 public:
  /// Closings within the time of a wave to the other end and back that make it chatter.
  static constexpr std::size_t closings = 16;

  /// Watches runs of `system`.
  explicit ChatterWatch(const BarSystem& system);

  /// Where and when chatter was recognised.
  struct Chatter {
    Where where = Where::left;  ///< end, or span
    std::size_t node = 0;       ///< of the mesh
    double since = 0.0;         ///< time of its first closing
    double until = 0.0;         ///< and of the last before it was recognised
  };

  /// To be told every change; the first chatter of a run, once.
  std::optional<Chatter> heard(const Event& event);

  /// Members that a checkpoint holds.
  static void members(auto& watch, auto&& each) { each(watch.ends_, watch.span_, watch.joints_, watch.told_); }

 private:
  struct Burst {
    double since = 0.0;
    std::size_t closings = 0;

    static void members(auto& burst, auto&& each) { each(burst.since, burst.closings); }
  };

  double window_;
  bool between_ = false;  // two obstacles that hold a node from both sides
  // Ends and a span obstacle have two for each mesh node where there are any, the second of closings upwards if there
  // are obstacles on both sides. Joints have two for each number.
  std::vector<Burst> ends_, span_, joints_;
  bool told_ = false;
};

/// Remedies against the chatter of a contact, in keys of the scene; empty where none is known.
std::string chatter_remedies(const Setup& setup, const std::optional<ContactRegime>& regime, Where where);

/// The warning of a run that chatters: where and how fast, what it means and costs, and what to change.
std::string chatter_warning(const Setup& setup, const BarSystem& system, const ChatterWatch::Chatter& chatter);

}  // namespace viscobar
