#include "fluid_solver/fluid_solver.h"

#include "common/bus/failure.h"
#include "common/fem/output_mesh.h"
#include "common/fem/owned_faces.h"
#include "common/fem/owned_points.h"
#include "common/io/state_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <spdlog/fmt/fmt.h>

namespace heartbus::fluid {

using fem::Vector;

FluidSolver::FluidSolver(const fem::LagrangeSpace &space, const Parameters &parameters, double alpha, double dt,
                         std::shared_ptr<spdlog::logger> log)
    : space_(space), parameters_(parameters), log_(std::move(log)), problem_(space, parameters, alpha, dt), dt_(dt),
      mesh_motion_(3 * space.n_owned_nodes()), watch_(dt) {
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
  const auto on = space.nodes_on("interface");
  for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
    if (on[node])
      interface_nodes_.push_back(node);
  wall_velocity_.resize(3 * interface_nodes_.size());
  wall_force_ = blood_force_ = held_ = wall_velocity_;
}

void FluidSolver::couple(const CouplingParameters &coupling) {
  if (coupling.scheme == "one_way") {
    problem_.follow_motion();
    require_opening();
    return;
  }
  coupling_ = coupling;
  for (auto *datum : {&wall_velocity_, &wall_force_}) // until they come
    datum->assign(datum->size(), std::numeric_limits<double>::quiet_NaN());
  if (coupling.automatic_alpha)
    problem_.set_alpha(0); // until it is known
  alpha_limit_.resize(interface_nodes_.size());
  pressure_correction_ = alpha_limit_;
  blood_velocity_.resize(3 * interface_nodes_.size());
  probe_force_ = probe_velocity_ = unit_pressure_force_ = blood_velocity_;
  if (coupling.acceleration == "anderson")
    problem_.accelerate();
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
  throw Failure(ExitCode::scene, "fluid: in the scheme one_way the blood follows a prescribed motion, but all of its "
                                 "boundary is 'interface', 'no_slip' or 'slip': it needs an opening");
}

/// Blood without its Robin datum would be left to itself, at no pressure.
void FluidSolver::require_wall() {
  if (!coupling_ || has_wall_)
    return;
  const auto is_missing = [](const std::vector<double> &datum) {
    return std::any_of(datum.begin(), datum.end(), [](double value) { return std::isnan(value); });
  };
  const int missing = is_missing(wall_velocity_) || is_missing(wall_force_);
  if (dealii::Utilities::MPI::max(missing, space_.communicator()))
    throw Failure(ExitCode::scene, "the blood needs 'wall_velocity' and 'wall_force' on the interface, which nobody sends: "
                                   "let 'mech' take part, or write 'coupling: {scheme: one_way}' for blood in a "
                                   "prescribed motion");
  has_wall_ = true;
}

void FluidSolver::write_fields(const std::string &folder, const OutputParameters &output) {
  output_ = output;
  if (output_.every > 0)
    writer_ = std::make_unique<io::FieldWriter>(space_.communicator(), folder, "fluid", fem::output_mesh(space_));
}

void FluidSolver::declare(bus::Declaration &bus) {
  const double spacing = space_.smallest_cell_size();
  bus.point_set("cavity", fem::owned_points(space_), spacing);
  bus.point_set("interface", fem::owned_points(space_, interface_nodes_), spacing);
  fem::declare_faces(space_, "interface", bus);
  bus.input("mesh_motion", "cavity", 3, "m", mesh_motion_);
  bus.input("held", "interface", 3, "1", held_);
  if (!problem_.follows_motion()) {
    bus.input("wall_velocity", "interface", 3, "m/s", wall_velocity_);
    bus.input("wall_force", "interface", 3, "N", wall_force_);
  }
  bus.output("blood_force", "interface", 3, "N", "n+1", blood_force_);
  bus.task("hold", [this](const bus::Step &) { hold(); });
  bus.task("start", [this](const bus::Step &) { start(); });
  if (!problem_.follows_motion())
    bus.task("budget", [this](const bus::Step &) { budget(on_interface(wall_velocity_)); });
  bus.scalar("volume", "m^3", [this] { return problem_.volume(); });
  bus.scalar("mean_pressure", "Pa", [this] { return problem_.mean_pressure(); });
  if (valves_) {
    bus.scalar("mitral_flow", "m^3/s", [this] { return at_mitral_.flow; });
    bus.scalar("aortic_flow", "m^3/s", [this] { return at_aortic_.flow; });
    bus.state("phase", Valves::phase_names(), [this] { return int(valves_->phase()); });
  }
  if (inlet_)
    bus.scalar("inlet_flow", "m^3/s", [this] { return -(inlet_->flux * problem_.state()); });
  bus.scalar("fluid_iterations", "1", [this] { return double(statistics_.iterations); });
  bus.scalar("fluid_residual", "1", [this] { return statistics_.residual; });
  bus.scalar("volume_defect", "m^3/s", [this] { return budget_.volume_defect; });
  bus.scalar("interface_power", "W", [this] { return budget_.power; });
  bus.scalar("disagreement", "Pa", [this] { return budget_.disagreement; });
  if (coupling_)
    declare_coupling(bus);
}

void FluidSolver::declare_coupling(bus::Declaration &bus) {
  bus.input("alpha_limit", "interface", 1, "kg/(m^2 s)", alpha_limit_);
  bus.input("probe_force", "interface", 3, "N", probe_force_);
  bus.output("probe_velocity", "interface", 3, "m/s", "n", probe_velocity_);
  bus.task("probe", [this](const bus::Step &step) { probe(step); });
  bus.scalar("alpha", "kg/(m^2 s)", [this] { return problem_.alpha(); });
  bus.scalar("coupling_iterations", "1", [this] { return double(coupling_iterations_); });
  bus.scalar("datum_residual", "1", [this] { return budget_.datum_residual; });
  bus.scalar("volume_loss", "1", [this] { return std::abs(budget_.volume_defect) * dt_ / problem_.volume(); });
  bus.scalar("isovolumetric", "1", [this] { return isovolumetric() ? 1. : 0.; });
  if (coupling_->scheme == "EFS1-corrected") {
    bus.output("blood_velocity", "interface", 3, "m/s", "n+1", blood_velocity_);
    bus.output("unit_pressure_force", "interface", 3, "m^2", "n+1", unit_pressure_force_);
    bus.input("pressure_correction", "interface", 1, "Pa", pressure_correction_);
    bus.task("correct", [this](const bus::Step &) { correct(); });
  }
}

void FluidSolver::start() {
  Vector motion = space_.make_vector(3);
  std::copy(mesh_motion_.begin(), mesh_motion_.end(), motion.begin());
  problem_.start(motion);
  if (valves_) {
    at_mitral_ = at(*mitral_, -1);
    at_aortic_ = at(*aortic_, 1);
  }
  log_->info("starts with {:.2f} mL of blood at {:.0f} Pa", 1e6 * problem_.volume(), problem_.mean_pressure());
  if (writer_)
    write(0);
}

void FluidSolver::hold() { problem_.hold(on_interface(held_)); }

/// The same value at all nodes of the interface, of which this rank may have none.
double FluidSolver::uniform_value(const std::vector<double> &values) const {
  const bool here = !values.empty();
  const double none = std::numeric_limits<double>::lowest();
  return dealii::Utilities::MPI::max(here ? values[0] : none, space_.communicator());
}

/// Eight tenths of the limit, which falls by up to 15 % until the next estimate when the ventricle begins to contract.
void FluidSolver::choose_alpha() {
  if (coupling_ && coupling_->automatic_alpha)
    problem_.set_alpha(0.8 * uniform_value(alpha_limit_));
}

void FluidSolver::begin_probe() {
  Parameters parameters = parameters_;
  parameters.initial_pressure = 0;
  parameters.tolerance = std::max(parameters.tolerance, 1e-4);
  blood_at_rest_ = std::make_unique<NavierStokesProblem>(space_, parameters, 0, dt_);
  blood_at_rest_->hold(on_interface(held_));
  if (!coupling_->repeats())
    blood_at_rest_->take_alternating_motion();
  if (valves_) {
    blood_at_rest_->add_orifice("mitral", 0, mitral_->resistance).open = mitral_->open;
    blood_at_rest_->add_orifice("aortic", 0, aortic_->resistance).open = aortic_->open;
  }
  Vector motion = space_.make_vector(3);
  std::copy(mesh_motion_.begin(), mesh_motion_.end(), motion.begin());
  blood_at_rest_->start(motion);
  blood_at_rest_->prepare(motion);
}

void FluidSolver::probe(const bus::Step &step) {
  if (step.iteration == 0)
    begin_probe();
  blood_at_rest_->solve(space_.make_vector(4), on_interface(probe_force_));
  to_interface(blood_at_rest_->state(), probe_velocity_);
}

void FluidSolver::prepare_step(const bus::Step &step) {
  blood_at_rest_.reset();
  choose_alpha();
  Vector motion = space_.make_vector(3);
  std::copy(mesh_motion_.begin(), mesh_motion_.end(), motion.begin());
  if (valves_ && problem_.follows_motion())
    valves_->follow(problem_.volume_rate(motion));
  else if (valves_)
    switch_valves(step.time - step.size);
  if (valves_)
    show_valves();
  if (inlet_)
    inlet_->pressure = parameters_.inlet.pressure.at(step.time);
  problem_.prepare(motion);
}

void FluidSolver::switch_valves(double time) {
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

Vector FluidSolver::on_interface(const std::vector<double> &values) const {
  Vector v = space_.make_vector(4);
  for (std::size_t k = 0; k < values.size(); ++k)
    v.local_element(4 * interface_nodes_[k / 3] + k % 3) = values[k];
  return v;
}

void FluidSolver::to_interface(const Vector &v, std::vector<double> &values) const {
  for (std::size_t k = 0; k < values.size(); ++k)
    values[k] = v.local_element(4 * interface_nodes_[k / 3] + k % 3);
}

void FluidSolver::solve_step(const bus::Step &step) {
  require_wall();
  statistics_ = problem_.solve(on_interface(wall_velocity_), on_interface(wall_force_), step.iteration);
  coupling_iterations_ = step.iteration + 1;
  to_interface(problem_.blood_force(), blood_force_);
  if (coupling_ && coupling_->scheme == "EFS1-corrected") {
    to_interface(problem_.state(), blood_velocity_);
    to_interface(problem_.unit_pressure_force(), unit_pressure_force_);
  }
}

void FluidSolver::correct() { problem_.add_pressure(uniform_value(pressure_correction_)); }

void FluidSolver::budget(const Vector &wall_velocity) { budget_ = problem_.budget(wall_velocity); }

bool FluidSolver::isovolumetric() const { return !inlet_ && (!valves_ || !(mitral_->open || aortic_->open)); }

void FluidSolver::refuse_instability(const bus::Step &step) {
  Runaway seen;
  seen.alpha = problem_.alpha();
  seen.alpha_limit = uniform_value(alpha_limit_);
  if (!watch_.add(budget_.disagreement, budget_.datum_residual,
                  seen.alpha_limit > 0 && seen.alpha > 10 * seen.alpha_limit, budget_.alternation))
    return;
  if (const Orifice *entry = mitral_ ? mitral_ : inlet_; entry && entry->open)
    refuse_runaway_inflow(step, *entry, true);
  seen.disagreement = budget_.disagreement;
  seen.alternates = watch_.alternates();
  seen.iterates = coupling_->repeats();
  seen.automatic_alpha = coupling_->automatic_alpha;
  seen.pressure = problem_.mean_pressure();
  throw Failure(ExitCode::not_converged, fmt::format("t = {:.4f} s: {}", step.time, explanation(seen)));
}

/// `is_lost`: something else is about to end the run.
void FluidSolver::refuse_runaway_inflow(const bus::Step &step, const Orifice &orifice, bool is_lost) {
  const Inflow inflow = problem_.inflow(orifice);
  if (inflow_watch_.is_runaway(inflow.energy()) || (is_lost && inflow_watch_.is_suspect(inflow.energy())))
    throw Failure(ExitCode::not_converged,
                  fmt::format("t = {:.4f} s: {}", step.time,
                              explanation(orifice.label, inflow, inflow_watch_.push(), parameters_.backflow)));
}

/// Cheaply in nearly all steps: what the mean velocity brings, which costs no sum over the ranks, decides whether to look.
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
  if (coupling_)
    refuse_instability(step);
  problem_.commit();
  if (valves_) {
    at_mitral_ = at(*mitral_, -1);
    at_aortic_ = at(*aortic_, 1);
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
    show_valves();
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

void FluidSolver::write(double time) {
  std::vector<double> velocity, pressure;
  for (unsigned node = 0; node < space_.n_owned_nodes(); ++node) {
    const double *x = problem_.state().begin() + 4 * node;
    velocity.insert(velocity.end(), x, x + 3);
    pressure.push_back(x[3] * problem_.pressure_scale());
  }
  writer_->begin(time);
  writer_->nodal("velocity", 3, velocity.data());
  writer_->nodal("pressure", 1, pressure.data());
  writer_->nodal("motion", 3, problem_.motion().begin());
  writer_->end();
}

} // namespace heartbus::fluid
