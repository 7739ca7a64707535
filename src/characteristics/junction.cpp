#include "characteristics/junction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dynamics/finite_load.hpp"
#include "run/step_failure.hpp"

namespace viscobar::characteristics {

namespace {

constexpr double roundings = 64.0 * rounding;

// Where in [-1, 1] a clearance of this rate closes.
std::optional<double> closing(const Chebyshev& velocity, double duration, double clearance,
                              const Junction::Scale& scale) {
  const double band = roundings * scale.velocity, touch = roundings * scale.place;
  const Chebyshev path = (0.5 * duration) * velocity.antiderivative() + clearance;
  // A contact that touches and is pressed closes where the pressure begins: the path tells no more than that it falls.
  if (clearance <= touch)
    if (const auto pressed = first_descent(velocity, band); pressed && path(*pressed) <= touch) return pressed;
  return first_descent(path, touch);
}

}  // namespace

void Junction::fit(const TimeFunction& f, const NextBreak& breaks, const char* what, Piecewise& fitted) {
  const double begin = start_ + window_ * static_cast<double>(k_), end = begin + window_;
  breaks_.clear();
  // Two breaks within so little are one.
  const double apart = 64.0 * rounding * std::abs(end);
  if (breaks)
    for (auto at = breaks(begin, end); at && *at < end; at = breaks(*at + apart, end)) {
      const double s = (*at - begin) / window_;
      if (s > 1e-14 && s < 1.0 - 1e-14 && (breaks_.empty() || s > breaks_.back() + 1e-14)) breaks_.push_back(s);
    }
  const auto of_s = [&](double s) {
    const double t = begin + window_ * s;
    return finite_load(
        t, [&] { return f(t); }, [&] { return fmt::format("{} at t = {}", what, t); });
  };
  fitted = fit_.of(of_s, {.breaks = breaks_, .argument = static_cast<double>(k_) + 1.0, .what = what});
}

void Junction::enter(std::size_t window) {
  k_ = window;
  begin_ = now_;
  for (Input& input : inputs_) {
    const Body& body = bodies_[input.body];
    if (!body.held)
      fit(body.input->force->value, body.input->force->breaks, "the force at an end", input.values);
    else if (const EndMotion& motion = *body.input->motion; input.rate)
      fit(motion.acceleration, motion.breaks, "the acceleration of an end", input.values);
    else
      fit(motion.velocity, motion.breaks, "the velocity of an end", input.values);
    now_.error += fit_.error() * velocity_per(input);
  }
}

double Junction::velocity_per(const Input& input) const {
  return (input.rate ? heaviest_ : 1.0) / (bodies_[input.body].held && !input.rate ? 1.0 : reference_);
}

double Junction::bound() const {
  double most = 0.0;
  for (const Face& face : faces) most = std::max(most, face.arriving->bound());
  for (const Input& input : inputs_) most = std::max(most, input.values.bound() * velocity_per(input));
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if (bodies_[i].mass > 0.0) most = std::max(most, std::abs(now_.bodies[i].velocity));
  return most;
}

double Junction::farthest() const {
  double most = 0.0;
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if (!bodies_[i].held) most = std::max(most, std::abs(now_.bodies[i].place));
  for (const LinkMemory& link : now_.links) most = std::max(most, std::abs(link.clearance));
  return most;
}

void Junction::answer(double until, const Scale& scale) {
  turns_.clear();
  for (Face& face : faces) face.sent.clear();
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    bodies_[i].moved.clear();
    places_[i] = {now_.bodies[i].place, 0.0};
    widen(now_.bodies[i], {}, 0.0, now_.bodies[i].place, now_.bodies[i].place);
  }
  for (std::size_t l = 0; l < links_.size(); ++l) {
    links_[l].force.clear();
    clearances_[l] = {now_.links[l].clearance, 0.0};
    now_.links[l].latest.time -= 1.0;
  }
  const std::size_t known = faces.size() + inputs_.size();
  const auto given = [&](std::size_t i) -> const Piecewise& {
    return i < faces.size() ? *faces[i].arriving : inputs_[i - faces.size()].values;
  };
  pieces_.assign(known, 0);
  for (double s = 0.0; s < until;) {
    double end = until;
    for (std::size_t i = 0; i < known; ++i) {
      const Piecewise& f = given(i);
      std::size_t& at = pieces_[i];
      while (at + 1 < f.size() && f[at].end <= s) ++at;
      if (at + 1 < f.size()) end = std::min(end, f[at].end);
    }
    // No piece is left that would be too short for itself.
    if (const double longest = s + 2.0 / rate_; !states_.empty() && end - longest >= 2.0 * Piecewise::shortest)
      end = longest;
    Part part{s, end, s, end};
    // One wave alone keeps the polynomial it has, on the interval it was written on.
    if (known == 1 && states_.empty()) part.from = given(0)[pieces_[0]].from(), part.to = given(0)[pieces_[0]].to();
    for (std::size_t i = 0; i < known; ++i) sources_[i] = given(i).on(pieces_[i], part.from, part.to);
    if (!states_.empty()) follow(s, end);
    std::optional<double> first;
    std::size_t link = 0;
    for (std::size_t l = 0; l < links_.size() && end - s >= Piecewise::shortest; ++l)
      if (links_[l].touches())
        if (const auto z = change_of(l, part, scale); z && (!first || *z < *first)) first = z, link = l;
    double stop = end;
    // A zero after the beginning that rounds to it would be met again and again.
    if (first && *first < 1.0)
      stop = *first > -1.0 ? std::min(end, std::max(s + 0.5 * (end - s) * (*first + 1.0), s + Piecewise::shortest)) : s;
    move(part, stop);
    constexpr std::size_t most_repeated = 1000;
    repeated_ = stop - s > 1e-13 ? 0 : repeated_ + 1;
    if (repeated_ > most_repeated)
      throw StepFailure(Failure::toggling, "contacts open and close at one time without end");
    if (first) turn(link, stop, part.z(stop), scale);
    s = stop;
  }
  leave(until);
}

