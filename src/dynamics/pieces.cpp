#include "dynamics/pieces.hpp"

#include <algorithm>
#include <stdexcept>

namespace viscobar {

std::vector<SceneBar> scene_bars(const Scene& scene) {
  if (scene.chain.empty()) return {{0, 0.0, scene.bar, scene.section}};
  std::vector<SceneBar> bars;
  double begin = 0.0;
  for (std::size_t m = 0; m < scene.chain.size(); ++m) {
    const Member& member = scene.chain[m];
    if (!member.rigid()) bars.push_back({m, begin, member.bar, member.section});
    begin += member.bar.length;
  }
  return bars;
}

std::vector<Piece> pieces_of(const Scene& scene, const Mesh& mesh) {
  const auto section = [](const SpaceFunction& area, const Places& places, const Mesh& own) {
    return area ? std::make_shared<VaryingSection>(area, places.breaks, own) : nullptr;
  };
  if (scene.chain.empty())
    return {{mesh, 0, 0.0, scene.bar, 0.0, section(scene.section, scene.section_places, mesh), scene.displacement,
             scene.velocity}};
  if (!mesh.members || mesh.members->size() != scene.chain.size())
    throw std::invalid_argument("the mesh of several bars in line has the elements of each");
  std::vector<Piece> pieces;
  double begin = 0.0;
  for (std::size_t m = 0; m < scene.chain.size(); ++m) {
    const Member& member = scene.chain[m];
    const bool apart = m > 0 && scene.chain[m - 1].joint.kind != JointKind::bonded;
    const Mesh& own = (*mesh.members)[m];
    pieces.push_back({own, m == 0 ? 0 : pieces.back().last() + (apart ? 1 : 0), begin, member.bar, member.mass,
                      member.rigid() ? nullptr : section(member.section, member.section_places, own),
                      member.displacement, member.velocity});
    begin += member.bar.length;
  }
  if (pieces.back().last() != mesh.elements)
    throw std::invalid_argument("the mesh of several bars in line has the elements of each and one for each joint");
  return pieces;
}

const Piece& end_bar(const std::vector<Piece>& pieces, bool right) {
  const auto is_bar = [](const Piece& piece) { return !piece.rigid(); };
  return right ? *std::ranges::find_if(pieces.rbegin(), pieces.rend(), is_bar) : *std::ranges::find_if(pieces, is_bar);
}

Bar bar_at(const std::vector<Piece>& pieces, std::size_t node) {
  for (const Piece& piece : pieces)
    if (!piece.rigid() && piece.has(node))
      return whole_section(piece.bar, piece.area(std::min(node - piece.first, piece.mesh.elements - 1)));
  return {0.0, 0.0, 0.0, 0.0};
}

std::vector<Bar> element_bars(const Scene& scene, const Mesh& mesh) {
  std::vector<Bar> bars;
  if (scene.chain.empty()) return bars;
  bars.assign(mesh.elements, {0.0, 0.0, 0.0, 0.0});
  for (const Piece& piece : pieces_of(scene, mesh))
    for (std::size_t e = piece.first; e < piece.last(); ++e) bars[e] = piece.bar;
  return bars;
}

}  // namespace viscobar
