#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "characteristics/piecewise_fit.hpp"
#include "viscobar/run/run.hpp"
#include "viscobar/scene/scene.hpp"

namespace viscobar::characteristics {

/// The bodies between two bars, or at an end of the chain: faces of bars, rigid bodies, the ground, and the links
/// between them. A body of mass m has the faces i of impedances Z_i, at which the waves w_i = v -+ s/(rho c) arrive, a
/// force F and a dashpot c, and links whose forces N push their sides a and b apart:
///
///     m v' + (sum Z_i + c) v = sum Z_i w_i + F + sum of N_b - sum of N_a,     and a face sends 2 v - w_i.
///
///     fixed     v_b = v_a                                contact   0 <= g  _|_  N >= 0,  g' = v_b - v_a
///     spring    N = k d + c d',  d = u_a - u_b           stop      N = max(0, k d + c d') where d > 0,  d = -g
///
/// Bodies that a closed link ties move as one. An impact leaves two masses that velocity in common which keeps their
/// momentum; a face has none. While no link changes, the velocities of masses and the d are a linear system: on an
/// interval of at most two of its own times it is solved by Picard's iteration, whose n-th step errs by 2^n / n!.
/// Without masses and springs each v is a sum of what arrives, at any time, and no interval is cut.
///
/// Times are in windows, in which all that arrives is known from the beginning.
class Junction {
 public:
  enum class Kind { fixed, contact, spring, stop };

  /// `window` is the time of one, `start` the time of window 0.
  Junction(double window, double start) : window_(window), start_(start) {}

  /// @name Making: bodies from left to right, and what they have
  ///@{
  struct Data {
    double displacement, velocity;
  };
  std::size_t add_body(const Data& data);
  void add_mass(std::size_t body, double mass, double velocity, std::string key);
  void add_face(std::size_t body, double impedance);
  /// The ground and what stands on it, at the left end of the chain or at the right one. Refers to `input`.
  void add_end(std::size_t body, const EndCondition& condition, const EndInput& input, bool right);
  void add_joint(std::size_t a, std::size_t b, const Joint& joint, std::size_t number);
  void finish();
  ///@}

  /// A bound of the rate, per window, at which masses and springs move, and the key that it comes from.
  std::pair<double, std::string> fastest() const;

  struct Face {
    std::size_t body;
    double impedance;
    const Piecewise* arriving = nullptr;  ///< to be set for each window
    Piecewise sent = {};
  };
  std::vector<Face> faces;

  /// How large displacements and velocities are: what is smaller by 64 roundings is nothing.
  struct Scale {
    double place, velocity;
  };
  /// Fits the forces and motions of window k. @throws LoadError
  void enter(std::size_t window);
  /// Largest |w_i|, |F| / Z, |V|, and velocity of a mass in this window.
  double bound() const;
  /// Finds the waves that the faces send up to s = until.
  void answer(double until, const Scale& scale);

  /// Contact change.
  struct Turn {
    double s;
    std::size_t link;
    Change change;
    double velocity;    ///< of the body beside the ground, or of side b against a: before a closing, after an opening
    double impulse;     ///< that the link has given so far, without the blow of an impact
    ContactPeak peak;   ///< that the contact which ends has had, its time in windows
    double lost;        ///< energy that the change takes
    double work = 0.0;  ///< energy that the ground gives by a blow
  };
  const std::vector<Turn>& turns() const { return turns_; }  ///< of the window, in order

  struct Link {
    Kind kind;
    std::size_t a, b;
    double gap = 0.0, stiffness = 0.0, damping = 0.0;
    std::size_t joint = 0;  ///< its number, from 1; 0: it is at an end
    std::string key = {};
    Piecewise force = {};  ///< N in the window
    bool touches() const { return kind == Kind::contact || kind == Kind::stop; }
  };
  const std::vector<Link>& links() const { return links_; }
  /// The sign of N as a force on the end of the chain, in the direction of u.
  double sign(std::size_t link) const { return bodies_[links_[link].b].held ? -1.0 : 1.0; }
  bool is_end(std::size_t body) const { return bodies_[body].end; }
  /// True if it is more than faces, obstacles and fixed ends.
  bool driven() const { return flows_ || !states_.empty(); }
  double farthest() const;  ///< of displacements and clearances between two windows

  /// @name At s of the window answered last, which is the time t
  ///@{
  double displacement_at(std::size_t body, double s, double t) const;
  double velocity_at(std::size_t body, double s, double t) const;
  double force_at(std::size_t link, double s) const;
  /// Since the start; elastic energy is that of springs, contact energy that of stops.
  EnergyState energy_at(double s) const;
  ///@}

  /// Between two windows.
  struct LinkMemory {
    bool closed = false, released = false;
    double clearance = 0.0, impulse = 0.0, peak_force = 0.0;
    ContactPeak latest = {};
    static void members(auto& link, auto&& each) {
      each(link.closed, link.released, link.clearance, link.impulse, link.peak_force, link.latest);
    }
  };
  struct BodyMemory {
    double place = 0.0, velocity = 0.0;  // the latter of a mass
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
    static void members(auto& body, auto&& each) { each(body.place, body.velocity, body.lowest, body.highest); }
  };
  struct Memory {
    std::vector<BodyMemory> bodies;
    std::vector<LinkMemory> links;
    double work = 0.0, dissipated = 0.0, error = 0.0;  // the last one a velocity, of F and V
    std::size_t searched = 0;                          // pieces, for turns
    static void members(auto& memory, auto&& each) {
      each(memory.bodies, memory.links, memory.work, memory.dissipated, memory.error, memory.searched);
    }
  };
  const Memory& memory() const { return now_; }
  /// The memory at the beginning of the window, from which restore() goes on.
  static void members(auto& junction, auto&& each) { each(junction.begin_); }
  void restore();
  void keep_energy() { energetic_ = true; }  ///< work and dissipation are asked for

