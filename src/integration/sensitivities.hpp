#pragma once

#include <deque>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/derivative/derivative.hpp"
#include "dynamics/jumps/jump_filter.hpp"
#include "integration/error_weights.hpp"
#include "viscobar/run/run.hpp"

namespace viscobar {

/// The derivatives of a run with respect to parameters. They are part of the state y (see Layout) and advanced by the
/// stepper with it, leg by leg. A contact changes at the root t* of its indicator phi (see Indicators), and with
/// f = (v, a) the rate of the state before and after,
///
///     dt*/dp = -(phi_u u' + phi_v v' + phi_p) / (dphi/dt),      s+ = G (s- + f- dt*/dp) + G_p - f+ dt*/dp,
///
/// G being what the change makes of the state: an impact of a rigid contact, else the identity. Where dphi/dt vanishes,
/// to what is known of it, the change has no derivative, nor has what follows if f jumps.
class Sensitivities {
 public:
  /// All outlive it.
  Sensitivities(PenalisedSystem& system, const Penalty& penalty, std::span<const Direction> directions);

  std::span<Derivative* const> derivatives() const { return pointers_; }
  /// To be called before all else; `account` is kept up to date.
  void attach(const Layout& layout, SensitivityAccount& account, const ErrorWeights& weights);
  /// The derivatives of the initial state y, no contact being closed.
  void begin(double t, double end, std::span<double> y);
  /// A leg begins at t: nodes that follow their row at once are put where the load has them from there on.
  void begin_leg(double t, double end, std::span<double> y);

  /// Contact i is about to change at t in the state y, whose velocities are complete: derivatives of that change.
  /// A rigid contact that opens by a pull which it has had `since` earlier opens as by a graze. A stop may change
  /// `by_push`, by its push condition.
  std::vector<ChangeSensitivity> before(double t, double since, std::size_t i, bool by_push, std::span<double> y);
  /// Those of its opening at once, by a rebound.
  void rebound(std::size_t i, std::vector<ChangeSensitivity>& changes) const;
  /// Those of a change at t, where its obstacle jumps away or has a kink, or the load jumps: where the derivatives end
  /// at t, of its time alone.
  std::vector<ChangeSensitivity> at_break(double t, double end, std::size_t i, std::span<double> y);
  /// It has, y being the state after the change but for its derivatives.
  void after(double t, std::size_t i, std::span<double> y);

  /// To those of a change of contact i, velocities in the frame, what they are of the bar itself.
  void add_frame(double t, std::size_t i, std::vector<ChangeSensitivity>& changes) const;
  /// Makes the derivatives those in the frame that follows obstacles that move, its lift and rate being those at
  /// `after`; in the part of the run that begins there, the impulses on ends are told of it.
  void leave_frame(double t, double after, std::span<double> y);
  void enter_frame(double t, std::span<double> y) { cross_frames(t, -1.0, y); }
  /// A leg begins at t, where motions of ends may have kinks; before the velocities of the bar have passed its own.
  void pass_kink(double t, double end, const FrameJump* of_bar, std::span<double> y);

  /// The same jumps of the derivatives as of the bar, see JumpFilter: to be called before those of the bar in the state
  /// y, which `jump`() makes, of the start of the run, or of a break of the load.
  template <class Jump>
  void pass_start(JumpFilter& filter, double t, std::span<double> y, Jump&& jump) {
    if (!lost()) {
      book_momentum(t, 1.0, y);
      const Moment at{t, layout_->u(y), layout_->w(y), {}};
      each(y, [&](std::size_t k, Derivative& derivative, const Block& s) {
        derivative.take_contacts();
        derivative.drive(at);
        filter.start_rates(derivative, t, at.w, s.u(), s.w(), jumps_[k].first, jumps_[k].second);
      });
    }
    jump();
    pass_jumps(filter, y);
    book_momentum(t, -1.0, y);
  }
  template <class Jump>
  void pass_break(JumpFilter& filter, double t, double end, std::span<double> y, Jump&& jump) {
    book_momentum(t, 1.0, y);
    jump();
    if (lost()) return;
    for (std::size_t k = 0; k < pointers_.size(); ++k) {
      for (std::vector<double>* one : {&jumps_[k].first, &jumps_[k].second}) std::ranges::fill(*one, 0.0);
      pointers_[k]->motion().load().jump(t, end, jumps_[k].first, jumps_[k].second);
    }
    pass_jumps(filter, y);
    book_momentum(t, -1.0, y);
  }

