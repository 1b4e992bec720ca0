#include "ep_solver/ep_solver.h"

#include "common/fem/output_mesh.h"
#include "common/fem/owned_points.h"
#include "common/io/state_file.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace heartbus::ep {

using fem::Lanes;
using fem::Vector;

EPSolver::EPSolver(const fem::LagrangeSpace &space, const std::vector<fem::Mat3<Lanes>> &D,
                   const Parameters &parameters)
    : space_(space), period_(parameters.stimulus.period), substeps_(parameters.substeps),
      model_(make_ionic_model(parameters.ionic_model)), stimulus_(parameters.stimulus, space.points()),
      problem_(space, D, parameters.tolerance, parameters.preconditioner), current_(space.make_vector(1)),
      calcium_(space.n_owned_nodes()) {
  const CellState cell = model_->initial_state(parameters.initial_state);
  n_.v = space.make_vector(1);
  n_.v = cell.v;
  n_.v_before = n_.v;
  n_.ionic = model_->uniform_states(space.n_owned_nodes(), cell.states);
  n_.activation.assign(space.n_owned_nodes(), std::numeric_limits<double>::quiet_NaN());
  np1_ = n_;
  model_->get_calcium(space.n_owned_nodes(), n_.ionic, calcium_.data());
}

void EPSolver::write_fields(const std::string &folder, const OutputParameters &output) {
  folder_ = folder;
  output_ = output;
  if (output_.every > 0)
    writer_ = std::make_unique<io::FieldWriter>(space_.communicator(), folder, "ep", fem::output_mesh(space_));
}

void EPSolver::prepare_step(const bus::Step &step) {
  if (writer_ && step.number == 1)
    write(0);
}

void EPSolver::declare(bus::Declaration &declaration) {
  declaration.point_set("tissue", fem::owned_points(space_), space_.smallest_cell_size());
  declaration.output("calcium", "tissue", 1, "uM", "n+1", calcium_);
  declaration.scalar("ep_iterations", "1", [this] { return double(iterations_); });
  declaration.scalar(
      "activation_time", "s", [this] { return last_activation(); }, bus::Combine::max);
  const double n_nodes = dealii::Utilities::MPI::sum(double(space_.n_owned_nodes()), space_.communicator());
  declaration.scalar(
      "activated_share", "1", [this, n_nodes] { return n_activated() / n_nodes; }, bus::Combine::sum);
}

void EPSolver::solve_step(const bus::Step &step) {
  const double dt = step.size / substeps_;
  problem_.set_step(dt);
  iterations_ = 0;
  np1_.v = n_.v;
  np1_.v_before = n_.v_before;
  np1_.activation = n_.activation;
  beat_begin_ = period_ * std::floor(step.time / period_ - 1e-9);
  if (step.time - step.size < beat_begin_ + 1e-9 * period_)
    np1_.activation.assign(np1_.activation.size(), std::numeric_limits<double>::quiet_NaN());
  for (int k = 0; k < substeps_; ++k)
    advance(step.time - (substeps_ - 1 - k) * dt, dt, k == 0 ? n_.ionic : np1_.ionic, np1_);
  model_->get_calcium(space_.n_owned_nodes(), np1_.ionic, calcium_.data());
}

/// One (sub)step that ends at `time`.
void EPSolver::advance(double time, double dt, const std::vector<Lanes> &ionic_n, State &state) {
  const unsigned n_nodes = space_.n_owned_nodes();
  {
    const bus::Stopwatch::Section section(problem_.stopwatch, "ionic model");
    model_->step(n_nodes, state.v.begin(), ionic_n.data(), state.ionic.data(), dt, current_.begin());
  }
  current_ *= -1;
  stimulus_.add(time, n_nodes, current_.begin());

  state.v_before.sadd(-1, 2, state.v); // extrapolated: 2 v^n - v^{n-1}
  state.v_before.swap(state.v);        // now v^n, and a guess of v^{n+1}
  iterations_ += problem_.solve(state.v_before, current_, state.v).iterations;

  for (unsigned node = 0; node < n_nodes; ++node) {
    const double v_n = state.v_before.local_element(node), v_np1 = state.v.local_element(node);
    if (std::isnan(state.activation[node]) && v_n < 0 && v_np1 >= 0)
      state.activation[node] = time - dt * v_np1 / (v_np1 - v_n) - beat_begin_;
  }
}

void EPSolver::commit_step(const bus::Step &step) {
  n_.v.swap(np1_.v);
  n_.v_before.swap(np1_.v_before);
  n_.ionic.swap(np1_.ionic);
  n_.activation.swap(np1_.activation);
  if (writer_ && output_.due(step.number, step.size))
    write(step.time);
}

void EPSolver::visit(io::State &state) {
  state.points("tissue", fem::owned_points(space_), space_.smallest_cell_size());
  state.field("potential", 1, n_.v.begin());
  state.field("potential_before", 1, n_.v_before.begin());
  state.field("activation_time", 1, n_.activation.data());
  const unsigned n_states = model_->n_states();
  std::vector<double> ionic(space_.n_owned_nodes() * n_states); // [node][state]
  const auto in_blocks = [&](std::size_t k) -> double & {
    const std::size_t node = k / n_states, block = node / fem::n_lanes;
    return reinterpret_cast<double *>(&n_.ionic[block * n_states + k % n_states])[node % fem::n_lanes];
  };
  for (std::size_t k = 0; k < ionic.size(); ++k)
    ionic[k] = in_blocks(k);
  state.field("ionic_states", n_states, ionic.data());
  for (std::size_t k = 0; k < ionic.size(); ++k)
    in_blocks(k) = ionic[k];
}

void EPSolver::save_state(const std::string &folder, const bus::Step &) {
  io::save_state(space_.communicator(), folder + "/ep.h5", [&](io::State &state) { visit(state); });
}

void EPSolver::load_state(const std::string &folder, const bus::Step &) {
  io::load_state(space_.communicator(), folder + "/ep.h5", [&](io::State &state) { visit(state); });
  np1_ = n_;
  model_->get_calcium(space_.n_owned_nodes(), n_.ionic, calcium_.data());
}

void EPSolver::finish() {
  if (folder_.empty())
    return;
  io::FieldWriter map(space_.communicator(), folder_, "activation", fem::output_mesh(space_));
  map.begin(0);
  map.nodal("activation_time", 1, n_.activation.data());
  map.end();
}

void EPSolver::write(double time) {
  writer_->begin(time);
  writer_->nodal("potential", 1, n_.v.begin());
  writer_->nodal("calcium", 1, calcium_.data());
  writer_->end();
}

double EPSolver::n_activated() const {
  return std::count_if(n_.activation.begin(), n_.activation.end(), [](double time) { return std::isfinite(time); });
}

double EPSolver::last_activation() const {
  constexpr double never = std::numeric_limits<double>::infinity();
  double latest = 0;
  for (const double time : n_.activation)
    latest = std::max(latest, std::isnan(time) ? never : time);
  return latest == never ? std::numeric_limits<double>::quiet_NaN() : latest;
}

} // namespace heartbus::ep
