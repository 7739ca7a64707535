#include "dynamics/load/nodal_load.hpp"

#include <algorithm>
#include <span>
#include <utility>

#include "dynamics/assembly/assembled.hpp"
#include "dynamics/load/nodal_moments.hpp"

namespace viscobar {

namespace {

NodalLoad distributed_load(const Load& given, const BarSystem& system) {
  const Mesh& mesh = system.mesh();
  BandedMatrix mass = assembled(system.elements().pieces(), [&](const Piece& piece) {
    return mass_matrix(piece.mesh, system.mass(), piece.section.get());
  });
  const auto weighted = [&](const SpaceFunction& profile, const Places& places) {
    std::vector<double> values(mesh.nodes()),
        product = nodal_moments(system.elements(), system.mass(), "the load", profile, places, Moments::of_load);
    if (product.empty()) {
      product = values;
      for (std::size_t j = 0; j < values.size(); ++j) values[j] = profile(mesh.node(j));
      mass.multiply(values, product);
    }
    const std::array held = {product.front(), product.back()};
    const auto part = system.unknowns().part(std::span<const double>(product));
    return NodalLoad::Steady{{part.begin(), part.end()}, held};
  };
  NodalLoad load;
  if (const auto* steady = std::get_if<SteadyLoad>(&given))
    load.distributed = weighted(steady->profile, steady->places);
  const auto separable = [&](const SeparableLoad& one) {
    NodalLoad::Steady profile = weighted(one.profile, one.places);
    return NodalLoad::Separable{std::move(profile.weighted), profile.held, one.history, one.breaks, {}};
  };
  if (const auto* one = std::get_if<SeparableLoad>(&given)) {
    NodalLoad::Separable sum = separable(*one);
    if (one->plus) sum.plus = std::make_shared<NodalLoad::Separable>(separable(*one->plus));
    load.distributed = std::move(sum);
  }
  if (const auto* general = std::get_if<GeneralLoad>(&given))
    load.distributed = NodalLoad::General{general->density, general->breaks, general->breaks_at, general->breaks_in_x,
                                          std::move(mass)};
  return load;
}

// Forces that are always the same become part of a load that is.
void take_forces(NodalLoad& load, const BarSystem& system) {
  const auto& inputs = system.inputs();
  load.end_forces = true;
  load.varying_forces =
      (load.distributed && !std::holds_alternative<NodalLoad::Steady>(*load.distributed)) ||
      std::ranges::any_of(inputs, [](const EndInput& one) { return one.force && !one.force->steady; });
  if (load.varying_forces) return;
  if (!load.distributed) load.distributed = NodalLoad::Steady{std::vector<double>(system.size(), 0.0)};
  std::vector<double>& weighted = std::get<NodalLoad::Steady>(*load.distributed).weighted;
  for (const bool right : {false, true})
    if (inputs[right].force && !system.unknowns().wall(right))
      weighted[system.unknowns().end(right)] += inputs[right].force->value(0.0);
}

}  // namespace

std::shared_ptr<const NodalLoad> nodal_load(const Scene& scene, const BarSystem& system) {
  const bool forces = scene.left_input.force || scene.right_input.force;
  if (!scene.load && !forces) return nullptr;
  NodalLoad load = scene.load ? distributed_load(*scene.load, system) : NodalLoad{};
  if (forces) take_forces(load, system);
  return std::make_shared<const NodalLoad>(std::move(load));
}

}  // namespace viscobar
