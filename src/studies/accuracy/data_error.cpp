#include "studies/accuracy/data_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <variant>

#include "dynamics/pieces.hpp"
#include "scene/times.hpp"

namespace viscobar::accuracy {

namespace {

constexpr double in_two_elements = 10.0;  // places of detail that a wave has in at most that, see FormulaDetail
constexpr double rounding = 1e-13;        // of a length or a time: a break is told again within one of it

}  // namespace

void DataError::add(const auto& f, const Places& places, auto&& moves) {
  constexpr std::size_t most = 10000;
  if (!places.breaks) return;
  std::size_t count = 0;
  for (auto at = places.breaks(0.0, length_); at && ++count < most;
       at = places.breaks(*at + rounding * length_, length_))
    breaks_.push_back(*at);
  add_waves(f, places.detail, moves, waves_);
}

// A wave cos(k x) has places 0.14/k to 0.28/k apart, see FormulaDetail.
void DataError::add_waves(const auto& f, const auto& detail, auto&& moves, std::vector<Wave>& waves) {
  constexpr double in_a_wave = 0.2;
  // Places of about one distance are a wave each: its amplitude is that of all of them.
  constexpr double alike = 4.0;
  // Where halves lead to a jump that travels there are three at most of one distance: moments know of it.
  constexpr double of_a_jump = 8.0;
  std::optional<double> last = detail(0.0, length_);
  double shortest = length_, longest = 0.0, stretch = 0.0, low = 0.0, high = 0.0;
  const auto end = [&] {
    if (stretch > of_a_jump * shortest)
      waves.push_back({shortest, stretch, moves((high - low) / 2.0, in_a_wave / shortest)});
    shortest = length_;
    longest = stretch = 0.0;
  };
  for (auto next = last; last; last = next) {
    next = detail(*last, length_);
    const double gap = next ? *next - *last : length_, value = f(*last);
    if (gap > alike * shortest || gap * alike < longest) {
      end();
      low = high = value;
    }
    if (next && gap < length_ / 100.0) {
      shortest = std::min(shortest, gap), longest = std::max(longest, gap);
      stretch += gap;
    }
    low = std::min(low, value);
    high = std::max(high, value);
  }
  end();
}

DataError::DataError(const Case& run, bool displacements)
    : length_(run.scene.bar.length), displacements_(displacements) {
  const Scene scene = run.scene;  // functions of its own
  if (!scene.chain.empty()) chain_ = run;
  const Bar& bar = scene.bar;
  add(scene.displacement, scene.displacement_places, [](double amplitude, double) { return amplitude; });
  add(scene.velocity, scene.velocity_places, [&](double amplitude, double k) {
    const double elastic = 1.0 / (bar.wave_speed() * k);
    return amplitude * (bar.viscosity > 0.0 ? std::min(elastic, bar.density / (bar.viscosity * k * k)) : elastic);
  });
  const auto of_load = [&](double factor) {
    return [&bar, factor](double amplitude, double k) { return factor * amplitude / (bar.modulus * k * k); };
  };
  if (!scene.load) return;
  if (const auto* steady = std::get_if<SteadyLoad>(&*scene.load)) add(steady->profile, steady->places, of_load(1.0));
  if (const auto* separable = std::get_if<SeparableLoad>(&*scene.load)) {
    constexpr int samples = 64;
    double largest = 0.0;
    for (int i = 0; i <= samples; ++i) largest = std::max(largest, std::abs(separable->history(run.end * i / samples)));
    add(separable->profile, separable->places, of_load(largest));
  }
  const auto* general = std::get_if<GeneralLoad>(&*scene.load);
  if (!general) return;
  fronts_ = static_cast<bool>(general->breaks_in_x);
  nodal_ = !fronts_;
  if (general->detail_in_x) add_general(*general, run);
}

// A mesh that has not the waves of nodal values has others in their place, whose mean pushes the whole bar.
void DataError::add_general(const GeneralLoad& load, const Case& run) {
  const Bar& bar = run.scene.bar;
  const bool held = std::holds_alternative<Fixed>(run.scene.left) || std::holds_alternative<Fixed>(run.scene.right);
  const double pushed = run.end * run.end / (2.0 * bar.density), bent = bar.length * bar.length / bar.modulus;
  const double moved = held ? std::min(pushed, bent) : pushed;
  constexpr std::size_t most = 11;
  std::vector<double> times = {0.21 * run.end, 0.52 * run.end, 0.83 * run.end};
  if (load.breaks) {
    double last = 0.0;
    const double until = run.end + rounding_of_times(0.0, run.end);  // as runs ask: breaks are looked for once
    for (auto at = load.breaks(0.0, until); at && times.size() < most;
         at = load.breaks(*at + rounding * run.end, until)) {
      times.push_back(last + (*at - last) / 2.0);
      last = *at;
    }
  }
  for (const double t : times) {
    std::vector<Wave> waves;
    add_waves([&](double x) { return load.density(x, t); },
              [&](double after, double until) { return load.detail_in_x(t, after, until); },
              [&](double amplitude, double) { return moved * amplitude; }, waves);
    if (!waves.empty()) at_times_.push_back(std::move(waves));
  }
}

bool DataError::at_nodes(std::size_t elements) const {
  const auto count = static_cast<double>(elements);
  if (chain_) {
    Case run = *chain_;
    run.elements = elements;
    const Mesh mesh = run.mesh();
    return std::ranges::all_of(breaks_, [&](double at) {
      return std::ranges::any_of(*mesh.given, [&](double x) { return std::abs(at - x * length_) <= 1e-9 * length_; });
    });
  }
  return std::ranges::all_of(breaks_, [&](double at) {
    const double place = at / length_ * count;
    return std::abs(place - std::round(place)) <= 1e-9 * count;
  });
}

bool DataError::unseen(const Wave& wave, double elements) const { return wave.detail < length_ / elements / 4.0; }

bool DataError::aliased(const Wave& wave, double elements) const {
  return wave.detail < length_ / elements / in_two_elements;
}

bool DataError::sees(std::size_t elements) const {
  return elements >= least() &&
         std::ranges::none_of(waves_, [&](const Wave& wave) { return unseen(wave, static_cast<double>(elements)); });
}

std::size_t DataError::least() const {
  double detail = length_;
  for (const std::vector<Wave>& waves : at_times_)
    for (const Wave& wave : waves) detail = std::min(detail, wave.detail);
  return static_cast<std::size_t>(std::ceil(length_ / (in_two_elements * detail)));
}

std::size_t DataError::unit() const {
  constexpr std::size_t most = 128;  // a mesh that costs no more than the search for a smaller one
  if (fronts_) return 1;
  // In a chain those meshes that have the same multiple of elements in each bar.
  std::size_t step = 1;
  if (chain_) {
    std::size_t divisor = 0, sum = 0;
    for (const Mesh& own : chain_->bar_meshes) divisor = std::gcd(divisor, own.elements), sum += own.elements;
    if (sum / divisor <= most) step = sum / divisor;
  }
  for (std::size_t elements = step; elements <= most; elements += step)
    if (at_nodes(elements)) return elements;
  return step;
}

double layer_error(const Case& run, double speed) {
  const double a = resolve(run).mass == Mass::fourth_order ? 0.0039 : 0.019;
  double longest = 0.0;
  for (const Piece& piece : pieces_of(run.scene, run.mesh())) {
    if (piece.rigid()) continue;
    const Bar& bar = piece.bar;
    const double h = piece.mesh.spacing(), elastic = h * bar.slowness();
    longest = std::max(longest, bar.viscosity > 0.0 ? std::min(h * h * bar.density / bar.viscosity, elastic) : elastic);
  }
  return a * speed * longest;
}

SpaceError DataError::of(SpaceError found, std::span<const MeshStep> ladder) const {
  if (ladder.empty()) return found;
  const MeshStep& last = ladder.back();
  const auto coarse = static_cast<double>(last.coarse), fine = static_cast<double>(last.fine);
  const double before = found.error;
  if (fronts_ || !at_nodes(last.coarse)) {
    found.error = std::max(found.error, last.distance / (fine / coarse - 1.0));
    // Two meshes may be wrong alike by chance. The one before tells, by half of what the power 3 of moments gains.
    if (ladder.size() > 1) {
      const MeshStep& earlier = ladder[ladder.size() - 2];
      const double finer = fine / static_cast<double>(earlier.fine);
      found.error = std::max(found.error, earlier.distance / (finer * finer));
    }
    found.trusted.reset();
  }
  for (const Wave& wave : waves_)
    if (displacements_ && unseen(wave, fine)) found.error += wave.error * std::min(1.0, wave.stretch / length_ * fine);
  double most = 0.0;
  for (const std::vector<Wave>& waves : at_times_) {
    double error = 0.0;
    for (const Wave& wave : waves)
      if (aliased(wave, fine)) error += wave.error * std::min(1.0, std::max(wave.stretch / length_, 1.0 / fine));
    most = std::max(most, error);
  }
  found.error += displacements_ || most == 0.0 ? most : std::numeric_limits<double>::infinity();
  if (before > 0.0) found.effectivity *= found.error / before;
  return found;
}

}  // namespace viscobar::accuracy
