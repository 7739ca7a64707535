// Random fits that begin within a factor of ten of the truth: do they find it, or say that they did not? docs/fit.md.
//
//     cmake --build --preset release --target measure_fits
//     build/release/tests/measure_fits [FITS [SEED [FIRST [STARTS]]]]
//     build/release/tests/measure_fits FITS SEED FIRST reactions   # or velocities, forces: by eight times the elements
//     build/release/tests/measure_fits FITS SEED FIRST few         # samples or contact times; or bounces, to rest
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "sensitivity/random_fits.hpp"

int main(int argc, char** argv) {
  using namespace viscobar::random_fits;
  const auto argument = [&](int k, std::size_t otherwise) {
    return argc > k ? static_cast<std::size_t>(std::atoll(argv[k])) : otherwise;
  };
  const std::size_t fits = argument(1, 300), seed = argument(2, 1), first = argument(3, 0), starts = argument(4, 20);
  const std::string kind = argc > 4 ? argv[4] : "";
  const Data data = kind == "reactions"    ? Data::reactions
                    : kind == "velocities" ? Data::velocities
                    : kind == "forces"     ? Data::forces
                    : kind == "few"        ? Data::few
                    : kind == "bounces"    ? Data::bounces
                                           : Data::any;
  // An estimate farther than this from the truth is wrong: noise does so in 1 of 16,000.
  constexpr double far = 4.0;
  struct Counts {
    std::size_t fits = 0, found = 0, told = 0, silent = 0, alarmed = 0, wrong = 0, beyond_one = 0, beyond_two = 0;
  } of_noise, of_none;
  std::vector<std::size_t> runs;
  for (std::size_t index = first; index < first + fits; ++index) {
    const RandomFit one = random_fit(seed, index, data);
    const Judged judged = data == Data::any ? judge(one, starts) : distance(one);
    runs.push_back(judged.runs);
    Counts& count = one.noise > 0.0 ? of_noise : of_none;
    const bool wrong = judged.converged && judged.off > far;
    ++count.fits;
    count.found += judged.found;
    count.told += !judged.found && !judged.converged;
    count.silent += !judged.found && judged.converged;
    count.alarmed += judged.found && !judged.converged;
    count.wrong += wrong;
    count.beyond_one += judged.converged && judged.off > 1.0;
    count.beyond_two += judged.converged && judged.off > 2.0;
    if (!judged.found || !judged.converged || wrong || judged.runs > 300)
      fmt::print("{}: {}: {}, {}, S {:.3g} variances above, {:.3g} deviations from the truth, {} runs: {}\n", index,
                 one.words, judged.found ? "found" : "not found", judged.converged ? "converged" : "not converged",
                 judged.excess, judged.off, judged.runs, judged.told);
  }
  std::ranges::sort(runs);
  for (const auto& [words, count] : {std::pair("with noise", of_noise), std::pair("without", of_none)})
    fmt::print(
        "{} fits {}: {} found, {} not found and told, {} not found and not told; {} found and not relied on; of those "
        "relied on {} farther than {} deviations from the truth, {} than two, {} than one\n",
        count.fits, words, count.found, count.told, count.silent, count.alarmed, count.wrong, far, count.beyond_two,
        count.beyond_one);
  fmt::print("runs: median {}, 95 % {}, most {}\n", runs[runs.size() / 2], runs[runs.size() * 95 / 100], runs.back());
}
