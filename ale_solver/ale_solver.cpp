#include "ale_solver/ale_solver.h"

#include "common/base/failure.h"
#include "common/fem/owned_points.h"
#include "common/io/state_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace heartbus::ale {

ALESolver::ALESolver(const fem::LagrangeSpace &space, const Parameters &parameters)
    : space_(space), problem_(space, parameters), ale_displacement_(space.make_vector(3)), past_(3, ale_displacement_),
      mesh_motion_(3 * space.n_owned_nodes()) {
  const auto on = space.nodes_on("interface");
  for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
    if (on[node])
      interface_nodes_.push_back(node);
  displacement_.assign(3 * interface_nodes_.size(), std::numeric_limits<double>::quiet_NaN()); // until it comes
}

void ALESolver::declare(bus::Declaration &bus) {
  const double spacing = space_.smallest_cell_size();
  bus.point_set("cavity", fem::owned_points(space_), spacing);
  bus.point_set("interface", fem::owned_points(space_, interface_nodes_), spacing);
  bus.input("displacement", "interface", 3, "m", displacement_);
  bus.output("mesh_motion", "cavity", 3, "m", "n+1", mesh_motion_);
  bus.scalar("lifting_iterations", "1", [this] { return double(iterations_); });
  bus.scalar(
      "mesh_min_J", "1", [this] { return problem_.smallest_J(); }, bus::Combine::min);
}

/// First guess: the parabola through the last three motions.
void ALESolver::prepare_step(const bus::Step &) {
  if (has_history_)
    past_.extrapolate(ale_displacement_);
}

void ALESolver::commit_step(const bus::Step &) {
  if (std::exchange(has_history_, true))
    past_.push(ale_displacement_);
  else
    past_.fill(ale_displacement_);
}

/// A mesh that nobody moves would be at rest without a word.
void ALESolver::require_displacement() {
  const int missing =
      std::any_of(displacement_.begin(), displacement_.end(), [](double value) { return std::isnan(value); });
  if (!has_displacement_ && dealii::Utilities::MPI::max(missing, space_.communicator()))
    throw Failure(ExitCode::scene, "lifting needs 'displacement' of the interface, which nobody sends: let 'mech' take "
                                   "part, or play a recording in its place (program: replay)");
  has_displacement_ = true;
}

void ALESolver::solve_step(const bus::Step &) {
  require_displacement();
  for (std::size_t k = 0; k < displacement_.size(); ++k)
    ale_displacement_.local_element(3 * interface_nodes_[k / 3] + k % 3) = displacement_[k];
  iterations_ = problem_.lift(ale_displacement_);
  std::copy(ale_displacement_.begin(), ale_displacement_.begin() + mesh_motion_.size(), mesh_motion_.begin());
}

void ALESolver::visit(io::State &state) {
  state.points("cavity", fem::owned_points(space_), space_.smallest_cell_size());
  state.field("ale_displacement", 3, past_[0].begin());
  state.field("ale_displacement_nm1", 3, past_[1].begin());
  state.field("ale_displacement_nm2", 3, past_[2].begin());
}

void ALESolver::save_state(const std::string &folder, const bus::Step &) {
  io::save_state(space_.communicator(), folder + "/ale.h5", [&](io::State &state) { visit(state); });
}

void ALESolver::load_state(const std::string &folder, const bus::Step &) {
  io::load_state(space_.communicator(), folder + "/ale.h5", [&](io::State &state) { visit(state); });
  has_history_ = true;
  ale_displacement_ = past_[0];
  std::copy(ale_displacement_.begin(), ale_displacement_.begin() + mesh_motion_.size(), mesh_motion_.begin());
}

} // namespace heartbus::ale
