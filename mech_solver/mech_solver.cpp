#include "mech_solver/mech_solver.h"

#include "common/fem/output_mesh.h"
#include "common/fem/owned_faces.h"
#include "common/fem/owned_points.h"
#include "common/io/state_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <spdlog/fmt/fmt.h>

namespace heartbus::mech {

MechSolver::MechSolver(const fem::LagrangeSpace &space, const fem::Fibres &fibres, const Parameters &parameters,
                       std::shared_ptr<spdlog::logger> log)
    : space_(space), fibres_(fibres), parameters_(parameters), log_(log), problem_(space, fibres, parameters),
      force_generation_(parameters.active, space.n_owned_nodes()), d_(space.make_vector(3)),
      stretch_(space.make_vector(1)), interface_(space, 3), calcium_(space.n_owned_nodes(), -1.0),
      probe_(interface_, log), response_(problem_) {
  if (space.has_label("interface"))
    cavity_.emplace_back(space, "interface");
  find_probes();
  for (auto *field : {&blood_force_, &displacement_, &wall_velocity_, &wall_force_, &blood_force_n_})
    *field = interface_.values();
  for (const unsigned node : interface_.nodes())
    for (unsigned i = 0; i < 3; ++i)
      held_.push_back(problem_.constrained()[3 * node + i]);
  force_generation_.tension(0, problem_.tension.begin());
}

/// Of each probe the node, on the rank that owns it.
void MechSolver::find_probes() {
  for (const auto &[name, point] : parameters_.probes) {
    int nearest = -1;
    double distance = std::numeric_limits<double>::max();
    for (unsigned node = 0; node < space_.n_owned_nodes(); ++node) {
      const geometry::Point3 &x = space_.points()[node];
      if (const double d = std::hypot(x[0] - point[0], x[1] - point[1], x[2] - point[2]); d < distance) {
        distance = d;
        nearest = node;
      }
    }
    const double smallest = dealii::Utilities::MPI::min(distance, space_.communicator());
    if (smallest > 1e-3 * space_.smallest_cell_size())
      throw Failure(ExitCode::scene,
                    fmt::format("mechanics.probes.{}: the wall has no node at ({:g}, {:g}, {:g}) mm; the "
                                "nearest is {:.4g} mm away",
                                name, 1e3 * point[0], 1e3 * point[1], 1e3 * point[2], 1e3 * smallest));
    probes_[name] = distance == smallest ? nearest : -1;
  }
}

void MechSolver::write_fields(const std::string &folder, const OutputParameters &output) {
  output_ = output;
  if (output.every > 0)
    writer_ = std::make_unique<io::FieldWriter>(space_.communicator(), folder, "mech", fem::output_mesh(space_));
}

void MechSolver::couple(const interface::WallSettings &settings) {
  using Load = interface::WallSettings::Load;
  is_alone_ = settings.load == Load::initial_pressure;
  if (settings.load == Load::cavity_pressure)
    filling_.emplace(problem_);
  if (settings.load != Load::blood_force || !space_.has_label("interface"))
    return;
  linear_wall_.emplace(problem_);
  probe_.couple(*linear_wall_, settings.alternation);
  correction_.emplace(interface_);
}

void MechSolver::declare(bus::Declaration &bus) {
  const double spacing = space_.smallest_cell_size();
  bus.point_set("tissue", fem::owned_points(space_), spacing);
  bus.input("calcium", "tissue", 1, "uM", calcium_);
  if (space_.has_label("interface")) {
    bus.point_set("interface", interface_.points(), spacing);
    fem::declare_faces(space_, "interface", bus);
    if (!is_alone_)
      bus.input("blood_force", "interface", 3, "N", blood_force_);
    bus.output("held", "interface", 3, "1", "always", held_);
    bus.output("displacement", "interface", 3, "m", "n+1", displacement_);
    bus.output("wall_velocity", "interface", 3, "m/s", "n+1", wall_velocity_);
    bus.output("wall_force", "interface", 3, "N", "n+1", wall_force_);
  }
  probe_.declare(bus);
  if (correction_)
    correction_->declare(bus, [this](const bus::Step &step) { correct(step); });
  if (filling_) {
    filling_->declare(bus);
    bus.task("press", [this](const bus::Step &step) { press(step); });
  }
  bus.task("inflate", [this](const bus::Step &) { inflate(); });
  bus.scalar("newton_iterations", "1", [this] { return double(statistics_.iterations); });
  bus.scalar("solid_iterations", "1", [this] { return double(statistics_.linear_iterations); });
  bus.scalar(
      "min_J", "1", [this] { return problem_.smallest_J(); }, bus::Combine::min);
  bus.scalar(
      "peak_tension", "Pa", [this] { return peak_tension(); }, bus::Combine::max);
  declare_shares(bus);
  declare_probes(bus);
}

void MechSolver::declare_probes(bus::Declaration &bus) {
  if (is_alone_ && !cavity_.empty())
    bus.scalar(
        "cavity_volume", "m^3", [this] { return own_cavity_volume_; }, bus::Combine::sum);
  for (const auto &[name, at] : probes_)
    for (unsigned i = 0; i < 3; ++i)
      bus.scalar(
          name + "_" + "xyz"[i], "m", [this, node = at, i] { return node < 0 ? 0. : d_.local_element(3 * node + i); },
          bus::Combine::sum);
}

/// Behind flat lids across z.
void MechSolver::measure_cavity() {
  const fem::GhostValues ghosts(d_);
  for (const auto &surface : cavity_)
    own_cavity_volume_ = -surface.own_volume(d_); // its normals point inwards
}

/// Of the whole wall, each rank adds its own: the volume over that at rest, and of the nodes those whose sarcomere
/// length the force model clamps.
void MechSolver::declare_shares(bus::Declaration &bus) {
  const MPI_Comm communicator = space_.communicator();
  const double n_nodes = dealii::Utilities::MPI::sum(double(space_.n_owned_nodes()), communicator),
               volume_at_rest = dealii::Utilities::MPI::sum(problem_.own_volume_at_rest(), communicator);
  bus.scalar(
      "wall_volume", "1", [this, volume_at_rest] { return problem_.own_volume() / volume_at_rest; }, bus::Combine::sum);
  bus.scalar(
      "clamped_share", "1", [this, n_nodes] { return force_generation_.n_clamped() / n_nodes; }, bus::Combine::sum);
}

void MechSolver::inflate() {
  const fem::Vector tension_at_rest = problem_.tension;
  equilibrate(parameters_.inflation_steps, [&](double share) {
    problem_.interface_pressure = share * parameters_.initial_pressure;
    problem_.load_share = share;
    problem_.tension.equ(share, tension_at_rest);
  });
  if (!is_alone_)
    problem_.interface_pressure = 0; // from now on the blood's force holds it
  problem_.past.fill(d_);

  fem::Vector forces = space_.make_vector(3);
  problem_.solid_forces(d_, forces);
  interface_.get(forces, wall_force_);
  if (filling_) { // which holds it in place of nodal forces
    problem_.interface_pressure = parameters_.initial_pressure;
    filling_->begin(parameters_.initial_pressure, d_);
  } else if (!is_alone_)
    blood_force_n_ = blood_force_ = wall_force_;
  interface_.get(d_, displacement_);
  wall_velocity_.assign(wall_velocity_.size(), 0.0);
  measure_cavity();
  log_->info("inflated to {} Pa in {} load steps: {} Newton iterations, smallest J {:.3f}",
             parameters_.initial_pressure, parameters_.inflation_steps, statistics_.iterations,
             dealii::Utilities::MPI::min(problem_.smallest_J(), space_.communicator()));
  if (writer_)
    write(0);
}

/// Another program's calcium may not have been looked at before it was sent.
void MechSolver::refuse_calcium_that_is_not_finite() const {
  for (unsigned node = 0; node < calcium_.size(); ++node)
    if (!std::isfinite(calcium_[node])) {
      const geometry::Point3 &x = space_.points()[node];
      throw Failure(ExitCode::not_finite, fmt::format("field 'calcium' has come as {} at point ({:g}, {:g}, {:g})",
                                                      calcium_[node], x[0], x[1], x[2]));
    }
}

void MechSolver::prepare_step(const bus::Step &step) {
  refuse_calcium_that_is_not_finite();
  {
    const bus::Stopwatch::Section section(problem_.stopwatch, "stretch");
    problem_.fibre_stretch(problem_.past[0], stretch_);
  }
  {
    const bus::Stopwatch::Section section(problem_.stopwatch, "force model");
    force_generation_.advance(step.size, calcium_.data(), stretch_.begin());
    force_generation_.tension(step.time, problem_.tension.begin());
  }

  fem::Vector velocity(problem_.past[0]);
  velocity -= problem_.past[1];
  interface_.get(velocity, wall_velocity_, 1 / step.size);
  wall_force_ = blood_force_n_;
  if (parameters_.active_increment) {
    const bus::Stopwatch::Section section(problem_.stopwatch, "datum");
    fem::Vector change = space_.make_vector(1), forces = space_.make_vector(3);
    force_generation_.old_tension(step.time - step.size, change.begin());
    change.sadd(-1.0, 1.0, problem_.tension);
    problem_.active_forces(problem_.past[0], change, forces);
    std::vector<double> increment(wall_force_.size());
    interface_.get(forces, increment);
    for (std::size_t k = 0; k < increment.size(); ++k)
      wall_force_[k] += increment[k];
  }
}

void MechSolver::solve_step(const bus::Step &step) {
  interface_.set(blood_force_, problem_.load);
  if (filling_)
    problem_.interface_pressure = filling_->guess();
  begin_solve(step);
  if (parameters_.inertia)
    statistics_ = problem_.solve_dynamic(step.size, d_);
  else
    find_equilibrium(step);
  end_solve(step, statistics_);
  if (filling_)
    filling_->respond(d_);
}

void MechSolver::find_equilibrium(const bus::Step &step) {
  fem::Vector before = space_.make_vector(1);
  force_generation_.old_tension(step.time - step.size, before.begin());
  const fem::Vector after = problem_.tension;
  equilibrate(1, [&](double share) {
    problem_.time = step.time - (1 - share) * step.size;
    problem_.tension.equ(share, after);
    problem_.tension.add(1 - share, before);
  });
}

void MechSolver::equilibrate(int steps, const std::function<void(double share)> &load) {
  constexpr double shortest = 1. / 1024;
  fem::Vector reached(d_);
  statistics_ = {};
  for (double share = 0, size = 1. / steps; share < 1;) {
    const double next = share + size > 1 - 1e-9 ? 1 : share + size;
    load(next);
    try {
      const auto statistics = problem_.solve_static(d_);
      statistics_.iterations += statistics.iterations;
      statistics_.linear_iterations += statistics.linear_iterations;
      fem::copy_owned(d_, reached);
      share = next;
    } catch (const Failure &failure) {
      const bool too_far = failure.code() == ExitCode::not_converged || failure.code() == ExitCode::not_finite;
      if (!too_far || size < shortest)
        throw;
      fem::copy_owned(reached, d_);
      size /= 2;
    }
  }
}

fem::Vector &MechSolver::begin_solve(const bus::Step &step) {
  problem_.time = step.time;
  choose_start(step);
  return d_;
}

void MechSolver::end_solve(const bus::Step &step, const fem::NewtonStatistics &statistics) {
  statistics_ = statistics;
  iterate_extrapolation_.record(step.iteration, d_);
  show_motion(step.size);
  measure_cavity();
}

void MechSolver::show_motion(double dt) {
  fem::Vector velocity(d_);
  velocity -= problem_.past[0];
  interface_.get(velocity, wall_velocity_, 1 / dt);
  interface_.get(d_, displacement_);
  wall_force_ = blood_force_;
}

void MechSolver::correct(const bus::Step &step) {
  fem::Vector b = correction_->unit_force();
  fem::zero_constrained(b, problem_.constrained());
  const fem::Vector &w = response_.to(b, d_);
  const double pressure = correction_->find(b, w, wall_velocity_, step.size);
  d_.add(pressure, w);
  iterate_extrapolation_.record(1, d_); // the next step starts from what will be before this
  std::vector<double> force(interface_.values());
  interface_.get(b, force, pressure);
  for (std::size_t k = 0; k < blood_force_.size(); ++k)
    blood_force_[k] += force[k];
  show_motion(step.size);
}

void MechSolver::press(const bus::Step &step) {
  filling_->press(d_);
  iterate_extrapolation_.record(1, d_); // the next step starts from what will be before this
  show_motion(step.size);
}

void MechSolver::refresh() {
  problem_.forget_tangent();
  iterate_extrapolation_.forget();
}

/// Newton starts from the last iterate, or from the cubic through the last four displacements, and what iterates moved
/// in the steps before; it goes back to d^n when that would invert a cell.
void MechSolver::choose_start(const bus::Step &step) {
  if (step.iteration == 0 && parameters_.inertia)
    problem_.past.extrapolate(d_);
  else if (step.iteration == 0)
    fem::copy_owned(problem_.past[0], d_);
  if (parameters_.inertia)
    iterate_extrapolation_.predict(step.iteration, d_);
}

void MechSolver::commit_step(const bus::Step &step) {
  problem_.past.push(d_);
  iterate_extrapolation_.commit();
  force_generation_.commit();
  if (filling_)
    filling_->commit();
  blood_force_n_ = blood_force_;
  if (writer_ && output_.due(step.number, step.size))
    write(step.time);
}

void MechSolver::visit(io::State &state, const bus::Step &step) {
  const double spacing = space_.smallest_cell_size();
  state.points("tissue", fem::owned_points(space_), spacing);
  fem::TimeHistory &past = problem_.past;
  state.field("displacement", 3, past[0].begin());
  state.field("displacement_nm1", 3, past[1].begin());
  state.field("displacement_nm2", 3, past[2].begin());
  state.field("displacement_nm3", 3, past[3].begin());
  force_generation_.visit(state);
  if (space_.has_label("interface")) {
    state.points("interface", interface_.points(), spacing);
    state.field("blood_force", 3, blood_force_n_.data());
  }
  if (filling_)
    filling_->visit(state);
  double step_size = step.size;
  state.number("step_size", step_size);
  if (step_size != step.size) { // the velocity is to stay
    past[1].sadd(step.size / step_size, 1 - step.size / step_size, past[0]);
    past.straighten();
  }
  probe_.visit(state, step_size == step.size);
}

void MechSolver::save_state(const std::string &folder, const bus::Step &step) {
  io::save_state(space_.communicator(), folder + "/mech.h5", [&](io::State &state) { visit(state, step); });
}

void MechSolver::load_state(const std::string &folder, const bus::Step &step) {
  io::load_state(space_.communicator(), folder + "/mech.h5", [&](io::State &state) { visit(state, step); });
  if (writer_)
    writer_->go_on_from(step.time);
  force_generation_.tension(step.time, problem_.tension.begin());
  problem_.time = step.time;
  problem_.interface_pressure = is_alone_ ? parameters_.initial_pressure : 0;
  d_ = problem_.past[0];
  measure_cavity();
  if (filling_)
    filling_->load(d_);
  blood_force_ = wall_force_ = blood_force_n_;
  fem::Vector velocity(d_);
  velocity -= problem_.past[1];
  interface_.get(velocity, wall_velocity_, 1 / step.size);
  interface_.get(d_, displacement_);
}

double MechSolver::peak_tension() const {
  const auto &tension = problem_.tension;
  return std::accumulate(tension.begin(), tension.begin() + space_.n_owned_nodes(), 0., // a rank may have no node
                         [](double a, double b) { return std::max(a, b); });
}

void MechSolver::write(double time) {
  problem_.fibre_stretch(d_, stretch_);
  writer_->begin(time);
  writer_->nodal("displacement", "m", 3, d_.begin());
  writer_->nodal("active_tension", "Pa", 1, problem_.tension.begin());
  writer_->nodal("fibre_stretch", "1", 1, stretch_.begin());
  writer_->nodal("fibres", "1", 3, fibres_.nodal_fibres().data());
  writer_->end();
}

} // namespace heartbus::mech