// x' = A x + f on [begin, end]: x := x_0 + int (A x + f), until it stays.
void Junction::follow(double begin, double end) {
  const double half = 0.5 * (end - begin);
  const std::size_t known = faces.size() + inputs_.size();
  start_states();
  constant_.resize(states_.size());
  for (std::size_t j = 0; j < states_.size(); ++j) {
    constant_[j] = Chebyshev::constant(0.0);
    for (std::size_t i = 0; i < known; ++i)
      if (const double factor = rates_[j][i]; factor != 0.0) constant_[j] += factor * sources_[i];
  }
  constexpr int most = 60;
  bool moved = true;
  for (int n = 0; n < most && moved; ++n) {
    moved = false;
    for (std::size_t j = 0; j < states_.size(); ++j) {
      Chebyshev slope = constant_[j];
      for (std::size_t i = 0; i < states_.size(); ++i)
        if (const double factor = rates_[j][known + i]; factor != 0.0) slope += factor * sources_[known + i];
      slope.cut(Chebyshev::fitted_terms);
      Chebyshev next = half * slope.antiderivative() + at_start_[j];
      next.cut(Chebyshev::fitted_terms);
      next.chop(0.01 * rounding * next.bound());
      Chebyshev change = next;
      change += -sources_[known + j];
      moved |= change.bound() > rounding * next.bound();
      sources_[known + j] = next;
    }
  }
}

void Junction::start_states() {
  const std::size_t known = faces.size() + inputs_.size();
  at_start_.resize(states_.size());
  sources_.resize(known + states_.size());
  for (std::size_t j = 0; j < states_.size(); ++j) {
    at_start_[j] = states_[j].link ? -clearance(states_[j].number) : now_.bodies[states_[j].number].velocity;
    sources_[known + j] = Chebyshev::constant(at_start_[j]);
  }
}

Chebyshev Junction::sum(const double* row) const {
  Chebyshev p;
  bool any = false;
  for (std::size_t i = 0; i < sources_.size(); ++i)
    if (row[i] == 1.0 && !any)
      p = sources_[i], any = true;
    else if (row[i] != 0.0)
      p += row[i] * sources_[i], any = true;
  return p.terms() > 0 ? p : Chebyshev::constant(0.0);
}

