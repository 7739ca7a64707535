#include "studies/ensemble/members.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "case/scene_numbers.hpp"
#include "schemes/settled_start.hpp"
#include "viscobar/dynamics/load_vector.hpp"

namespace viscobar::bars {

namespace {

bool is_constant(std::span<const double> values) {
  const auto [least, most] = std::ranges::minmax_element(values);
  return *most - *least <= 1e-13 * std::max(std::abs(*least), std::abs(*most));
}

const EndCondition& end_of(const Scene& scene, bool right) { return right ? scene.right : scene.left; }
const EndInput& input_of(const Scene& scene, bool right) { return right ? scene.right_input : scene.left_input; }

void take_numbers(const Case& run, Member& member) {
  member.bar = run.scene.bar;
  member.restitution = run.restitution.value_or(0.0);
  for (const bool right : {false, true}) {
    if (const auto* obstacle = std::get_if<Obstacle>(&end_of(run.scene, right))) member.gap[right] = obstacle->gap;
    const EndInput& input = input_of(run.scene, right);
    member.stiffness[right] = input.stiffness, member.dashpot[right] = input.dashpot, member.mass[right] = input.mass;
  }
}

/// M f of a profile, and which entries forces on the ends have.
std::vector<double> weights_of(const Case& run, Mass mass, const SpaceFunction& profile, const Places& places) {
  Scene scene = run.scene;
  scene.load = SteadyLoad{profile, places};
  scene.left_input.force.reset(), scene.right_input.force.reset();
  const BarSystem system(scene, run.mesh(), mass);
  LoadVector load(system);
  const std::span<const double> weights = load.at(0.0);
  return {weights.begin(), weights.end()};
}

bool breaks(const NextBreak& next, double end) { return next && next(-1e-9 * end, 1.1 * end); }

/// Absent where the load is not smooth in time, or no sum of products.
std::optional<std::vector<LoadPart>> load_parts(const Case& run, Mass mass, std::size_t size) {
  const Scene& scene = run.scene;
  std::vector<LoadPart> parts;
  if (scene.load) {
    if (const auto* steady = std::get_if<SteadyLoad>(&*scene.load)) {
      parts.push_back({weights_of(run, mass, steady->profile, steady->places), {}});
    } else if (const auto* separable = std::get_if<SeparableLoad>(&*scene.load)) {
      if (breaks(separable->breaks, run.end)) return std::nullopt;
      parts.push_back({weights_of(run, mass, separable->profile, separable->places), separable->history});
    } else {
      return std::nullopt;
    }
  }
  for (const bool right : {false, true}) {
    const auto& force = input_of(scene, right).force;
    if (!force || is_fixed(end_of(scene, right))) continue;
    if (breaks(force->breaks, run.end)) return std::nullopt;
    std::vector<double> weights(size, 0.0);
    (right ? weights.back() : weights.front()) = force->steady ? force->value(0.0) : 1.0;
    parts.push_back({std::move(weights), force->steady ? TimeFunction() : force->value});
  }
  return parts;
}

}  // namespace

std::optional<Pattern> Members::pattern_of(const Case& run) const {
  const Scene& scene = run.scene;
  if (scene.span || scene.side || run.impact != Impact::paoli_schatzman) return std::nullopt;
  Scene unit = scene;
  unit.bar = {1.0, 1.0, 1.0, 1.0};
  unit.displacement = unit.velocity = [](double) { return 0.0; };
  unit.displacement_places = unit.velocity_places = {};
  unit.load.reset();
  if (scene.section) {
    unit.section = [of = scene.section, length = scene.bar.length](double x) { return of(length * x); };
    if (scene.section_places.breaks)
      unit.section_places.breaks = [of = scene.section_places.breaks, length = scene.bar.length](
                                       double after, double until) -> std::optional<double> {
        const auto found = of(length * after, length * until);
        return found ? std::optional(*found / length) : std::nullopt;
      };
  }
  Pattern pattern;
  for (const bool right : {false, true}) {
    EndInput& input = right ? unit.right_input : unit.left_input;
    if (input.motion) return std::nullopt;
    pattern.mounted[right] = input.stiffness > 0.0 || input.dashpot > 0.0 || input.mass > 0.0;
    input = {};
    // The node keeps the mass that `redistributed` takes from a bare one.
    if (pattern.mounted[right]) input.dashpot = 1.0;
    const auto* obstacle = std::get_if<Obstacle>(&end_of(scene, right));
    if (!obstacle) continue;
    if (obstacle->side == Side::both) return std::nullopt;
    pattern.contact[right] = true;
    pattern.sign[right] = obstacle->side == Side::below ? 1.0 : -1.0;
  }
  Mesh mesh = run.mesh();
  mesh.length = 1.0;
  const BarSystem system(unit, mesh, mass_);
  pattern.inertia = system.inertia().matrix();
  const std::size_t n = system.size(), first = system.unknowns().first_node();
  if (n < 4) return std::nullopt;
  pattern.stretch.assign(n + 1, 0.0);
  for (std::size_t i = 0; i <= n; ++i)
    if (i + first > 0 && i + first <= mesh.elements)
      pattern.stretch[i] = 1.0 / system.elements().stretch(i + first - 1);
  for (const bool right : {false, true}) pattern.massless[right] = system.inertia().massless(right ? n - 1 : 0);
  return pattern;
}

Members::Members(const Case& first, Mass mass, std::vector<std::string> keys)
    : mass_(mass), end_(first.end), keys_(std::move(keys)), elements_(first.elements) {
  // A bar's way must not depend on which bar is the first: where a key may change the pattern, all run alone.
  Case of_keys = first;
  const auto mounts = [](std::string_view key, bool right) {
    const std::string_view end = right ? "right." : "left.";
    if (!key.starts_with(end)) return false;
    const std::string_view leaf = key.substr(end.size());
    return leaf == "stiffness" || leaf == "dashpot" || leaf == "mass";
  };
  for (const std::string& key : keys_)
    if (key.starts_with("mesh.") || (mass == Mass::redistributed && (mounts(key, false) || mounts(key, true))) ||
        (first.scene.section && !key.starts_with("initial.") && (key == "bar.length" || !number_of(of_keys, key))))
      return;
  pattern_ = pattern_of(first);
  // A spring, a dashpot or a mass may be 0 in the first bar.
  for (const std::string& key : keys_)
    for (const bool right : {false, true})
      if (pattern_ && mounts(key, right)) pattern_->mounted[right] = true;
  if (!pattern_) return;
  auto member = of(first);
  if (!member) {
    pattern_.reset();
    return;
  }
  first_ = std::move(*member);
  const State data = BarSystem(first.scene, first.mesh(), mass).initial_state();
  resting_shape_ = is_constant(data.u) && is_constant(data.v);
  by_numbers_ = true;
  bool shape = false;
  Case numbers = first;
  for (const std::string& key : keys_) {
    shape |= key == "bar.length";
    by_numbers_ &= number_of(numbers, key) || key == "initial.velocity" || key == "initial.displacement";
  }
  // Sections, data, loads and held ends depend on places.
  const bool held = is_fixed(first.scene.left) || is_fixed(first.scene.right);
  if (shape) by_numbers_ &= resting_shape_ && !first_.member.load && !held && !first.scene.section;
  Case unit = first;
  unit.scene.displacement_places = unit.scene.velocity_places = {};
  unit.scene.displacement = unit.scene.velocity = [](double) { return 1.0; };
  const State ones = BarSystem(unit.scene, unit.mesh(), mass).initial_state();
  unit_velocity_.v = ones.v, unit_displacement_.u = ones.u;
  for (const std::string& key : keys_)
    if (key.starts_with("initial.")) by_numbers_ &= !held;
}

std::optional<OwnMember> Members::by_numbers(Case& numbers, std::span<const double> values) const {
  if (!by_numbers_) return std::nullopt;
  OwnMember one;
  one.member = first_.member;
  one.member.start = one.member.data;  // see below
  for (std::size_t k = 0; k < keys_.size(); ++k) {
    if (double* number = number_of(numbers, keys_[k])) {
      *number = values[k];
      continue;
    }
    if (!one.data) one.data = std::make_unique<State>(*one.member.data);
    one.member.start = one.member.data = one.data.get();
    const bool velocity = keys_[k] == "initial.velocity";
    const std::vector<double>& unit = velocity ? unit_velocity_.v : unit_displacement_.u;
    std::vector<double>& data = velocity ? one.data->v : one.data->u;
    for (std::size_t i = 0; i < data.size(); ++i) data[i] = values[k] * unit[i];
  }
  take_numbers(numbers, one.member);
  const Member& m = one.member;
  const auto positive = [](double value) { return std::isfinite(value) && value > 0.0; };
  const auto not_negative = [](double value) { return std::isfinite(value) && value >= 0.0; };
  if (!positive(m.bar.length) || !positive(m.bar.density) || !positive(m.bar.modulus) || !not_negative(m.bar.viscosity))
    return std::nullopt;
  if (!not_negative(m.restitution) || m.restitution > 1.0) return std::nullopt;
  for (const bool right : {false, true}) {
    for (const double number : {m.gap[right], m.stiffness[right], m.dashpot[right], m.mass[right]})
      if (!not_negative(number)) return std::nullopt;
    const double u = right ? m.start->u.back() : m.start->u.front();
    if (pattern_->contact[right] && pattern_->sign[right] * u + m.gap[right] < 0.0) return std::nullopt;
  }
  for (const std::vector<double>* data : {&m.start->u, &m.start->v})
    for (const double value : *data)
      if (!std::isfinite(value)) return std::nullopt;
  // Where the data do not fit the ends, their high modes are put right, which is the model's, on rows that are alike.
  const bool quiet = resting_shape_ && !m.load && !pattern_->mounted[0] && !pattern_->mounted[1] &&
                     !pattern_->fixed(false) && !pattern_->fixed(true);
  const double h = m.bar.length / static_cast<double>(elements_);
  const bool creeps = 2.0 * m.bar.viscosity * m.bar.viscosity >= h * h * m.bar.density * m.bar.modulus;
  if (!quiet && !creeps && mass_ == Mass::fourth_order && pattern_->inertia.skew.empty()) return std::nullopt;
  return one;
}

std::optional<OwnMember> Members::of(const Case& run) const {
  const auto pattern = pattern_of(run);
  if (!pattern || run.end != end_ || pattern->size() != pattern_->size() || pattern->contact != pattern_->contact ||
      pattern->sign != pattern_->sign || pattern->stretch != pattern_->stretch ||
      pattern->inertia.diagonal != pattern_->inertia.diagonal || pattern->massless != pattern_->massless)
    return std::nullopt;
  const Scene& scene = run.scene;
  const BarSystem system(scene, run.mesh(), mass_);
  OwnMember one;
  Member& m = one.member;
  take_numbers(run, m);
  for (const bool right : {false, true}) {
    m.wall[right] = system.unknowns().wall(right).value_or(0.0);
    if ((m.stiffness[right] > 0.0 || m.dashpot[right] > 0.0 || m.mass[right] > 0.0) && !pattern_->mounted[right])
      return std::nullopt;
  }
  auto load = load_parts(run, mass_, system.size());
  if (!load) return std::nullopt;
  if (!load->empty()) {
    one.load = std::make_unique<std::vector<LoadPart>>(std::move(*load));
    m.load = one.load.get();
  }
  one.data = std::make_unique<State>(system.initial_state());
  m.data = m.start = one.data.get();
  if (JumpFilter filter(system); filter.acts()) {
    one.start = std::make_unique<State>(*one.data);
    PenalisedSystem settled(system, Penalty{0.0, 0.0});
    settled.load().begin_leg(0.0, run.end);
    settle_high_modes(filter, settled, 0.0, run.end, *one.start);
    m.start = one.start.get();
  }
  return one;
}

}  // namespace viscobar::bars
