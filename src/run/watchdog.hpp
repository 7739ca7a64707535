#pragma once

#include <cstddef>
#include <limits>

namespace viscobar {

/// Ends runs that would not come to their end in any reasonable time, so that none hangs, and those whose contacts the
/// rounding of the numbers decides.
class Watchdog {
 public:
  /// The run is from `begin` to `end`. The pace is looked at every `look` steps, and every look / 50 contact changes:
  /// the time that went by tells how many steps the rest would take. More than `most` are refused, unless a second look
  /// sees half of them at most, as when a stiff contact settles. No run that comes to its end pauses for so long:
  /// bounces that die out do so in tens.
  explicit Watchdog(double begin, double end, std::size_t look = 1'000'000, double most = 1e10)
      : since_(begin), last_change_(begin), end_(end), look_(look), most_(most) {}

  /// To be told every step, made from `before` to `reached`, which may be the same.
  /// @throws StepFailure when the last hundred have led nowhere
  void attempt(double before, double reached);
  /// To be told every step that led on: the time that the run has come to and the contact changes so far.
  /// @throws StepFailure for a pace that does not reach the end
  void step(double t, std::size_t changes);
  /// To be told every change of a contact. @throws StepFailure when it changes again and again at one time
  void change(double t, std::size_t contact);
  /// To be told every contact that closes: half a period of its node on its spring is pi / rate.
  /// @throws StepFailure when that is a few roundings of t: it would be followed wrongly, without anything to show it
  static void close(double t, std::size_t node, double rate);

  /// How often the contact that changed last has changed again at that time.
  std::size_t toggles() const { return toggles_; }
  std::size_t last_contact() const { return last_contact_; }
  /// When, the beginning of the run where there was none.
  double last_change() const { return last_change_; }

  /// Content of a checkpoint.
  static void members(auto& dog, auto&& each) { each(dog.last_contact_, dog.toggles_, dog.last_change_); }

 private:
  double since_, last_change_, end_;
  std::size_t look_;
  double most_;
  std::size_t steps_ = 0, changes_ = 0, stalled_ = 0, last_contact_ = 0, toggles_ = 0;
  double rest_ = std::numeric_limits<double>::infinity();  // at the last look
};

}  // namespace viscobar