std::optional<double> Junction::change_of(std::size_t l, const Part& part, const Scale& scale) {
  const Link& link = links_[l];
  const LinkMemory& memory = now_.links[l];
  const double band = roundings * scale.velocity, touch = roundings * scale.place;
  const double from = part.z(part.begin), to = part.z(part.end), duration = window_ * (part.end - part.begin);
  const auto falls = [&](const Chebyshev& force) -> std::optional<double> {
    if (force.lower() >= -band) return std::nullopt;
    ++now_.searched;
    return first_descent(force.restricted(from, to), band);
  };
  if (memory.closed) return falls((1.0 / reference_) * sum(forces_[l]));
  row_.resize(sources_.size());
  for (std::size_t i = 0; i < row_.size(); ++i) row_[i] = velocities_[link.b][i] - velocities_[link.a][i];
  const Chebyshev whole = sum(row_.data());
  const double now = clearance(l);
  if (memory.released) {
    const auto pushed = falls((-1.0 / reference_) * sum(watched_[l]));
    const Chebyshev path = (0.5 * duration) * whole.restricted(from, to).antiderivative() + now;
    const auto left = first_descent(-path, 0.0);
    return pushed && left ? std::min(pushed, left) : pushed ? pushed : left;
  }
  if (now > touch && now + duration * std::min(0.0, whole.lower()) >= -touch) return std::nullopt;
  ++now_.searched;
  return closing(whole.restricted(from, to), duration, now, scale);
}

// The range of places by a path that leads from one to another; within it is looked for an extreme only where the
// velocity may have a zero that leads beyond what is known.
void Junction::widen(BodyMemory& body, const Chebyshev& velocity, double duration, double from, double to) const {
  body.lowest = std::min({body.lowest, from, to});
  body.highest = std::max({body.highest, from, to});
  if (velocity.lower() >= 0.0 || velocity.upper() <= 0.0) return;
  const double reach = duration * velocity.bound();
  if (from - reach >= body.lowest && from + reach <= body.highest) return;
  const Chebyshev path = (0.5 * duration) * velocity.antiderivative() + from;
  const double tolerance = roundings * path.bound();
  body.highest = maximum(path, body.highest, tolerance);
  body.lowest = -maximum(-path, -body.lowest, tolerance);
}

void Junction::move(const Part& part, double stop) {
  if (stop <= part.begin) return;
  const double from = part.z(part.begin), to = part.z(stop);
  row_.resize(sources_.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const double* velocity = velocities_[faces[i].body];
    for (std::size_t j = 0; j < row_.size(); ++j) row_[j] = 2.0 * velocity[j] - (i == j ? 1.0 : 0.0);
    faces[i].sent.append(stop, part.from, part.to, sum(row_.data()));
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    Body& body = bodies_[i];
    if (body.held && !body.input) continue;
    const Chebyshev v = sum(velocities_[i]);
    const double before = place(i);
    body.moved.append(stop, part.from, part.to, v);
    if (body.end) widen(now_.bodies[i], v.restricted(from, to), window_ * (stop - part.begin), before, place(i));
    if (!body.held && heaviest_ > 0.0) now_.bodies[i].velocity = v(to);
  }
  for (std::size_t l = 0; l < links_.size(); ++l) {
    LinkMemory& memory = now_.links[l];
    const Chebyshev force = sum(forces_[l]);
    const double before = links_[l].force.integral();
    links_[l].force.append(stop, part.from, part.to, force);
    if (!memory.closed) continue;
    memory.impulse += window_ * (links_[l].force.integral() - before);
    const double known = std::abs(memory.latest.reaction);
    if (force.upper() <= known) continue;
    const double largest = maximum(force.restricted(from, to), known, roundings * force.bound());
    const double middle = 0.5 * (part.begin + stop);
    const double where =
        std::max({part.begin, middle, stop}, [&](double a, double b) { return force(part.z(a)) < force(part.z(b)); });
    memory.peak_force = std::max(memory.peak_force, memory.latest.raise(largest, where));
  }
}

