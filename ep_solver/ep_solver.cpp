#include "ep_solver/ep_solver.h"

#include "common/fem/owned_points.h"
#include "common/io/state_file.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace heartbus::ep {

using fem::Vector;
using fem::VectorizedDouble;

namespace {

constexpr double round_off = 1e-6; // of times, over a step

} // namespace

void EPSolver::State::swap(State &other) {
  std::swap(begin, other.begin);
  std::swap(end, other.end);
  v.swap(other.v);
  v_before.swap(other.v_before);
  current.swap(other.current);
  std::swap(dt_before, other.dt_before);
  std::swap(longest, other.longest);
  ionic.swap(other.ionic);
  calcium_begin.swap(other.calcium_begin);
  curvature.swap(other.curvature);
  activation.swap(other.activation);
  repolarisation.swap(other.repolarisation);
}

double EPSolver::State::share(double time) const {
  return time < end - round_off * (end - begin) ? (time - begin) / (end - begin) : 1;
}

EPSolver::EPSolver(const fem::LagrangeSpace &space, const std::vector<fem::Mat3<VectorizedDouble>> &D,
                   const Parameters &parameters)
    : space_(space), period_(parameters.stimulus.period), control_(parameters),
      integrator_(integrator(parameters.integrator)), model_(make_ionic_model(parameters.ionic_model)),
      cells_(*model_, integrator_, space.n_owned_nodes()),
      stimulus_(parameters.stimulus, space.points(), space.communicator()),
      problem_(space, D, parameters.tolerance, parameters.preconditioner), current_(space.make_vector(1)),
      solved_(current_), is_fast_(space.n_owned_nodes()), calcium_(space.n_owned_nodes()), output_(space) {
  const CellState cell = model_->initial_state(parameters.initial_state);
  n_.v = space.make_vector(1);
  n_.v = cell.v;
  n_.v_before = n_.v;
  n_.current = space.make_vector(1);
  n_.ionic = model_->uniform_states(space.n_owned_nodes(), cell.states);
  n_.calcium_begin.resize(space.n_owned_nodes());
  n_.curvature.resize(space.n_owned_nodes());
  n_.activation.assign(space.n_owned_nodes(), std::numeric_limits<double>::quiet_NaN());
  n_.repolarisation = n_.activation;
  np1_ = n_;
  model_->get_calcium(space.n_owned_nodes(), n_.ionic, calcium_.data());
}

void EPSolver::prepare_step(const bus::Step &step) {
  if (output_.writes_start(step))
    write(0);
}

void EPSolver::declare(bus::Declaration &declaration) {
  declaration.point_set("tissue", fem::owned_points(space_), space_.smallest_cell_size());
  declaration.output("calcium", "tissue", 1, "uM", "n+1", calcium_);
  declaration.scalar("ep_iterations", "1", [this] { return double(iterations_); });
  declaration.scalar("ep_substeps", "1", [this] { return double(substeps_); });
  declare_activation(declaration, space_, n_.activation, now_);
}

void EPSolver::solve_step(const bus::Step &step) {
  iterations_ = substeps_ = 0;
  ahead_ = n_.end >= step.time - round_off * step.size;
  if (!ahead_)
    advance_to(step);
  set_calcium(ahead_ ? n_ : np1_, step.time);
}

/// A step of electrophysiology, to the end of this step of the coupling or beyond it, but not beyond the end of a beat.
void EPSolver::advance_to(const bus::Step &step) {
  beat_begin_ = period_ * std::floor(step.time / period_ - 1e-9);
  const double rest = step.time - n_.end, room = beat_begin_ + period_ - n_.end;
  const double size = rest > (1 - round_off) * step.size ? step.size : rest; // without noise: it has a matrix
  Division division = control_.divide(size, n_.longest, room);
  np1_.curvature = n_.curvature;
  std::fill(is_fast_.begin(), is_fast_.end(), false);
  for (;;) {
    const double length = division.steps * size;
    begin_advance(step.time + (division.steps - 1) * size); // not n_.end + length, whose rounding adds up
    const Estimate estimate = advance(division, length);
    const Division finer = control_.refine(size, division, estimate.of_all);
    const bool same = finer.steps == division.steps && finer.substeps == division.substeps;
    if (same && (division.substeps == 1 || !control_.is_too_coarse(estimate.of_slow))) {
      substeps_ = division.substeps;
      np1_.longest = control_.longest_next(division.length(size), estimate.of_all);
      return;
    }
    division = finer;
  }
}

/// The old state, for a step that ends at `end`.
void EPSolver::begin_advance(double end) {
  np1_.begin = n_.end;
  np1_.end = end;
  np1_.v = n_.v;
  np1_.v_before = n_.v_before;
  np1_.dt_before = n_.dt_before;
  np1_.current = n_.current;
  model_->get_calcium(space_.n_owned_nodes(), n_.ionic, np1_.calcium_begin.data());
  np1_.activation = n_.activation;
  np1_.repolarisation = n_.repolarisation;
  if (np1_.begin < beat_begin_ + 1e-9 * period_)
    for (auto *times : {&np1_.activation, &np1_.repolarisation})
      times->assign(times->size(), std::numeric_limits<double>::quiet_NaN());
}

