// Random fits that begin within a factor of ten of the truth: do they find it, or say that they did not? docs/fit.md.
//
//     cmake --build --preset release --target measure_fits && build/release/tests/measure_fits [FITS [SEED [FIRST]]]
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "sensitivity/random_fits.hpp"

int main(int argc, char** argv) {
  using namespace viscobar::random_fits;
  const auto argument = [&](int k, std::size_t otherwise) {
    return argc > k ? static_cast<std::size_t>(std::atoll(argv[k])) : otherwise;
  };
  const std::size_t fits = argument(1, 300), seed = argument(2, 1), first = argument(3, 0);
  std::size_t found = 0, told = 0, silent = 0, alarmed = 0;
  std::vector<std::size_t> runs;
  for (std::size_t index = first; index < first + fits; ++index) {
    const RandomFit one = random_fit(seed, index);
    const Judged judged = judge(one);
    runs.push_back(judged.runs);
    found += judged.found;
    told += !judged.found && !judged.converged;
    silent += !judged.found && judged.converged;
    alarmed += judged.found && !judged.converged;
    if (!judged.found || !judged.converged || judged.runs > 300)
      fmt::print("{}: {}: {}, {}, S {:.3g} variances above, {} runs\n", index, one.words,
                 judged.found ? "found" : "not found", judged.converged ? "converged" : "not converged", judged.excess,
                 judged.runs);
  }
  std::ranges::sort(runs);
  fmt::print("{} fits: {} found, {} not found and told, {} not found and not told; {} found and not relied on\n", fits,
             found, told, silent, alarmed);
  fmt::print("runs: median {}, 95 % {}, most {}\n", runs[runs.size() / 2], runs[runs.size() * 95 / 100], runs.back());
}
