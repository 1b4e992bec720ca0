#include "fluid_solver/fluid_solver.h"

#include "common/base/failure.h"
#include "common/fem/output_mesh.h"
#include "common/fem/owned_faces.h"
#include "common/fem/owned_points.h"
#include "common/io/state_file.h"

#include <algorithm>
#include <cmath>
#include <spdlog/fmt/fmt.h>

namespace heartbus::fluid {

using fem::Vector;

FluidSolver::FluidSolver(const fem::LagrangeSpace &space, const Parameters &parameters,
                         const interface::BloodSettings &settings, double dt, std::shared_ptr<spdlog::logger> log)
    : space_(space), parameters_(parameters), log_(std::move(log)), problem_(space, parameters, settings.alpha, dt),
      dt_(dt), side_(space, settings, dt), mesh_motion_(3 * space.n_owned_nodes()),
      arterial_pressure_n_(parameters.valves.aortic_pressure) {
  if (space.has_label("mitral") != space.has_label("aortic"))
    throw Failure(ExitCode::scene,
                  "the fluid mesh has one valve; it needs both boundaries 'mitral' and 'aortic' or none");
  if (space.has_label("mitral")) {
    valves_.emplace(parameters.valves);
    mitral_ = &problem_.add_orifice("mitral", parameters.valves.mitral_pressure, 0);
    aortic_ = &problem_.add_orifice("aortic", parameters.valves.aortic_pressure, parameters.aortic_resistance);
  }
  if (!parameters.inlet.label.empty()) {
    inlet_ = &problem_.add_orifice(parameters.inlet.label, 0, 0);
    inlet_->open = true;
  }
  if (settings.condition == interface::BloodSettings::Condition::motion) {
    problem_.follow_motion();
    require_opening();
  }
}

/// Where all of the boundary moves as prescribed the blood has nowhere to go, and its pressure is anybody's guess.
void FluidSolver::require_opening() const {
  if (valves_ || inlet_)
    return;
  std::vector<std::string> moved = parameters_.no_slip;
  moved.insert(moved.end(), parameters_.slip.begin(), parameters_.slip.end());
  moved.push_back("interface");
  for (const auto &label : space_.labels())
    if (std::find(moved.begin(), moved.end(), label) == moved.end())
      return;
  throw Failure(ExitCode::scene, "fluid: the blood follows a prescribed motion, but all of its boundary is "
                                 "'interface', 'no_slip' or 'slip': it needs an opening");
}

void FluidSolver::write_fields(const std::string &folder, const OutputParameters &output) {
  output_ = output;
  if (output_.every > 0)
    writer_ = std::make_unique<io::FieldWriter>(space_.communicator(), folder, "fluid", fem::output_mesh(space_));
}

void FluidSolver::declare(bus::Declaration &bus) {
  const double spacing = space_.smallest_cell_size();
  bus.point_set("cavity", fem::owned_points(space_), spacing);
  bus.point_set("interface", side_.nodes().points(), spacing);
  fem::declare_faces(space_, "interface", bus);
  bus.input("mesh_motion", "cavity", 3, "m", mesh_motion_);
  side_.declare_data(bus);
  bus.task("hold", [this](const bus::Step &) { problem_.hold(side_.held()); });
  bus.task("start", [this](const bus::Step &) { start(); });
  if (!problem_.follows_motion())
    bus.task("budget", [this](const bus::Step &) { budget(side_.wall_velocity()); });
  bus.scalar("volume", "m^3", [this] { return problem_.volume(); });
  bus.scalar("mean_pressure", "Pa", [this] { return problem_.mean_pressure(); });
  if (valves_) {
    bus.scalar("mitral_flow", "m^3/s", [this] { return at_mitral_.flow; });
    bus.scalar("aortic_flow", "m^3/s", [this] { return at_aortic_.flow; });
    if (parameters_.arteries.compliance > 0)
      bus.scalar("arterial_pressure", "Pa", [this] { return arterial_pressure_n_; });
    bus.state("phase", Valves::phase_names(), [this] { return int(valves_->phase()); });
  }
  if (inlet_)
    bus.scalar("inlet_flow", "m^3/s", [this] { return -(inlet_->flux * problem_.state()); });
  bus.scalar("fluid_iterations", "1", [this] { return double(statistics_.iterations); });
  bus.scalar("fluid_residual", "1", [this] { return statistics_.residual; });
  bus.scalar("volume_defect", "m^3/s", [this] { return budget_.volume_defect; });
  bus.scalar("interface_power", "W", [this] { return budget_.power; });
  bus.scalar("disagreement", "Pa", [this] { return budget_.kinematic_jump; });
  if (!side_.is_robin())
    return;
  bus.scalar("alpha", "kg/(m^2 s)", [this] { return problem_.alpha(); });
  bus.scalar("coupling_iterations", "1", [this] { return double(coupling_iterations_); });
  bus.scalar("datum_residual", "1", [this] { return budget_.datum_residual; });
  bus.scalar("volume_loss", "1", [this] { return std::abs(budget_.volume_defect) * dt_ / problem_.volume(); });
  bus.scalar("isovolumetric", "1", [this] { return isovolumetric() ? 1. : 0.; });
  side_.declare_more(bus);
  declare_tasks(bus);
}

void FluidSolver::declare_tasks(bus::Declaration &bus) {
  bus.task("follow_limit", [this](const bus::Step &) { problem_.set_alpha(side_.followed_alpha()); });
  bus.task("begin_probe", [this](const bus::Step &) { begin_probe(); });
  bus.task("probe", [this](const bus::Step &) { probe(); });
  bus.task("accelerate", [this](const bus::Step &step) {
    problem_.accelerate(side_.wall_velocity(), side_.wall_force(), step.iteration);
  });
  bus.task("begin_correction",
           [this](const bus::Step &) { side_.give_for_correction(problem_.state(), problem_.unit_pressure_force()); });
  bus.task("correct", [this](const bus::Step &) { problem_.add_pressure(side_.pressure_correction()); });
}

Vector FluidSolver::ale_displacement() const {
  Vector ale_displacement = space_.make_vector(3);
  std::copy(mesh_motion_.begin(), mesh_motion_.end(), ale_displacement.begin());
  return ale_displacement;
}

void FluidSolver::start() {
  problem_.start(ale_displacement());
  if (valves_) {
    at_mitral_ = at(*mitral_, -1);
    at_aortic_ = at(*aortic_, 1);
  }
  log_->info("starts with {:.2f} mL of blood at {:.0f} Pa", 1e6 * problem_.volume(), problem_.mean_pressure());
  if (writer_)
    write(0);
}

void FluidSolver::begin_probe() {
  Parameters parameters = parameters_;
  parameters.initial_pressure = 0;
  parameters.tolerance = std::max(parameters.tolerance, 1e-4);
  blood_at_rest_ = std::make_unique<NavierStokesProblem>(space_, parameters, 0, dt_);
  blood_at_rest_->hold(side_.held());
  if (side_.settings.alternation == interface::Alternation::steps)
    blood_at_rest_->take_alternating_motion();
  if (valves_) {
    blood_at_rest_->add_orifice("mitral", 0, mitral_->resistance).open = mitral_->open;
    blood_at_rest_->add_orifice("aortic", 0, aortic_->resistance).open = aortic_->open;
  }
  blood_at_rest_->start(ale_displacement());
  blood_at_rest_->prepare(ale_displacement());
}

void FluidSolver::probe() {
  blood_at_rest_->solve(space_.make_vector(4), side_.probe_force());
  side_.give_probe_velocity(blood_at_rest_->state());
}

void FluidSolver::prepare_step(const bus::Step &step) {
  blood_at_rest_.reset();
  const Vector d = ale_displacement();
  if (valves_ && problem_.follows_motion())
    valves_->follow(problem_.volume_rate(d));
  else if (valves_)
    switch_valves(step.time - step.size);
  if (valves_) {
    show_valves();
    prepare_aorta();
  }
  if (inlet_)
    inlet_->pressure = parameters_.inlet.pressure.at(step.time);
  problem_.prepare(d);
}

/// Through the open valve sigma n = -(p + R Q) n with p = rest + slope Q: nothing is iterated.
void FluidSolver::prepare_aorta() {
  arteries_ = parameters_.arteries.answer(arterial_pressure_n_, dt_);
  aortic_->pressure = arteries_.rest;
  aortic_->resistance = parameters_.aortic_resistance + arteries_.slope;
}

void FluidSolver::switch_valves(double time) {
  valves_->set_aortic_pressure(arterial_pressure_n_);
  if (const auto reason = valves_->update(time, problem_.mean_pressure(), at_mitral_, at_aortic_))
    log_->info("t = {:.4f} s: {}; {}", time, *reason, Valves::phase_names()[valves_->phase()]);
}

/// `direction`: 1 if the valve lets blood out, -1 if it lets it in.
AtOrifice FluidSolver::at(const Orifice &orifice, double direction) const {
  const Vector &x = problem_.state();
  return {problem_.pressure_scale() * (orifice.mean_pressure * x), orifice.open ? direction * (orifice.flux * x) : 0};
}

void FluidSolver::show_valves() {
  mitral_->open = valves_->mitral_open();
  aortic_->open = valves_->aortic_open();
}

void FluidSolver::solve_step(const bus::Step &step) {
  side_.require_wall();
  statistics_ = problem_.solve(side_.wall_velocity(), side_.wall_force(), step.iteration);
  coupling_iterations_ = step.iteration + 1;
  side_.give_force(problem_.blood_force());
}

void FluidSolver::budget(const Vector &wall_velocity) {
  budget_ = problem_.budget(wall_velocity);
  if (writer_)
    wall_velocity_ = wall_velocity;
}

bool FluidSolver::isovolumetric() const { return !inlet_ && (!valves_ || !(mitral_->open || aortic_->open)); }

void FluidSolver::refuse_instability(const bus::Step &step) {
  if (!side_.runs_away(budget_, problem_.alpha()))
    return;
  if (const Orifice *entry = mitral_ ? mitral_ : inlet_; entry && entry->open)
    refuse_runaway_inflow(step, *entry, true);
  throw Failure(ExitCode::not_converged,
                fmt::format("t = {:.4f} s: {}", step.time, side_.explanation(problem_.mean_pressure())));
}

/// `is_lost`: something else is about to end the run.
void FluidSolver::refuse_runaway_inflow(const bus::Step &step, const Orifice &orifice, bool is_lost) {
  const Inflow inflow = problem_.inflow(orifice);
  if (inflow_watch_.is_runaway(inflow.energy()) || (is_lost && inflow_watch_.is_suspect(inflow.energy())))
    throw Failure(ExitCode::not_converged,
                  fmt::format("t = {:.4f} s: {}", step.time,
                              explanation(orifice.label, inflow, inflow_watch_.push(), parameters_.backflow)));
}

/// Cheaply in nearly all steps: what the mean velocity brings, which costs no sum over the ranks, decides whether to
/// look.
void FluidSolver::watch_inflow(const bus::Step &step) {
  const Orifice *entry = mitral_ ? mitral_ : inlet_;
  if (!entry)
    return;
  if (!entry->open) {
    inflow_watch_.reset();
    return;
  }
  inflow_watch_.add(entry->pressure - problem_.mean_pressure());
  const double flow = mitral_ ? at_mitral_.flow : -(entry->flux * problem_.state()), velocity = flow / entry->area;
  if (flow > 0 && inflow_watch_.is_suspect(parameters_.density / 2 * velocity * velocity))
    refuse_runaway_inflow(step, *entry, false);
}

void FluidSolver::commit_step(const bus::Step &step) {
  if (side_.is_robin())
    refuse_instability(step);
  problem_.commit();
  if (valves_) {
    at_mitral_ = at(*mitral_, -1);
    at_aortic_ = at(*aortic_, 1);
    arterial_pressure_n_ = arteries_.rest + arteries_.slope * at_aortic_.flow;
  }
  watch_inflow(step);
  if (writer_ && output_.due(step.number, step.size))
    write(step.time);
}

void FluidSolver::visit(io::State &state) {
  if (valves_) {
    valves_->visit(state);
    state.number("mitral_flow", at_mitral_.flow);
    state.number("mitral_pressure", at_mitral_.pressure);
    state.number("aortic_flow", at_aortic_.flow);
    state.number("aortic_pressure", at_aortic_.pressure);
    state.number("arterial_pressure", arterial_pressure_n_);
    show_valves();
    prepare_aorta(); // whose resistance the probes of alpha see before the next step
  }
  state.points("cavity", fem::owned_points(space_), space_.smallest_cell_size());
  problem_.visit(state);
}

void FluidSolver::save_state(const std::string &folder, const bus::Step &) {
  io::save_state(space_.communicator(), folder + "/fluid.h5", [&](io::State &state) { visit(state); });
}

void FluidSolver::load_state(const std::string &folder, const bus::Step &step) {
  if (writer_)
    writer_->go_on_from(step.time);
  io::load_state(space_.communicator(), folder + "/fluid.h5", [&](io::State &state) { visit(state); });
  problem_.resume();
}

/// The geometry of a step is that of d^n: on the interface d^{n+1} = d^n + dt v, so that blood and wall meet in
/// pictures.
Vector FluidSolver::shown_motion() const {
  Vector motion = problem_.ale_displacement();
  if (wall_velocity_.size() > 0)
    for (const unsigned node : side_.nodes().nodes())
      for (unsigned i = 0; i < 3; ++i)
        motion.local_element(3 * node + i) += dt_ * wall_velocity_.local_element(4 * node + i);
  return motion;
}

void FluidSolver::write(double time) {
  std::vector<double> velocity, pressure;
  for (unsigned node = 0; node < space_.n_owned_nodes(); ++node) {
    const double *x = problem_.state().begin() + 4 * node;
    velocity.insert(velocity.end(), x, x + 3);
    pressure.push_back(x[3] * problem_.pressure_scale());
  }
  writer_->begin(time);
  writer_->nodal("velocity", "m/s", 3, velocity.data());
  writer_->nodal("pressure", "Pa", 1, pressure.data());
  writer_->nodal("motion", "m", 3, shown_motion().begin());
  writer_->end();
}

} // namespace heartbus::fluid