/// What was fast in an attempt before stays so.
EPSolver::Estimate EPSolver::advance(Division division, double length) {
  const double dt = length / division.substeps;
  for (unsigned node = 0; node < is_fast_.size(); ++node)
    is_fast_[node] = division.substeps > 1 && (is_fast_[node] || control_.is_fast(np1_.curvature[node], length));
  std::fill(np1_.curvature.begin(), np1_.curvature.end(), 0);
  {
    const bus::Stopwatch::Section section(problem_.stopwatch, "ionic model");
    cells_.begin_step(n_.ionic, extrapolate(length), length, is_fast_);
  }
  for (int k = 1; k <= division.substeps; ++k)
    take_substep(np1_.end - (division.substeps - k) * dt, dt);
  cells_.end_step(np1_.ionic);
  return estimate(division, length);
}

EPSolver::Estimate EPSolver::estimate(Division division, double length) {
  const double dt = length / division.substeps;
  double largest = 0, largest_slow = 0;
  for (unsigned node = 0; node < is_fast_.size(); ++node) {
    double &curvature = np1_.curvature[node];
    curvature = std::max(curvature, cells_.curvature()[node]);
    largest = std::max(largest, curvature);
    if (!is_fast_[node])
      largest_slow = std::max(largest_slow, curvature);
  }
  std::vector<double> estimates{largest * dt * dt, largest_slow * length * length};
  dealii::Utilities::MPI::max(estimates, space_.communicator(), estimates);
  return {estimates[0], estimates[1]};
}

/// Sets solved_ to the potential that the integrator asks for, of a step of this length.
const double *EPSolver::extrapolate(double length) {
  const double ahead = implicit_share() * length / np1_.dt_before;
  solved_ = np1_.v_before;
  solved_.sadd(-ahead, 1 + ahead, np1_.v);
  return integrator_ == Integrator::exponential_midpoint ? solved_.begin() : np1_.v.begin();
}

void EPSolver::take_substep(double end, double dt) {
  const double *v = extrapolate(dt);
  {
    const bus::Stopwatch::Section section(problem_.stopwatch, "ionic model");
    cells_.substep(v, dt, current_.begin());
  }
  current_ *= -1;
  stimulus_.add(end - dt, end, space_.n_owned_nodes(), current_.begin());
  const double to_middle = implicit_share() * dt;
  solved_.add(to_middle, current_, -to_middle, np1_.current); // the guess knows the change of the current
  np1_.current = current_;
  problem_.set_step(to_middle);
  iterations_ += problem_.solve(np1_.v, current_, solved_).iterations;
  finish_substep(end, dt);
}

/// Takes v^{n+1} from what was solved for.
void EPSolver::finish_substep(double end, double dt) {
  const bool in_the_middle = integrator_ == Integrator::exponential_midpoint;
  const double ratio = dt / np1_.dt_before, square = 0.5 * dt * (dt + np1_.dt_before);
  constexpr double scale = 0.1;          // [V], an action potential
  constexpr double repolarised = -70e-3; // [V], nine tenths of the way back
  for (unsigned node = 0; node < space_.n_owned_nodes(); ++node) {
    double &v_before = np1_.v_before.local_element(node), &v = np1_.v.local_element(node);
    const double v_n = v, solved = solved_.local_element(node), v_np1 = in_the_middle ? 2 * solved - v_n : solved;
    double &activation = np1_.activation[node], &curvature = np1_.curvature[node];
    curvature = std::max(curvature, std::abs(v_np1 - v_n - ratio * (v_n - v_before)) / (scale * square));
    if (std::isnan(activation) && v_n < 0 && v_np1 >= 0)
      activation = end - dt * v_np1 / (v_np1 - v_n) - beat_begin_;
    if (!std::isnan(activation) && v_n >= repolarised && v_np1 < repolarised) // the last time counts
      np1_.repolarisation[node] = end - dt * (v_np1 - repolarised) / (v_np1 - v_n) - beat_begin_;
    v_before = v_n;
    v = v_np1;
  }
  np1_.dt_before = dt;
}

void EPSolver::set_calcium(const State &state, double time) {
  model_->get_calcium(space_.n_owned_nodes(), state.ionic, calcium_.data());
  const double share = state.share(time);
  for (unsigned node = 0; share < 1 && node < calcium_.size(); ++node)
    calcium_[node] = share * calcium_[node] + (1 - share) * state.calcium_begin[node];
}

void EPSolver::commit_step(const bus::Step &step) {
  if (!ahead_)
    n_.swap(np1_);
  now_ = step.time - beat_begin_;
  if (output_.is_due(step))
    write(step.time);
}

void EPSolver::visit(io::State &state) {
  state.points("tissue", fem::owned_points(space_), space_.smallest_cell_size());
  state.field("potential", 1, n_.v.begin());
  state.field("potential_nm1", 1, n_.v_before.begin());
  state.field("current", 1, n_.current.begin());
  state.number("begin", n_.begin);
  state.number("end", n_.end);
  state.field("calcium_begin", 1, n_.calcium_begin.data());
  state.field("curvature", 1, n_.curvature.data());
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
  output_.go_on_from(step.time);
  io::load_state(space_.communicator(), folder + "/ep.h5", [&](io::State &state) { visit(state); });
  np1_ = n_;
  beat_begin_ = period_ * std::floor(step.time / period_ - 1e-9);
  now_ = step.time - beat_begin_;
  set_calcium(n_, step.time);
}

void EPSolver::finish() { output_.write_maps(n_.activation.data(), n_.repolarisation.data()); }

void EPSolver::write(double time) {
  const double share = n_.share(time); // below 1 in a step without substeps only, which began with v_before
  solved_ = n_.v_before;
  solved_.sadd(1 - share, share, n_.v);
  output_.write(time, solved_.begin(), calcium_.data());
}

} // namespace heartbus::ep
