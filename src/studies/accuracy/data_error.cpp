#include "studies/accuracy/data_error.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

namespace viscobar::accuracy {

// A wave cos(k x) has places 0.14/k to 0.28/k apart, see FormulaDetail.
template <class Function, class Moves>
void DataError::add(const Function& f, const Places& places, Moves&& moves) {
  constexpr double in_a_wave = 0.2, rounding = 1e-13;
  constexpr std::size_t most = 10000;
  if (!places.breaks) return;
  std::size_t count = 0;
  for (auto at = places.breaks(0.0, length_); at && ++count < most;
       at = places.breaks(*at + rounding * length_, length_))
    breaks_.push_back(*at);
  // Places of about one distance are a wave each: its amplitude is that of all of them.
  constexpr double alike = 4.0;
  std::optional<double> last = places.detail(0.0, length_);
  double shortest = length_, stretch = 0.0, low = 0.0, high = 0.0;
  const auto end = [&] {
    if (stretch > 0.0) waves_.push_back({shortest, stretch, moves((high - low) / 2.0, in_a_wave / shortest)});
    shortest = length_;
    stretch = 0.0;
  };
  for (auto next = last; last; last = next) {
    next = places.detail(*last, length_);
    const double gap = next ? *next - *last : length_, value = f(*last);
    if (gap > alike * shortest || gap * alike < shortest) {
      end();
      low = high = value;
    }
    if (next && gap < length_ / 100.0) {
      shortest = std::min(shortest, gap);
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
  const Bar& bar = scene.bar;
  add(scene.displacement, scene.displacement_places, [](double amplitude, double) { return amplitude; });
  add(scene.velocity, scene.velocity_places, [&](double amplitude, double k) {
    const double elastic = 1.0 / (std::sqrt(bar.modulus / bar.density) * k);
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
  if (const auto* general = std::get_if<GeneralLoad>(&*scene.load)) fronts_ = static_cast<bool>(general->breaks_in_x);
}

bool DataError::at_nodes(std::size_t elements) const {
  const auto count = static_cast<double>(elements);
  return std::ranges::all_of(breaks_, [&](double at) {
    const double place = at / length_ * count;
    return std::abs(place - std::round(place)) <= 1e-9 * count;
  });
}

bool DataError::unseen(const Wave& wave, double elements) const { return wave.detail < length_ / elements / 4.0; }

bool DataError::sees(std::size_t elements) const {
  return std::ranges::none_of(waves_, [&](const Wave& wave) { return unseen(wave, static_cast<double>(elements)); });
}

std::size_t DataError::unit() const {
  constexpr std::size_t most = 128;  // a mesh that costs no more than the search for a smaller one
  if (fronts_) return 1;
  for (std::size_t elements = 1; elements <= most; ++elements)
    if (at_nodes(elements)) return elements;
  return 1;
}

double layer_error(const Case& run, double speed) {
  const Bar& bar = run.scene.bar;
  const double h = run.mesh().spacing(), a = effective_mass(run) == Mass::fourth_order ? 0.0039 : 0.019;
  const double elastic = std::sqrt(bar.density / bar.modulus);
  return a * speed * h * (bar.viscosity > 0.0 ? std::min(h * bar.density / bar.viscosity, elastic) : elastic);
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
  if (before > 0.0) found.effectivity *= found.error / before;
  return found;
}

}  // namespace viscobar::accuracy