  /// Derivatives of a snapshot, valid until the next call.
  std::span<const FieldSensitivity> fields(double t, std::span<double> y, const Snapshot& snapshot);
  /// Brings the account up to date.
  void sum_up(double t, std::span<double> y);

  /// There are no derivatives from t on.
  void lose(double t, std::string why, std::span<double> y);

 private:
  static constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
  using Block = Layout::Block<double>;
  struct Field {
    std::vector<double> u, v;
  };
  bool lost() const { return account_->lost.has_value(); }
  Moment look_at(double t, std::span<double> y);
  // use(k, derivative k, its block of y)
  void each(std::span<double> y, auto&& use) {
    for (std::size_t k = 0; k < pointers_.size(); ++k) use(k, *pointers_[k], layout_->derivative(y, k));
  }
  void complete(Derivative& derivative, const Moment& at, const Block& s);
  // Adds so many times the momentum of the rows of ends to their impulses.
  void book_momentum(Derivative& derivative, const Moment& at, const Block& s, double times) const;
  void book_momentum(double t, double times, std::span<double> y);
  void cross_frames(double t, double times, std::span<double> y);
  void shift_to_change(const Moment& at, std::size_t i, std::span<double> y);
  void find_reactions(const Moment& at);
  void book_bodies(Derivative& derivative, const Moment& at, const Block& s, double times, double shift) const;
  void book_blow(Derivative& derivative, const Moment& at, const Block& s, double times) const;
  void differentiate_by_time(const Moment& at);
  static void shift(const Block& s, std::span<const double> v, std::span<const double> a, double time);
  double break_rate(std::size_t k, double t, double end, const Contact& contact) const;
  void strike_by_kink(const FrameJump& of_bar, const FrameJump& moved, const Moment& at, const Block& s);
  void pass_jumps(JumpFilter& filter, std::span<double> y);
  double acceleration_of(const Moment& at, std::size_t i);
  double indicator_rate(const Moment& at, std::size_t i, bool by_push);
  bool grazes(std::size_t i, double rate) const;
  bool opens_by_reaction(std::size_t i) const;
  bool is_torn_off(const Moment& at, std::size_t i);
  bool jumps(std::size_t i, bool by_push) const;

  PenalisedSystem& system_;
  const Contacts& contacts_;
  std::span<const Direction> directions_;
  double restitution_;
  std::deque<Derivative> all_;
  std::vector<Derivative*> pointers_;
  Direction time_direction_;
  Derivative time_;  // whose motion is (v, a)
  const Layout* layout_ = nullptr;
  const ErrorWeights* weights_ = nullptr;
  SensitivityAccount* account_ = nullptr;
  std::vector<double> w_, acceleration_, load_rate_;
  std::vector<double> parted_;  // scratch
  // Data of the change that is under way.
  std::vector<double> old_velocity_, old_acceleration_, shifts_;
  bool shifted_ = false;
  std::array<double, 2> reactions_{};  // of obstacles, before the change and then after it
  std::array<EndRows, 2> blow_{};      // rows of ends that take part in it
  std::pair<double, std::size_t> last_change_{-1.0, 0};
  std::vector<std::pair<std::vector<double>, std::vector<double>>> jumps_;  // [b] and [b'] of each
  std::vector<Field> fields_;
  std::vector<FieldSensitivity> told_;
};

}  // namespace viscobar
