#include "fsi_solver/fsi_solver.h"

#include <set>

namespace heartbus::fsi {
namespace {

/// Passes on what one of the solvers declares, but for what stays inside the merged one.
class FilteredDeclaration : public bus::Declaration {
 public:
  FilteredDeclaration(bus::Declaration &bus, const std::set<std::string> &inside) : bus_(bus), inside_(inside) {}

  void point_set(const std::string &name, const std::vector<double> &coordinates, double spacing) override {
    if (!inside_.count(name))
      bus_.point_set(name, coordinates, spacing);
  }
  void faces(const std::string &point_set, unsigned n_corners, const std::vector<double> &corners) override {
    if (!inside_.count(point_set))
      bus_.faces(point_set, n_corners, corners);
  }
  void output(const std::string &name, const std::string &point_set, unsigned components, const std::string &unit,
              const std::string &level, const std::vector<double> &values) override {
    if (!inside_.count(name))
      bus_.output(name, point_set, components, unit, level, values);
  }
  void input(const std::string &name, const std::string &point_set, unsigned components, const std::string &unit,
             std::vector<double> &values, const std::string &task) override {
    if (!inside_.count(name))
      bus_.input(name, point_set, components, unit, values, task);
  }
  void task(const std::string &name, std::function<void(const bus::Step &)> action) override {
    if (!inside_.count(name))
      bus_.task(name, std::move(action));
  }
  void scalar(const std::string &name, const std::string &unit, std::function<double()> value,
              bus::Combine combine) override {
    if (!inside_.count(name))
      bus_.scalar(name, unit, std::move(value), combine);
  }
  void state(const std::string &name, const std::vector<std::string> &names, std::function<int()> value) override {
    bus_.state(name, names, std::move(value));
  }

 private:
  bus::Declaration &bus_;
  const std::set<std::string> inside_;
};

} // namespace

FsiSolver::FsiSolver(mech::MechSolver &mech, fluid::FluidSolver &fluid, double dt)
    : mech_(mech), fluid_(fluid), problem_(fluid.problem(), mech.problem(), dt) {}

void FsiSolver::declare(bus::Declaration &bus) {
  FilteredDeclaration wall(bus, {"blood_force", "held", "wall_velocity", "wall_force", "solid_iterations"});
  mech_.declare(wall);
  FilteredDeclaration blood(bus, {"interface", "held", "hold", "blood_force", "wall_velocity", "wall_force", "budget",
                                  "fluid_iterations", "fluid_residual"});
  fluid_.declare(blood);
  bus.scalar("fsi_iterations", "1", [this] { return double(statistics_.linear_iterations); });
}

void FsiSolver::prepare_step(const bus::Step &step) {
  mech_.prepare_step(step);
  fluid_.prepare_step(step);
}

void FsiSolver::solve_step(const bus::Step &step) {
  fem::Vector &d = mech_.begin_solve(step);
  statistics_ = problem_.solve_step(d);
  fem::Vector force(d); // on the wall's nodes
  problem_.space().move_wall(problem_.blood_force(), 1, force);
  mech_.set_blood_force(force);
  mech_.end_solve(step, statistics_);
  budget(d, step.size);
}

/// Both should vanish.
void FsiSolver::budget(const fem::Vector &d, double dt) {
  fem::Vector velocity(d), on_fluid(fluid_.problem().state());
  velocity -= mech_.problem().past[0];
  velocity *= 1 / dt;
  on_fluid = 0;
  problem_.space().add_force(velocity, on_fluid);
  fluid_.budget(on_fluid);
}

void FsiSolver::commit_step(const bus::Step &step) {
  mech_.commit_step(step);
  fluid_.commit_step(step);
}

void FsiSolver::save_state(const std::string &folder, const bus::Step &step) {
  mech_.save_state(folder, step);
  fluid_.save_state(folder, step);
}

void FsiSolver::load_state(const std::string &folder, const bus::Step &step) {
  mech_.load_state(folder, step);
  fluid_.load_state(folder, step);
}

std::vector<bus::Stopwatch *> FsiSolver::stopwatches() {
  return {&problem_.stopwatch, &mech_.problem().stopwatch, &fluid_.problem().stopwatch};
}

void FsiSolver::refresh() {
  mech_.refresh();
  fluid_.refresh();
  problem_.forget_preconditioner();
}

} // namespace heartbus::fsi
