#include "common/interface/nodal/wall_probe.h"

#include <algorithm>
#include <spdlog/fmt/fmt.h>

namespace heartbus::interface {

void WallProbe::couple(LinearWall &wall, Alternation alternation) {
  alternation_ = alternation;
  alpha_limit_ = std::make_unique<AlphaLimit>(wall);
  force_ = velocity_ = nodes_.values();
  value_.resize(nodes_.size());
}

void WallProbe::declare(bus::Declaration &bus) {
  if (!alpha_limit_)
    return;
  bus.output("alpha_limit", "interface", 1, "kg/(m^2 s)", "n", value_);
  bus.output("probe_force", "interface", 3, "N", "n", force_);
  bus.input("probe_velocity", "interface", 3, "m/s", velocity_, "probe");
  bus.task("begin_probe", [this](const bus::Step &step) { begin(step); });
  bus.task("probe", [this](const bus::Step &) { add(); });
  bus.task("end_probe", [this](const bus::Step &step) { end(step); });
  bus.scalar("alpha_limit", "kg/(m^2 s)", [this] { return limit_; });
}

void WallProbe::begin(const bus::Step &step) {
  alpha_limit_->begin(alternation_ == Alternation::iterations ? step.size : step.size / 2, step.time);
  nodes_.get(alpha_limit_->force(), force_);
}

void WallProbe::add() {
  alpha_limit_->add(nodes_.vector(velocity_));
  nodes_.get(alpha_limit_->force(), force_);
}

void WallProbe::end(const bus::Step &step) {
  limit_ = alpha_limit_->value();
  value_.assign(value_.size(), limit_);
  log_->info("t = {:.4f} s: alpha may be up to {:.0f} kg/(m^2 s)", std::max(step.time - step.size, 0.), limit_);
}

void WallProbe::visit(io::State &state, bool steps_are_the_same) {
  double of_iterations = alternation_ == Alternation::iterations;
  const double wanted = of_iterations;
  state.number("alpha_limit", limit_);
  state.number("alpha_limit_of_iterations", of_iterations);
  if (!steps_are_the_same || of_iterations != wanted)
    limit_ = 0;
  value_.assign(value_.size(), limit_);
}

} // namespace heartbus::interface