 private:
  struct Body {
    double mass = 0.0, impedance = 0.0, dashpot = 0.0;  // impedance: of faces and dashpot
    bool held = false, end = false;                     // ground; the range of an end is kept
    const EndInput* input = nullptr;                    // its force, or the motion of ground
    double momentum = 0.0;                              // at the start, of `mass`
    double carried = 0.0;                               // mass on an end, which starts with the velocity of that
    std::string key = {};
    Piecewise moved = {};  // its velocity in the window
  };
  // F of a body, or V of ground, or V' where the junction has masses, which ground may move.
  struct Input {
    std::size_t body;
    bool rate = false;
    Piecewise values = {};
  };
  // Rows of coefficients of the sources: faces, inputs, states.
  struct Rows {
    std::vector<double> entries;
    std::size_t columns = 0;
    void resize(std::size_t rows, std::size_t wide) { entries.assign(rows * wide, 0.0), columns = wide; }
    double* operator[](std::size_t row) { return entries.data() + row * columns; }
    const double* operator[](std::size_t row) const { return entries.data() + row * columns; }
  };
  // From begin to end, with polynomials that are written on [from, to].
  struct Part {
    double begin, end, from, to;
    double z(double s) const { return (s - 0.5 * (from + to)) / (0.5 * (to - from)); }
  };
  // A place or clearance, and how far its bodies had come in the window when it was there.
  struct Mark {
    double place, travelled;
  };
  // A mass, by its first body, or the d of a link.
  struct StateOf {
    bool link;
    std::size_t number;
  };

  double velocity_per(const Input& input) const;
  std::optional<std::size_t> input_of(std::size_t body, bool rate) const;  // the column of a source
  void fit(const TimeFunction& f, const NextBreak& breaks, const char* what, Piecewise& fitted);
  void arrange();
  void find_velocities();
  void find_forces();
  bool tied(std::size_t link) const {
    return links_[link].kind == Kind::fixed || (links_[link].kind == Kind::contact && now_.links[link].closed);
  }
  // True if its spring or stop acts.
  bool pulls(std::size_t link) const {
    const Kind kind = links_[link].kind;
    return kind == Kind::spring || (kind == Kind::stop && now_.links[link].closed);
  }
  double mass_of(std::size_t group) const;
  std::optional<std::size_t> ground_of(std::size_t group) const;
  std::optional<std::size_t> state_of(bool link, std::size_t number) const;  // the column of a source
  void add_push(std::size_t body, double factor, double* row) const;
  // Bodies on the side of b, or where ground is among them on that of a; returns its sign.
  double side_of(std::size_t link);
  Chebyshev sum(const double* row) const;
  double travelled(const Link& link) const {
    return bodies_[link.b].moved.integral() - bodies_[link.a].moved.integral();
  }
  double clearance(std::size_t link) const {
    return clearances_[link].place + window_ * (travelled(links_[link]) - clearances_[link].travelled);
  }
  double place(std::size_t body) const {
    return places_[body].place + window_ * (bodies_[body].moved.integral() - places_[body].travelled);
  }
  void widen(BodyMemory& body, const Chebyshev& velocity, double duration, double from, double to) const;
  // The body that a link holds at the ground, and where, from the ground; absent where it holds none.
  std::optional<std::pair<std::size_t, double>> held_by(std::size_t link) const;
  void follow(double begin, double end);
  void start_states();
  std::optional<double> change_of(std::size_t link, const Part& part, const Scale& scale);
  void move(const Part& part, double stop);
  void turn(std::size_t link, double s, double z, const Scale& scale);
  void strike(std::size_t link, double z);
  bool closed_at(std::size_t link, double s) const;
  std::optional<std::size_t> holder(std::size_t body, double s) const;  // link by which ground holds it, if one does
  double depth_at(std::size_t link, double s) const;
  std::pair<double, double> flow(double until) const;
  void leave(double until);

  double window_, start_;
  std::size_t k_ = 0;
  std::vector<Body> bodies_;
  std::vector<Link> links_;
  std::vector<Input> inputs_;
  PiecewiseFit fit_;
  std::vector<double> breaks_;
  Memory now_, begin_;
  bool energetic_ = false, flows_ = false;
  std::size_t repeated_ = 0;
  std::vector<Turn> turns_;
  std::vector<Mark> clearances_, places_;
  std::vector<double> grounds_;  // places of all bodies at the start

  // All that holds while no link changes.
  std::vector<std::size_t> group_;  // of each body, by its first one
  std::vector<StateOf> states_;
  Rows velocities_, forces_, rates_, watched_;  // of bodies, links, states; k d + c d' of stops
  double rate_ = 0.0, reference_ = 1.0;         // the latter an impedance
  double heaviest_ = 0.0;                       // mass
  std::vector<char> side_;
  std::vector<double> at_start_, row_, before_;
  std::vector<std::size_t> massless_;
  Rows square_;
  std::vector<std::size_t> pieces_;
  std::vector<Chebyshev> sources_, constant_;
};

}  // namespace viscobar::characteristics
