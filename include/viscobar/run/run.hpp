#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "viscobar/dynamics/contact.hpp"
#include "viscobar/dynamics/sensitivity.hpp"
#include "viscobar/dynamics/state.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar {

/// Where the energy is at one time, and what came and went since the start of the run:
///
///     kinetic + elastic + contact + dissipated = initial + work + balance error
///
/// A scheme's energy is that of the step in which the time lies, E^{n-1/2}, whose balance is exact.
struct EnergyState {
  double kinetic = 0.0;      ///< 1/2 w.rho Q w
  double elastic = 0.0;      ///< 1/2 E int u_x^2
  double contact = 0.0;      ///< in the springs of a penalty
  double dissipated = 0.0;   ///< since the start, as in EnergyAccount
  double work = 0.0;         ///< since the start, as in EnergyAccount
  double end_inertia = 0.0;  ///< of the dissipated, as in EnergyAccount
  /// Energy of the bar and its contacts.
  double total() const { return kinetic + elastic + contact; }
};

/// The solution at one output time, over all J+1 nodes of the mesh.
struct Snapshot {
  double time = 0.0;          ///< t
  std::span<const double> u;  ///< displacement, J+1 entries, valid during the call
  std::span<const double> v;  ///< velocity, likewise
  /// Force of the obstacles on the end nodes in the direction of u, R_0 = -s and R_L = s in contact: a push, but for
  /// the dashpot of a penalty with restitution, which may pull as a contact opens; for a fixed end the force that holds
  /// or moves it, by its own row (see BarSystem::holding_force); 0 at a free end.
  double reaction_left = 0.0;
  double reaction_right = 0.0;  ///< the same at the right end
  double reaction_span = 0.0;   ///< of a span obstacle on all of its nodes
  /// N of each of Elements::joints(), which pushes its sides apart; valid during the call.
  std::span<const double> joint_forces{};
  /// An entry for each direction that was asked for, valid during the call.
  std::span<const FieldSensitivity> sensitivities{};
  std::optional<EnergyState> energy = std::nullopt;  ///< where Observers asked for the account
};

/// Contact change: at a closing the node reaches the obstacle, at an opening it leaves.
enum class Change { closing, opening };

/// The largest reaction of a contact from its closing on.
struct ContactPeak {
  double reaction = 0.0;  ///< R, in the direction of u, of the largest |R|
  double time = 0.0;      ///< where it is, to a part of a step

  /// Takes another one in; returns |R| of the larger.
  double raise(double other, double at) {
    if (std::abs(other) > std::abs(reaction)) reaction = other, time = at;
    return std::abs(reaction);
  }
};

/// A contact change.
struct Event {
  double time = 0.0;                ///< t
  Where where = Where::left;        ///< of the obstacle
  std::size_t node = 0;             ///< mesh node; of a joint its number, from 1
  Change change = Change::closing;  ///< closing or opening
  /// u_t of the node: towards the obstacle when it closes, the impact velocity; at a joint that of its right side
  /// against its left one
  double velocity = 0.0;
  /// int R dt of the end's reaction from the start to here, at a closing without its blow; absent under a span
  /// obstacle, and where nobody asked for the account of the run.
  std::optional<double> impulse = std::nullopt;
  std::vector<ChangeSensitivity> sensitivities = {};  ///< an entry for each direction that was asked for
  /// Peak of the contact, at an opening that ends the contact of its end or joint, or that of all nodes under a span
  /// obstacle; absent where nobody asked for the account of the run.
  std::optional<ContactPeak> peak = std::nullopt;
};

/// initial + work = final + dissipated + balance_error, the error being that of the time integration.
struct EnergyAccount {
  double initial = 0.0;     ///< kinetic and elastic energy, that of springs included, at the start
  double final = 0.0;       ///< the same at the end
  double dissipated = 0.0;  ///< by viscosity, the dashpots of contacts and ends, impacts, and end_inertia
  double work = 0.0;        ///< of the load, of forces on the ends, and of what moves ends and obstacles
  /// Part of `dissipated` taken by the end rows of the mass `fourth_order`, whose inertia has no energy of its own: int
  /// v.(M - Q) v' dt, Q the symmetric part that the kinetic energy is made of, O(h^2); and what is lost where its high
  /// modes are put at their equilibrium, at jumps, O(h). 0 for other masses.
  double end_inertia = 0.0;
  /// The most that dissipated, work, and what they left to the bar came to on the way: the scale of what the balance
  /// may be off by.
  double largest = 0.0;
  /// Schemes: the most that impacts have given the bar, which an obstacle that stands still cannot. With A(t)
  /// what impacts took up to t, max A(s) - A(t) over s <= t, nothing touching at s, and 0 at the start.
  double growth = 0.0;
  double growth_time = 0.0;  ///< that t
  /// Adds to both.
  void take_by_rows(double taken) { end_inertia += taken, dissipated += taken; }
  /// Takes notice, for `largest`, of what dissipated and work are on the way.
  void notice(double gone, double came) {
    largest = std::max({largest, std::abs(gone), std::abs(came), std::abs(initial + came - gone)});
  }
  /// Energy that the integration has gained.
  double balance_error() const { return final + dissipated - initial - work; }
};

