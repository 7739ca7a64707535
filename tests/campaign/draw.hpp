#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <random>

namespace viscobar::campaign {

/// Numbers of scene `index` of the campaign `seed`. The distributions of the standard library differ from one to the
/// other; its engines do not.
class Draw {
 public:
  Draw(std::uint64_t seed, std::size_t index) : engine_(seed * 1'000'003 + index) { engine_.discard(16); }

  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  double decades(double low, double high) { return std::pow(10.0, between(std::log10(low), std::log10(high))); }
  double normal() {  // of the sum of twelve
    double sum = -6.0;
    for (int k = 0; k < 12; ++k) sum += between(0.0, 1.0);
    return sum;
  }
  bool chance(double p) { return between(0.0, 1.0) < p; }
  template <class T>
  T one_of(std::initializer_list<T> values) {
    return values.begin()[engine_() % values.size()];
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace viscobar::campaign
