#include "dynamics/assembly/initial_state.hpp"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "dynamics/load/nodal_moments.hpp"
#include "dynamics/pieces.hpp"

namespace viscobar {

namespace {

std::vector<double> unknowns_of(std::span<const double> nodal, const BarSystem& system) {
  const auto part = system.unknowns().part(nodal);
  return {part.begin(), part.end()};
}

// Held nodes that the initial velocity does not leave at rest stop at once, and the rows beside them keep their share
// of the momentum: rho M (w - u_1) = 0 over the unknowns, u_1 of the held nodes included. Without it the error is
// O(h^2).
void stop_fixed_ends(const Scene& scene, const BarSystem& system, const BandedMatrix& whole,
                     std::vector<double>& velocity) {
  const Lift rate = system.frame().moving() ? system.frame().lift(0.0, 1) : Lift{};
  const std::vector<double>& coupling = whole.off_diagonal;
  std::vector<double> gained(system.size());
  if (system.unknowns().left_fixed()) gained.front() += coupling.front() * (scene.velocity(0.0) - rate.at(0.0));
  if (system.unknowns().right_fixed())
    gained.back() += coupling.back() * (scene.velocity(system.mesh().length) - rate.at(1.0));
  if (std::ranges::all_of(gained, [](double momentum) { return momentum == 0.0; })) return;
  system.inertia().accelerate(gained);
  for (std::size_t i = 0; i < system.size(); ++i) velocity[i] += gained[i];
}

// rho M w = int rho phi_i u_1 over the unknowns, held nodes at rest from the first moment on. A node without mass has
// the velocity to which its neighbours' extends, and they have its moment.
std::vector<double> start_from(std::vector<double> moments, const BarSystem& system, const BandedMatrix& whole) {
  const Elements& elements = system.elements();
  const Inertia& inertia = system.inertia();
  const Unknowns& unknowns = system.unknowns();
  if (const MovingFrame& moving = system.frame(); moving.moving()) {
    const Lift rate = moving.lift(0.0, 1);
    std::vector<double> frame(system.mesh().nodes()), product(frame);
    moving.add_lift(rate, frame);
    whole.multiply(frame, product);
    for (std::size_t j = 0; j < moments.size(); ++j) moments[j] -= product[j];
  }
  const std::size_t last = system.mesh().elements;
  const double left = elements.stretch(0) / elements.stretch(std::min<std::size_t>(1, last - 1));
  const double right = elements.stretch(last - 1) / elements.stretch(last < 2 ? 0 : last - 2);
  const bool left_massless = inertia.massive_begin() > 0, right_massless = inertia.massive_end() < system.size();
  const auto give = [&](std::size_t end, std::size_t next, std::size_t inner, double ratio) {
    moments[next] += (1.0 + ratio) * moments[end];
    moments[inner] -= ratio * moments[end];
  };
  if (left_massless) give(0, 1, 2, left);
  if (right_massless) give(last, last - 1, last - 2, right);
  std::vector<double>& w = moments;  // over all nodes
  inertia.accelerate(unknowns.part(std::span(w)));
  if (unknowns.left_fixed()) w.front() = 0.0;
  if (unknowns.right_fixed()) w.back() = 0.0;
  if (left_massless) w[0] = (1.0 + left) * w[1] - left * w[2];
  if (right_massless) w[last] = (1.0 + right) * w[last - 1] - right * w[last - 2];
  return unknowns_of(w, system);
}

}  // namespace

State initial_state(const Scene& scene, const BarSystem& system, const BandedMatrix& whole) {
  const Mesh& mesh = system.mesh();
  const std::vector<Piece>& pieces = system.elements().pieces();
  std::vector<double> displacement(mesh.nodes()), velocity(mesh.nodes());
  for (std::size_t p = pieces.size(); p-- > 0;)  // a node that two have is the left one's
    for (std::size_t j = 0; j < pieces[p].mesh.nodes(); ++j) {
      const Piece& piece = pieces[p];
      displacement[piece.first + j] = piece.displacement(piece.mesh.node(j));
      velocity[piece.first + j] = piece.velocity(piece.mesh.node(j));
    }
  const std::size_t n = system.size();
  State start{unknowns_of(displacement, system), unknowns_of(velocity, system)};
  if (const MovingFrame& frame = system.frame(); frame.moving()) {
    const Lift rate = frame.lift(0.0, 1);
    for (std::size_t i = 0; i < n; ++i) start.v[i] -= rate.at(frame.share(i));
  }
  if (auto moments = nodal_moments(system.elements(), system.mass(), "the initial velocity", scene.velocity,
                                   scene.velocity_places, Moments::of_velocity);
      !moments.empty())
    start.v = start_from(std::move(moments), system, whole);
  else if (system.mass() == Mass::fourth_order && n < mesh.nodes())
    stop_fixed_ends(scene, system, whole, start.v);
  return start;
}

}  // namespace viscobar