/// How long something has been in contact, from contact changes.
struct TimeInContact {
  double until_opening = 0.0;          ///< up to the last opening
  std::optional<double> closed_since;  ///< when the contact that lasts began

  /// It begins or ends at t; a contact that lasts does not begin again.
  void close(double t) { closed_since = closed_since.value_or(t); }
  /// The contact ends at t.
  void open(double t) {
    until_opening = total(t);
    closed_since.reset();
  }
  /// Up to `now`, where the run is.
  double total(double now) const { return until_opening + (closed_since ? now - *closed_since : 0.0); }
};

/// The account of a contact, as exact between the output times as the method is: R is the reaction of its steps (a
/// polynomial each; of a scheme, values at its steps and linear between), N at a joint.
struct ContactAccount {
  std::size_t closings = 0;  ///< closings; under a span obstacle the sum over its nodes
  TimeInContact contact;     ///< time closed; under a span obstacle while any node is
  double impulse = 0.0;      ///< int R dt, a force times a time
  /// max |R|. Of an impact it may have no limit for finer meshes, stiffer springs or shorter steps: see
  /// viscobar::peak_remark().
  double peak_reaction = 0.0;
  ContactPeak latest;  ///< peak of the present contact, or else of the last one
};

/// Contact of one end with its own obstacles and the range of its displacement, u being that of the steps, too. R is
/// the force of all obstacles on the end node.
struct EndAccount : ContactAccount {
  double displacement = 0.0;                                ///< u where the run is
  double lowest = std::numeric_limits<double>::infinity();  ///< min u over time, infinite before a run
  double highest = -lowest;                                 ///< max u
};

/// The nodes under a span obstacle, R being its force on all of them in the direction of u.
struct SpanAccount : ContactAccount {
  std::size_t openings = 0;  ///< of nodes
  /// Nodes in contact.
  std::size_t closed() const { return closings - openings; }
};

/// Accounts of the ends of the bar and of its obstacles. Nothing in it depends on the output times.
struct RunAccount {
  EndAccount left;                       ///< at x = 0
  EndAccount right;                      ///< at x = L
  SpanAccount span;                      ///< of a span obstacle
  std::vector<ContactAccount> joints{};  ///< up to the last that has had a contact change

  /// The account of a joint by its number from 1, empty beyond all of those.
  ContactAccount joint(std::size_t number) const {
    return number <= joints.size() ? joints[number - 1] : ContactAccount{};
  }
  /// The account of the contact that changes: one of those above.
  ContactAccount& of(const Event& event);
  /// Counts a contact change.
  void count(const Event& event);
};

/// The largest pull at an opening. Where a step passes over the spring of a contact, the contact opens when its row,
/// with the node at rest, needs no reaction. The pull that is left then is given in multiples of the pull that the
/// tolerance, the delay of the spring and, over the step, the tolerance of the velocity explain.
struct LateOpening {
  double ratio = 0.0;  ///< the largest of the run; some 0.4 where it opens in time
  double time = 0.0;   ///< of that opening
};

/// Error of the motion of a method that takes the data as polynomial pieces, as a displacement at the end of the
/// run if it all added up, contact changes apart.
struct Representation {
  double error = 0.0;     ///< of the pieces, and of putting them together
  double rounding = 0.0;  ///< of the motion, accumulated, in the same quantity
  double velocity = 0.0;  ///< that no wave exceeded
};

/// Counts and accounts of a run.
struct Statistics {
  std::size_t unknowns = 0;         ///< scalars that the method advances
  std::size_t steps = 0;            ///< in time
  std::size_t rhs_evaluations = 0;  ///< of the right-hand side, of the residual for ida, of the step's for schemes
  std::size_t linear_solves = 0;    ///< tridiagonal
  std::size_t matrix_factorisations = 0;          ///< tridiagonal
  std::size_t event_evaluations = 0;              ///< steps searched for contact changes; 0 without an obstacle
  std::size_t load_evaluations = 0;               ///< 0 without a load
  std::size_t events = 0;                         ///< contact changes
  double integration_seconds = 0.0;               ///< processor time of the method alone, without its observers
  double reached_time = 0.0;                      ///< how far it came
  bool completed = false;                         ///< true if it reached the last output time
  double max_penetration = 0.0;                   ///< max over time and contacts, >= 0
  LateOpening late_opening;                       ///< of adaptive penalised methods
  std::optional<EnergyAccount> energy;            ///< where Observers asked for it
  std::optional<RunAccount> account;              ///< where Observers asked for it
  std::optional<Representation> representation;   ///< of `characteristics`
  std::optional<SensitivityAccount> sensitivity;  ///< where directions were asked for
};

