#include "hard/catalogue.hpp"

#include <algorithm>
#include <iterator>

namespace viscobar::hard {

std::vector<HardScene> catalogue() {
  std::vector<HardScene> all;
  for (const auto& group : {parameter_scenes(), contact_scenes(), load_scenes(), span_scenes()})
    std::ranges::copy(group, std::back_inserter(all));
  return all;
}

}  // namespace viscobar::hard
