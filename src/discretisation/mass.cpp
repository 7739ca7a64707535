#include "viscobar/discretisation/mass.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace viscobar {

namespace {

struct Words {
  std::string_view name, meaning;
};

// In the order of the enumeration.
constexpr Words words[] = {
    {"consistent", "exact for linear elements, (h/6) [2 1; 1 2] per element"},
    {"lumped", "diagonal by the trapezoidal rule, h/2 at the ends"},
    {"paper", "diagonal with weight h at the ends too, as the paper's finite difference scheme is printed"},
    {"redistributed",
     "consistent, but nodes at an obstacle have no mass and cannot bounce; no span obstacle, not finite_difference, "
     "neither cvode nor odeint without viscosity"},
    {"fourth_order",
     "inertia and load of each row exact to fourth order, inside h (1, 10, 1)/12, at the ends h (7, 6, -1)/24; "
     "elements of equal length, three at least"},
};
static_assert(std::size(words) == std::size(all_masses));

}  // namespace

std::string_view name(Mass mass) { return words[static_cast<std::size_t>(mass)].name; }

std::string_view meaning(Mass mass) { return words[static_cast<std::size_t>(mass)].meaning; }

SymmetricTridiagonal mass_matrix(const Mesh& mesh, Mass mass) {
  if (!mesh.uniform() && mass == Mass::paper)
    throw std::invalid_argument("mass \"paper\" has one weight h for all nodes: it needs elements of equal length");
  if (!mesh.uniform() && mass == Mass::fourth_order)
    throw std::invalid_argument(
        "mass \"fourth_order\" has weights for elements of equal length; use \"consistent\" on a graded mesh");
  const double h = mesh.spacing();
  const std::size_t n = mesh.nodes();
  SymmetricTridiagonal matrix;
  if (mass == Mass::paper) {
    matrix.diagonal.assign(n, h);
    return matrix;
  }
  if (mass == Mass::fourth_order) {
    if (mesh.elements < 3)
      throw std::invalid_argument("mass \"fourth_order\" needs at least 3 elements: its end rows reach three nodes");
    matrix.diagonal.assign(n, 5 * h / 6);
    matrix.diagonal.front() = matrix.diagonal.back() = 5 * h / 12;
    matrix.off_diagonal.assign(n - 1, h / 12);
    const std::array<double, 3> slope = {-h / 8, h / 6, -h / 24};
    matrix.end_rows = EndRows{slope, slope};
    return matrix;
  }
  matrix.diagonal.assign(n, 0.0);
  for (std::size_t j = 0; j < mesh.elements; ++j) {
    const double size = mesh.element(j), share = mass == Mass::lumped ? size / 2 : size / 3;
    matrix.diagonal[j] += share;
    matrix.diagonal[j + 1] += share;
    if (mass != Mass::lumped) matrix.off_diagonal.push_back(size / 6);
  }
  return matrix;
}

namespace {

// Replaces the end element's energy (h/6)(v0^2 + v0 v1 + v1^2) by its value at v0 = (1 + a) v1 - a v2, a the ratio of
// its size to the next one's, which is (h/6)((3 + 3a + a^2) v1^2 - (3a + 2a^2) v1 v2 + a^2 v2^2); all entries below are
// those of twice that form.
void make_massless(const Mesh& mesh, SymmetricTridiagonal& matrix, std::size_t end, std::size_t next,
                   std::size_t inner) {
  const std::size_t element = std::min(end, next), beside = std::min(next, inner);
  const double h = mesh.element(element), a = h / mesh.element(beside);
  matrix.diagonal[end] = matrix.off_diagonal[element] = 0.0;
  matrix.diagonal[next] += (3 + a * (3 + a)) * h / 3 - h / 3;
  matrix.off_diagonal[beside] -= a * (3 + 2 * a) * h / 6;
  matrix.diagonal[inner] += a * a * h / 3;
}

}  // namespace

SymmetricTridiagonal inertia_matrix(const Mesh& mesh, Mass mass, bool left_contact, bool right_contact) {
  SymmetricTridiagonal matrix = mass_matrix(mesh, mass);
  if (mass != Mass::redistributed || !(left_contact || right_contact)) return matrix;
  const std::size_t contacts = static_cast<std::size_t>(left_contact) + static_cast<std::size_t>(right_contact);
  if (mesh.elements < contacts + 1)
    throw std::invalid_argument("mass \"redistributed\" needs at least " + std::to_string(contacts + 1) +
                                " elements here: the mass of a contact node moves to the next two nodes");
  const std::size_t last = mesh.elements;
  if (left_contact) make_massless(mesh, matrix, 0, 1, 2);
  if (right_contact) make_massless(mesh, matrix, last, last - 1, last - 2);
  return matrix;
}

}  // namespace viscobar
