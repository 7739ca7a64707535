#include "viscobar/discretisation/mass.hpp"

#include <array>
#include <stdexcept>

namespace viscobar {

namespace {

struct Words {
  std::string_view name, meaning;
};

constexpr Words words(Mass mass) {
  switch (mass) {
    case Mass::consistent: return {"consistent", "exact for linear elements, (h/6) [2 1; 1 2] per element"};
    case Mass::lumped: return {"lumped", "diagonal by the trapezoidal rule, h/2 at the ends"};
    case Mass::paper:
      return {"paper", "diagonal with weight h at the ends too, as the paper's finite difference scheme is printed"};
    case Mass::redistributed:
      return {"redistributed",
              "consistent, but nodes at an obstacle have no mass and cannot bounce; no span obstacle, not "
              "finite_difference, neither cvode nor odeint without viscosity"};
    case Mass::fourth_order:
      return {
          "fourth_order",
          "inertia and load of each row exact to fourth order, inside h (1, 10, 1)/12, at the ends h (7, 6, -1)/24; "
          "elements of equal length, three at least"};
  }
  return {};
}

}  // namespace

std::string_view name(Mass mass) { return words(mass).name; }

std::string_view meaning(Mass mass) { return words(mass).meaning; }

namespace {

SymmetricTridiagonal graded_mass_matrix(const Mesh& mesh, Mass mass) {
  if (mass == Mass::paper)
    throw std::invalid_argument("mass \"paper\" has one weight h for all nodes: it needs elements of equal length");
  if (mass == Mass::fourth_order)
    throw std::invalid_argument(
        "mass \"fourth_order\" has weights for elements of equal length; use \"consistent\" on a graded mesh");
  const bool lumped = mass == Mass::lumped;
  SymmetricTridiagonal matrix;
  matrix.diagonal.assign(mesh.nodes(), 0.0);
  for (std::size_t j = 0; j < mesh.elements; ++j) {
    const double h = mesh.element(j), share = lumped ? h / 2 : h / 3;
    matrix.diagonal[j] += share;
    matrix.diagonal[j + 1] += share;
    if (!lumped) matrix.off_diagonal.push_back(h / 6);
  }
  return matrix;
}

}  // namespace

SymmetricTridiagonal mass_matrix(const Mesh& mesh, Mass mass) {
  if (!mesh.uniform()) return graded_mass_matrix(mesh, mass);
  const double h = mesh.spacing();
  const std::size_t n = mesh.nodes();
  SymmetricTridiagonal matrix;
  if (mass == Mass::lumped || mass == Mass::paper) {
    matrix.diagonal.assign(n, h);
    if (mass == Mass::lumped) matrix.diagonal.front() = matrix.diagonal.back() = h / 2;
  } else if (mass == Mass::fourth_order) {
    if (mesh.elements < 3)
      throw std::invalid_argument("mass \"fourth_order\" needs at least 3 elements: its end rows reach three nodes");
    matrix.diagonal.assign(n, 5 * h / 6);
    matrix.diagonal.front() = matrix.diagonal.back() = 5 * h / 12;
    matrix.off_diagonal.assign(n - 1, h / 12);
    const std::array<double, 3> slope = {-h / 8, h / 6, -h / 24};
    matrix.end_rows = EndRows{slope, slope};
  } else {
    matrix.diagonal.assign(n, 2 * h / 3);
    matrix.diagonal.front() = matrix.diagonal.back() = h / 3;
    matrix.off_diagonal.assign(n - 1, h / 6);
  }
  return matrix;
}

namespace {

// Replaces the end element's energy (h/6)(v0^2 + v0 v1 + v1^2) by its value at v0 = (1 + a) v1 - a v2, a the ratio of
// its size to the next one's, which is (h/6)((3 + 3a + a^2) v1^2 - (3a + 2a^2) v1 v2 + a^2 v2^2); all entries below are
// those of twice that form.
void make_massless(double h, double beside, double& end, double& end_next, double& next, double& next_inner,
                   double& inner) {
  const double a = h / beside;
  end = end_next = 0.0;
  next += (3 + a * (3 + a)) * h / 3 - h / 3;
  next_inner -= a * (3 + 2 * a) * h / 6;
  inner += a * a * h / 3;
}

}  // namespace

SymmetricTridiagonal inertia_matrix(const Mesh& mesh, Mass mass, bool left_contact, bool right_contact) {
  SymmetricTridiagonal matrix = mass_matrix(mesh, mass);
  if (mass != Mass::redistributed || !(left_contact || right_contact)) return matrix;
  const std::size_t contacts = static_cast<std::size_t>(left_contact) + static_cast<std::size_t>(right_contact);
  if (mesh.elements < contacts + 1)
    throw std::invalid_argument("mass \"redistributed\" needs at least " + std::to_string(contacts + 1) +
                                " elements here: the mass of a contact node moves to the next two nodes");
  auto& d = matrix.diagonal;
  auto& o = matrix.off_diagonal;
  const std::size_t last = mesh.elements;
  if (left_contact) make_massless(mesh.element(0), mesh.element(1), d[0], o[0], d[1], o[1], d[2]);
  if (right_contact)
    make_massless(mesh.element(last - 1), mesh.element(last - 2), d[last], o[last - 1], d[last - 1], o[last - 2],
                  d[last - 2]);
  return matrix;
}

}  // namespace viscobar