void Junction::turn(std::size_t l, double s, double z, const Scale& scale) {
  const Link& link = links_[l];
  LinkMemory& memory = now_.links[l];
  const double depth = -clearance(l);
  const auto velocity = [&] {
    const auto of = [&](std::size_t body) { return sum(velocities_[body])(z); };
    return link.joint > 0 ? of(link.b) - of(link.a) : of(bodies_[link.a].held ? link.b : link.a);
  };
  if (memory.released && depth <= roundings * scale.place) {
    memory.released = false;
    return arrange();
  }
  const double stored = link.kind == Kind::stop ? 0.5 * link.stiffness * depth * depth : 0.0;
  Turn told{s, l, memory.closed ? Change::opening : Change::closing, velocity(), memory.impulse, memory.latest, 0.0};
  memory.closed = !memory.closed;
  if (told.change == Change::closing) {
    told.lost = memory.released ? -stored : 0.0;
    memory.released = false;
    memory.latest = {0.0, s};
    turns_.push_back(told);
    if (link.kind == Kind::contact) {
      clearances_[l] = {0.0, travelled(link)};
      if (const auto held = held_by(l)) places_[held->first] = {held->second, bodies_[held->first].moved.integral()};
      strike(l, z);
    } else if (std::abs(depth) <= roundings * scale.place) {
      // Rounded to the other side, the depth of a stiff stop would be a pull that opens it at once.
      clearances_[l] = {0.0, travelled(link)};
    }
  } else {
    memory.released = link.kind == Kind::stop && depth > roundings * scale.place;
    told.lost = memory.released ? stored : 0.0;
    if (link.kind == Kind::contact) clearances_[l] = {0.0, travelled(link)};
    turns_.push_back(told);
  }
  arrange();
  if (told.change == Change::opening) turns_.back().velocity = velocity();
}

// Before the groups are those behind the closing.
void Junction::strike(std::size_t l, double z) {
  const std::size_t a = group_[links_[l].a], b = group_[links_[l].b];
  double mass = 0.0, momentum = 0.0;
  bool one[2] = {false, false};
  std::optional<std::size_t> ground;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    if (group_[i] != a && group_[i] != b) continue;
    const double m = bodies_[i].mass, v = now_.bodies[i].velocity;
    if (bodies_[i].held) ground = i;
    if (m == 0.0 && !bodies_[i].held) continue;
    one[group_[i] == a ? 0 : 1] = true;
    mass += m, momentum += m * v;
  }
  if (mass == 0.0) return;
  const double common = ground ? sum(velocities_[*ground])(z) : momentum / mass;
  double lost = 0.0;
  before_.clear();
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const double v = now_.bodies[i].velocity;
    before_.push_back(v);
    if (group_[i] != a && group_[i] != b) continue;
    lost += 0.5 * bodies_[i].mass * (v - common) * (v - common);
    now_.bodies[i].velocity = common;
  }
  if (!one[0] || !one[1]) return;  // one of them has no mass, and the other moves on
  turns_.back().lost += lost;
  if (ground) turns_.back().work = common * (mass * common - momentum);
  arrange();
  for (std::size_t k = 0; k < links_.size(); ++k) {
    if (!tied(k) || links_[k].kind != Kind::contact || group_[links_[k].a] != group_[links_[l].a]) continue;
    const double sign = side_of(k);
    double blow = 0.0;
    for (std::size_t i = 0; i < bodies_.size(); ++i)
      if (side_[i] && bodies_[i].mass > 0.0) blow += bodies_[i].mass * (now_.bodies[i].velocity - before_[i]);
    now_.links[k].impulse += std::max(0.0, sign * blow);
  }
}

std::optional<std::pair<std::size_t, double>> Junction::held_by(std::size_t l) const {
  const auto& [a, b, gap] = std::tie(links_[l].a, links_[l].b, links_[l].gap);
  if (bodies_[a].held) return std::pair(b, place(a) - gap);
  if (bodies_[b].held) return std::pair(a, place(b) + gap);
  return std::nullopt;
}

void Junction::leave(double until) {
  for (std::size_t l = 0; l < links_.size(); ++l)
    now_.links[l].clearance = links_[l].kind == Kind::contact && now_.links[l].closed ? 0.0 : clearance(l);
  for (std::size_t i = 0; i < bodies_.size(); ++i) now_.bodies[i].place = place(i);
  for (std::size_t l = 0; l < links_.size(); ++l)
    if (const auto held = tied(l) ? held_by(l) : std::nullopt) now_.bodies[held->first].place = held->second;
  if (!energetic_) return;
  const auto [work, dissipated] = flow(until);
  now_.work += work, now_.dissipated += dissipated;
  for (const Turn& turn : turns_) now_.dissipated += turn.lost, now_.work += turn.work;
}

}  // namespace viscobar::characteristics