/// The complete state of a run between two of its steps. A run that begins from it continues like the original, bit for
/// bit, if system, output times, method, the choice of an energy account and the build of the library are the same.
struct Checkpoint {
  double time = 0.0;        ///< where it was taken
  std::size_t outputs = 0;  ///< output times told so far
  Statistics statistics;    ///< so far
  std::string state;        ///< the method's own, binary
  /// Frames that a state may be in. As the bar comes to an obstacle that moves, the run enters the one that follows it.
  enum class Frame { resting, entered, following };
  Frame frame = Frame::resting;  ///< of that state
};

/// Where a run begins: with initial data, or where another run was.
using StartingPoint = std::variant<State, Checkpoint>;

/// Verdict of an observer on a run. One that is stopped returns what it reached, not completed.
enum class RunControl { go_on, stop };

/// When a run makes checkpoints, and who takes them.
///
/// A method with a memory of its steps begins anew at each of them, as after a contact change, in the run that goes on
/// as in one that begins from the checkpoint: that is why the two are the same. Where it makes checkpoints is therefore
/// part of what determines its steps (not of what they approximate). The steps of a scheme do not depend on it.
struct Checkpoints {
  std::optional<double> every;  ///< of simulated time: at times.front() + k every, or the first step of a scheme there
  std::function<bool()> asked;  ///< after each step: whether to make one where it ended; may be empty
  std::function<RunControl(const Checkpoint&)> take;  ///< gets each, before the run goes on
};

/// The extremes of the account of ends and contacts that anyone reads. A method need not look for the others.
struct AccountExtremes {
  bool ranges = true;  ///< of the displacements of the ends
  bool peaks = true;   ///< of reactions
};

/// The receivers of a run's results. Every member may be empty; a run computes nothing for empty ones.
struct Observers {
  std::function<void(const Snapshot&)> snapshot;    ///< at each output time, in order
  std::function<void(const Event&)> event;          ///< at each contact change, in order
  std::function<RunControl(double time)> progress;  ///< after each step
  bool energy = false;                              ///< keep the energy account
  bool account = false;                             ///< keep the account of ends and contacts
  AccountExtremes extremes{};                       ///< of that account
  /// True if anyone reads the reactions of snapshots. Else a method may leave them 0: that of a held node with mass
  /// takes a solve.
  bool reactions = true;
  /// True if anyone reads the nodes of snapshots between the ends. Else a method may leave them as they were.
  bool interior = true;
  /// Parameters with respect to which derivatives are told, too: by cvode, ida, arkode and rigid. They outlive the run.
  std::span<const Direction> directions{};
  std::optional<Checkpoints> checkpoints;  ///< to go on from
  /// Time of observers is not counted in integration_seconds, but for `progress`, which each step calls. That
  /// reads the clock twice a call, which is more than observers take that only keep a few numbers.
  bool off_the_clock = true;
};

/// A method that does not take a system; the finding says why, and what to change in keys of a scene file.
class Unfit : public std::invalid_argument {
 public:
  Unfit(std::string_view method, Finding why);  ///< the method's name and its reason
  Finding finding;                              ///< the reason
};

/// Why a run could not go on. What to change follows from it, in keys of a scene file: see remedy() of case.hpp.
enum class Failure {
  accuracy,       ///< no step, however short, keeps the tolerance
  digits,         ///< the tolerances ask for more digits than a number has
  stiffness,      ///< the equations of a step have no accurate solution
  inertia,        ///< a step leaves no digit of it beside damping or elasticity
  overflow,       ///< the solution is no longer finite
  load,           ///< it cannot be evaluated, or is too rough
  short_end,      ///< the rest of the run is below the rounding of the time
  length,         ///< the end is too many steps away
  chatter,        ///< it is, by contact changes
  brief_contact,  ///< a contact lasts a few roundings of the time
  toggling,       ///< a contact opens and closes for ever: its clearance is below the rounding of the displacement
  detail,         ///< waves break into more pieces than can be followed
  memory,         ///< it is exhausted
  defect          ///< nothing in the system is known to cause it: an error of viscobar
};

/// A run that failed: the method, the time, what happened, and the library's words. `statistics` say how far it came.
class IntegrationError : public std::runtime_error {
 public:
  /// Why, in words, too, and how far the run came.
  IntegrationError(Failure why, const std::string& what, Statistics reached)
      : std::runtime_error(what), failure(why), statistics(std::move(reached)) {}
  Failure failure;        ///< for who wants to know what to change
  Statistics statistics;  ///< up to the failure
};

}  // namespace viscobar
