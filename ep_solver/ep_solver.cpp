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
    : space_(space), period_(parameters.stimulus.period), control_(parameters),
      integrator_(integrator(parameters.integrator)), model_(make_ionic_model(parameters.ionic_model)),
      stimulus_(parameters.stimulus, space.points(), space.communicator()),
      problem_(space, D, parameters.tolerance, parameters.preconditioner), current_(space.make_vector(1)),
      solved_(current_), calcium_(space.n_owned_nodes()) {
  const CellState cell = model_->initial_state(parameters.initial_state);
  n_.v = space.make_vector(1);
  n_.v = cell.v;
  n_.v_before = n_.v;
  n_.ionic = model_->uniform_states(space.n_owned_nodes(), cell.states);
  n_.activation.assign(space.n_owned_nodes(), std::numeric_limits<double>::quiet_NaN());
  n_.repolarisation = n_.activation;
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
  declaration.scalar("ep_substeps", "1", [this] { return double(substeps_); });
  declaration.scalar(
      "activation_time", "s", [this] { return last_activation(); }, bus::Combine::max);
  const double n_nodes = dealii::Utilities::MPI::sum(double(space_.n_owned_nodes()), space_.communicator());
  declaration.scalar(
      "activated_share", "1", [this, n_nodes] { return n_activated() / n_nodes; }, bus::Combine::sum);
}

void EPSolver::solve_step(const bus::Step &step) {
  iterations_ = 0;
  beat_begin_ = period_ * std::floor(step.time / period_ - 1e-9);
  int n = control_.divide(step.size, n_.longest);
  double estimate;
  for (;;) {
    estimate = advance_by(n, step);
    const int finer = control_.refine(step.size, n, estimate);
    if (finer == n)
      break;
    n = finer;
  }
  substeps_ = n;
  np1_.longest = control_.longest_next(step.size / n, estimate);
  model_->get_calcium(space_.n_owned_nodes(), np1_.ionic, calcium_.data());
}

/// From the old state to the end of the step. Returns the largest error estimate of all substeps and ranks.
double EPSolver::advance_by(int n_substeps, const bus::Step &step) {
  const double dt = step.size / n_substeps;
  np1_.v = n_.v;
  np1_.v_before = n_.v_before;
  np1_.dt_before = n_.dt_before;
  np1_.activation = n_.activation;
  np1_.repolarisation = n_.repolarisation;
  if (step.time - step.size < beat_begin_ + 1e-9 * period_)
    for (auto *times : {&np1_.activation, &np1_.repolarisation})
      times->assign(times->size(), std::numeric_limits<double>::quiet_NaN());
  double estimate = 0;
  for (int k = 0; k < n_substeps; ++k)
    estimate =
        std::max(estimate, advance(step.time - (n_substeps - 1 - k) * dt, dt, k == 0 ? n_.ionic : np1_.ionic, np1_));
  return dealii::Utilities::MPI::max(estimate, space_.communicator());
}

/// One substep that ends at `end`. Returns this rank's error estimate.
double EPSolver::advance(double end, double dt, const std::vector<Lanes> &ionic_n, State &state) {
  const unsigned n_nodes = space_.n_owned_nodes();
  const bool in_the_middle = integrator_ == Integrator::exponential_midpoint;
  const double ahead = (in_the_middle ? 0.5 : 1) * dt / state.dt_before;
  solved_ = state.v_before;
  solved_.sadd(-ahead, 1 + ahead, state.v); // extrapolated
  double estimate;
  {
    const bus::Stopwatch::Section section(problem_.stopwatch, "ionic model");
    estimate = model_->step(integrator_, n_nodes, in_the_middle ? solved_.begin() : state.v.begin(), ionic_n.data(),
                            state.ionic.data(), dt, current_.begin());
  }
  current_ *= -1;
  stimulus_.add(end - dt, end, n_nodes, current_.begin());
  problem_.set_step(in_the_middle ? 0.5 * dt : dt);
  iterations_ += problem_.solve(state.v, current_, solved_).iterations;
  return std::max(estimate, finish_substep(end, dt, state));
}

/// Takes v^{n+1} from what was solved for. Returns how far the potential is from its extrapolation, over its scale.
double EPSolver::finish_substep(double end, double dt, State &state) {
  const bool in_the_middle = integrator_ == Integrator::exponential_midpoint;
  const double ratio = dt / state.dt_before;
  constexpr double scale = 0.1;          // [V], an action potential
  constexpr double repolarised = -70e-3; // [V], nine tenths of the way back
  double largest = 0;
  for (unsigned node = 0; node < space_.n_owned_nodes(); ++node) {
    double &v_before = state.v_before.local_element(node), &v = state.v.local_element(node);
    const double v_n = v, solved = solved_.local_element(node), v_np1 = in_the_middle ? 2 * solved - v_n : solved;
    largest = std::max(largest, std::abs(v_np1 - v_n - ratio * (v_n - v_before)));
    if (std::isnan(state.activation[node]) && v_n < 0 && v_np1 >= 0)
      state.activation[node] = end - dt * v_np1 / (v_np1 - v_n) - beat_begin_;
    if (!std::isnan(state.activation[node]) && v_n >= repolarised && v_np1 < repolarised) // the last time counts
      state.repolarisation[node] = end - dt * (v_np1 - repolarised) / (v_np1 - v_n) - beat_begin_;
    v_before = v_n;
    v = v_np1;
  }
  state.dt_before = dt;
  return largest / scale;
}

void EPSolver::commit_step(const bus::Step &step) {
  n_.v.swap(np1_.v);
  n_.v_before.swap(np1_.v_before);
  n_.dt_before = np1_.dt_before;
  n_.longest = np1_.longest;
  n_.ionic.swap(np1_.ionic);
  n_.activation.swap(np1_.activation);
  n_.repolarisation.swap(np1_.repolarisation);
  if (writer_ && output_.due(step.number, step.size))
    write(step.time);
}

void EPSolver::visit(io::State &state) {
  state.points("tissue", fem::owned_points(space_), space_.smallest_cell_size());
  state.field("potential", 1, n_.v.begin());
  state.field("potential_before", 1, n_.v_before.begin());
  state.number("substep", n_.dt_before);
  state.number("longest_substep", n_.longest);
  state.partial_field("activation_time", 1, n_.activation.data());
  state.partial_field("repolarisation_time", 1, n_.repolarisation.data());
  const unsigned n_kept = model_->n_kept();
  std::vector<double> ionic(space_.n_owned_nodes() * n_kept); // [node][what is kept]
  const auto in_blocks = [&](std::size_t k) -> double & {
    const std::size_t node = k / n_kept, block = node / fem::n_lanes;
    return reinterpret_cast<double *>(&n_.ionic[block * n_kept + k % n_kept])[node % fem::n_lanes];
  };
  for (std::size_t k = 0; k < ionic.size(); ++k)
    ionic[k] = in_blocks(k);
  state.field("ionic_states", n_kept, ionic.data());
  for (std::size_t k = 0; k < ionic.size(); ++k)
    in_blocks(k) = ionic[k];
}

void EPSolver::save_state(const std::string &folder, const bus::Step &) {
  io::save_state(space_.communicator(), folder + "/ep.h5", [&](io::State &state) { visit(state); });
}

void EPSolver::load_state(const std::string &folder, const bus::Step &step) {
  if (writer_)
    writer_->go_on_from(step.time);
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
  map.nodal("repolarisation_time", 1, n_.repolarisation.data());
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
