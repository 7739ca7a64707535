#include "viscobar/discretisation/mass.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "discretisation/varying_section.hpp"

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
     "inertia and load of each row exact to fourth order, inside h (1, 10, 1)/12, at the ends h (7, 6, -1)/24 where "
     "elements are of equal length; three at least"},
};
static_assert(std::size(words) == std::size(all_masses));

}  // namespace

std::string_view name(Mass mass) { return words[static_cast<std::size_t>(mass)].name; }

std::string_view meaning(Mass mass) { return words[static_cast<std::size_t>(mass)].meaning; }

namespace {

// int A phi^2 of either function of an element and int A phi phi' of both.
struct ElementMass {
  double before, across, after;
};

// The P1 functions of a mesh.
struct Functions {
  const Mesh& mesh;
  const VaryingSection* section;

  double size(std::size_t element) const { return section ? section->stretch(element) : mesh.element(element); }
  // int A xi^k dx
  std::array<double, 4> moments(std::size_t element) const {
    if (section) return section->moments(element);
    const double h = mesh.element(element);
    return {h, h / 2, h / 3, h / 4};
  }
  ElementMass mass(std::size_t element, bool lumped = false) const {
    const auto m = moments(element);
    if (lumped) return {m[0] - m[1], 0.0, m[1]};
    return {m[0] - 2 * m[1] + m[2], section ? m[1] - m[2] : m[0] / 6, m[2]};
  }
};

// int A phi_i sigma^k dx, k = 0, 1, 2, sigma being the way in s from node i towards larger x.
std::array<double, 3> moments_of_node(const Functions& functions, std::size_t i) {
  std::array<double, 3> sum{};
  if (i < functions.mesh.elements) {
    const double b = functions.size(i);
    const auto m = functions.moments(i);
    sum = {m[0] - m[1], b * (m[1] - m[2]), b * b * (m[2] - m[3])};
  }
  if (i > 0) {
    const double a = functions.size(i - 1);
    const auto m = functions.moments(i - 1);
    sum[0] += m[1], sum[1] += a * (m[2] - m[1]), sum[2] += a * a * (m[3] - 2 * m[2] + m[1]);
  }
  return sum;
}

// Row i of int A phi_i a dx, a the parabola through nodes i - 1, i, i + 1, and at an end through the three next to it:
// exact for parabolas in s.
BandedMatrix parabolic(const Functions& functions) {
  const std::size_t n = functions.mesh.nodes(), last = n - 1;
  BandedMatrix matrix;
  matrix.diagonal.resize(n);
  matrix.off_diagonal.resize(n - 1);
  matrix.skew.assign(n - 1, 0.0);
  std::vector<double> above(n - 1), below(n - 1);
  for (std::size_t i = 1; i < last; ++i) {
    const auto [p0, p1, p2] = moments_of_node(functions, i);
    const double a = functions.size(i - 1), b = functions.size(i);
    below[i - 1] = (p2 - b * p1) / (a * (a + b));
    above[i] = (p2 + a * p1) / (b * (a + b));
    matrix.diagonal[i] = p0 - below[i - 1] - above[i];
  }
  above.front() = below.front(), below.back() = above.back();  // symmetric there: one-sided rows hold the difference
  for (std::size_t i = 0; i < last; ++i) {
    matrix.off_diagonal[i] = 0.5 * (above[i] + below[i]);
    matrix.skew[i] = 0.5 * (above[i] - below[i]);
  }
  const auto end_row = [&](bool right) -> std::array<double, 3> {
    auto [p0, p1, p2] = moments_of_node(functions, right ? last : 0);
    if (right) p1 = -p1;
    const double a = functions.size(right ? last - 1 : 0), b = functions.size(right ? last - 2 : 1);
    const double beside = right ? matrix.off_diagonal.back() : matrix.off_diagonal.front();
    (right ? matrix.diagonal.back() : matrix.diagonal.front()) = p0 - beside;
    const double first = (p1 * (a + b) - p2) / (a * b), second = (p2 - a * p1) / ((a + b) * b);
    return {beside - first - second, first - beside, second};
  };
  matrix.one_sided = {{0, false, end_row(false)}, {last, true, end_row(true)}};
  return matrix;
}

}  // namespace

BandedMatrix mass_matrix(const Mesh& mesh, Mass mass, const VaryingSection* section) {
  const bool alike = mesh.uniform() && !section;
  if (!alike && mass == Mass::paper)
    throw std::invalid_argument("mass \"paper\" has one weight h for all nodes: it needs elements of equal length");
  const double h = mesh.spacing();
  const std::size_t n = mesh.nodes();
  BandedMatrix matrix;
  if (mass == Mass::paper) {
    matrix.diagonal.assign(n, h);
    return matrix;
  }
  const Functions functions{mesh, section};
  if (mass == Mass::fourth_order) {
    if (mesh.elements < 3)
      throw std::invalid_argument("mass \"fourth_order\" needs at least 3 elements: its end rows reach three nodes");
    if (!alike) return parabolic(functions);
    matrix.diagonal.assign(n, 5 * h / 6);
    matrix.diagonal.front() = matrix.diagonal.back() = 5 * h / 12;
    matrix.off_diagonal.assign(n - 1, h / 12);
    const std::array<double, 3> slope = {-h / 8, h / 6, -h / 24};
    matrix.one_sided = {{0, false, slope}, {n - 1, true, slope}};
    return matrix;
  }
  matrix.diagonal.assign(n, 0.0);
  for (std::size_t j = 0; j < mesh.elements; ++j) {
    const auto [before, across, after] = functions.mass(j, mass == Mass::lumped);
    matrix.diagonal[j] += before;
    matrix.diagonal[j + 1] += after;
    if (mass != Mass::lumped) matrix.off_diagonal.push_back(across);
  }
  return matrix;
}

namespace {

// Replaces v_0 in the end element's energy by (1 + a) v_1 - a v_2, a the ratio of its size to the next one's.
void make_massless(const Functions& functions, BandedMatrix& matrix, std::size_t end, std::size_t next,
                   std::size_t inner) {
  const std::size_t element = std::min(end, next), beside = std::min(next, inner);
  const double a = functions.size(element) / functions.size(beside);
  const auto [before, across, after] = functions.mass(element);
  const double of_end = end < next ? before : after;
  matrix.diagonal[end] = matrix.off_diagonal[element] = 0.0;
  matrix.diagonal[next] += (1 + a) * ((1 + a) * of_end + 2 * across);
  matrix.off_diagonal[beside] -= a * ((1 + a) * of_end + across);
  matrix.diagonal[inner] += a * a * of_end;
}

}  // namespace

BandedMatrix inertia_matrix(const Mesh& mesh, Mass mass, bool left_contact, bool right_contact,
                            const VaryingSection* section) {
  BandedMatrix matrix = mass_matrix(mesh, mass, section);
  if (mass != Mass::redistributed || !(left_contact || right_contact)) return matrix;
  const std::size_t contacts = static_cast<std::size_t>(left_contact) + static_cast<std::size_t>(right_contact);
  if (mesh.elements < contacts + 1)
    throw std::invalid_argument("mass \"redistributed\" needs at least " + std::to_string(contacts + 1) +
                                " elements here: the mass of a contact node moves to the next two nodes");
  const std::size_t last = mesh.elements;
  const Functions functions{mesh, section};
  if (left_contact) make_massless(functions, matrix, 0, 1, 2);
  if (right_contact) make_massless(functions, matrix, last, last - 1, last - 2);
  return matrix;
}

}  // namespace viscobar
