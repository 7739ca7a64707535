#pragma once

#include <cstddef>
#include <random>
#include <vector>

namespace viscobar {

/// n numbers from [-scale, scale].
inline std::vector<double> random_vector(std::size_t n, std::mt19937& random, double scale = 1.0) {
  std::uniform_real_distribution<double> uniform(-scale, scale);
  std::vector<double> x(n);
  for (double& value : x) value = uniform(random);
  return x;
}

/// The same ones for the same seed.
inline std::vector<double> random_vector(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  return random_vector(n, random);
}

}  // namespace viscobar
