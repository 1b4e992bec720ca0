#include "fluid_solver/fluid_solver.h"

#include "common/bus/failure.h"
#include "common/fem/output_mesh.h"
#include "common/fem/owned_points.h"
#include "common/io/state_file.h"

namespace heartbus::fluid {

using fem::Vector;

FluidSolver::FluidSolver(const fem::LagrangeSpace &space, const Parameters &parameters, double alpha, double dt,
                         std::shared_ptr<spdlog::logger> log)
    : space_(space), parameters_(parameters), log_(std::move(log)), problem_(space, parameters, alpha, dt),
      mesh_motion_(3 * space.n_owned_nodes()) {
  if (space.has_label("mitral") != space.has_label("aortic"))
    throw Failure(ExitCode::scene, "the fluid mesh has one valve; it needs both boundaries 'mitral' and 'aortic' or none");
  if (space.has_label("mitral")) {
    valves_.emplace(parameters.valves);
    mitral_ = &problem_.add_orifice("mitral", parameters.valves.mitral_pressure, 0);
    aortic_ = &problem_.add_orifice("aortic", parameters.valves.aortic_pressure, parameters.aortic_resistance);
  }
  const auto on = space.nodes_on("interface");
  for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
    if (on[node])
      interface_nodes_.push_back(node);
  wall_velocity_.resize(3 * interface_nodes_.size());
  wall_force_ = blood_force_ = wall_velocity_;
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
  bus.input("mesh_motion", "cavity", 3, "m", mesh_motion_);
  bus.input("wall_velocity", "interface", 3, "m/s", wall_velocity_);
  bus.input("wall_force", "interface", 3, "N", wall_force_);
  bus.output("blood_force", "interface", 3, "N", "n+1", blood_force_);
  bus.task("start", [this](const bus::Step &) { start(); });
  bus.task("budget", [this](const bus::Step &) { budget(on_interface(wall_velocity_)); });
  bus.scalar("volume", "m^3", [this] { return problem_.volume(); });
  bus.scalar("mean_pressure", "Pa", [this] { return problem_.mean_pressure(); });
  if (valves_) {
    bus.scalar("mitral_flow", "m^3/s", [this] { return mitral_flow_; });
    bus.scalar("aortic_flow", "m^3/s", [this] { return aortic_flow_; });
    bus.state("phase", Valves::phase_names(), [this] { return int(valves_->phase()); });
  }
  bus.scalar("fluid_iterations", "1", [this] { return double(statistics_.iterations); });
  bus.scalar("fluid_residual", "1", [this] { return statistics_.residual; });
  bus.scalar("volume_defect", "m^3/s", [this] { return volume_defect_; });
  bus.scalar("interface_power", "W", [this] { return interface_power_; });
}

void FluidSolver::start() {
  Vector motion = space_.make_vector(3);
  std::copy(mesh_motion_.begin(), mesh_motion_.end(), motion.begin());
  problem_.start(motion);
  log_->info("starts with {:.2f} mL of blood at {:.0f} Pa", 1e6 * problem_.volume(), problem_.mean_pressure());
  if (writer_)
    write(0);
}

void FluidSolver::prepare_step(const bus::Step &step) {
  if (valves_)
    switch_valves(step.time - step.size);
  Vector motion = space_.make_vector(3);
  std::copy(mesh_motion_.begin(), mesh_motion_.end(), motion.begin());
  problem_.prepare(motion);
}

void FluidSolver::switch_valves(double time) {
  if (const auto reason = valves_->update(time, problem_.mean_pressure(), mitral_flow_, aortic_flow_))
    log_->info("t = {:.4f} s: {}; {}", time, *reason, Valves::phase_names()[valves_->phase()]);
  show_valves();
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

void FluidSolver::solve_step(const bus::Step &step) {
  statistics_ = problem_.solve(on_interface(wall_velocity_), on_interface(wall_force_), step.iteration);
  for (std::size_t k = 0; k < blood_force_.size(); ++k)
    blood_force_[k] = problem_.blood_force().local_element(4 * interface_nodes_[k / 3] + k % 3);
}

void FluidSolver::budget(const Vector &wall_velocity) {
  volume_defect_ = problem_.volume_defect(wall_velocity);
  interface_power_ = problem_.blood_force() * problem_.state() - problem_.blood_force() * wall_velocity;
}

void FluidSolver::commit_step(const bus::Step &step) {
  problem_.commit();
  if (valves_) {
    mitral_flow_ = mitral_->open ? -(mitral_->flux * problem_.state()) : 0;
    aortic_flow_ = aortic_->open ? aortic_->flux * problem_.state() : 0;
  }
  if (writer_ && output_.due(step.number, step.size))
    write(step.time);
}

void FluidSolver::visit(io::State &state) {
  if (valves_) {
    valves_->visit(state);
    state.number("mitral_flow", mitral_flow_);
    state.number("aortic_flow", aortic_flow_);
    show_valves();
  }
  state.points("cavity", fem::owned_points(space_), space_.smallest_cell_size());
  problem_.visit(state);
}

void FluidSolver::save_state(const std::string &folder, const bus::Step &) {
  io::save_state(space_.communicator(), folder + "/fluid.h5", [&](io::State &state) { visit(state); });
}

void FluidSolver::load_state(const std::string &folder, const bus::Step &) {
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
