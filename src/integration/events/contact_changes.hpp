#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "integration/accounts/contact_watch.hpp"
#include "integration/accounts/energy_books.hpp"
#include "integration/events/event_search.hpp"
#include "integration/events/late_opening.hpp"
#include "integration/sensitivities.hpp"
#include "run/notifier.hpp"
#include "run/watchdog.hpp"

namespace viscobar {

/// Contact changes of a run by steps: carries them out in the state y where the run is, books them, and tells them in
/// their order.
class ContactChanges {
 public:
  /// Objects that they act on; all outlive it.
  struct On {
    PenalisedSystem& system;
    const Layout& layout;
    LegStepper& stepper;
    EventSearch& search;
    Watchdog& watchdog;
    EnergyBooks& books;
    std::optional<ContactWatch>& ends;  ///< told of impacts, where it is there
    Sensitivities* sensitivities;       ///< or null
    std::vector<double>& y;
    double end;  ///< of the run
  };
  ContactChanges(const On& on, Notifier& notifier, Statistics& statistics)
      : on_(on),
        contacts_(on.system.contacts()),
        notifier_(notifier),
        statistics_(statistics),
        inner_(on.layout.size) {}

  /// The run starts at t in y, with these data and the velocities by which the bar comes to its obstacles. True if a
  /// contact is closed from the start on.
  bool start(double t, const State& data, const std::vector<double>& approach);
  /// A part of the run goes on from a checkpoint.
  void resume() { distrust_toggling(); }
  /// The first change that the search has found in the step from `begin` to `end` is at t, as others may be. The load
  /// may have jumped last at `load_break`.
  void switch_at(double t, double begin, double end, double load_break);
  /// The frame has a kink at t. An obstacle that jumps away leaves its contact open.
  void leave_obstacles(double t, const FrameJump& jump);
  /// A rigid contact that is closed has an impact then, or opens.
  void strike_by_kink(double t, const FrameJump& jump);

 private:
  // A closing that is not told yet, when its node struck last, and the impulse before.
  struct Withheld {
    std::size_t contact;
    double last, time, velocity;
    std::vector<ChangeSensitivity> sensitivities;
    std::optional<double> impulse;
  };

  std::span<double> u() const { return on_.layout.u(on_.y); }
  std::span<double> w() const { return on_.layout.w(on_.y); }
  void differentiate_start(double t, std::size_t i, const State& data, const std::vector<double>& approach);
  void switch_one(std::size_t i, double t, double begin, double end, double load_break);
  void open(std::size_t i, double told, const Opening& opening);
  void close(double t, std::size_t i, double velocity);
  void strike(double t, std::size_t i, std::optional<double> closing);
  bool is_of_scene(double t, std::size_t i, double closing) const;
  void give_back(double velocity);
  double kinetic_energy(std::span<const double> w) const;
  void distrust_toggling();
  double frame_velocity(double t, std::size_t i) const;
  bool goes_on(double t, std::size_t i) const;
  void withhold_closing(double t, std::size_t i, double velocity);
  void tell_closing(double t, std::size_t i, double velocity);
  void tell(double t, std::size_t i, Change change, double velocity);
  std::vector<ChangeSensitivity> sensitivities_at(double t, std::size_t i) const;

  On on_;
  Contacts& contacts_;
  Notifier& notifier_;
  Statistics& statistics_;
  std::vector<double> inner_;               // a state within a step
  std::vector<ChangeSensitivity> changes_;  // of the change under way
  std::optional<Withheld> withheld_;
};

}  // namespace viscobar
