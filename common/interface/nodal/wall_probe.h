#pragma once

#include "common/bus/solver.h"
#include "common/interface/nodal/alpha_limit.h"
#include "common/interface/nodal/interface_nodes.h"
#include "common/interface/settings.h"
#include "common/io/state.h"

#include <memory>
#include <spdlog/logger.h>

namespace heartbus::interface {

/// The limit of alpha as a participant: the wall finds it now and then, since it stiffens and softens, by tasks that a
/// sequence orders. `probe_force` is for the blood, which answers with `probe_velocity`.
class WallProbe {
 public:
  WallProbe(const InterfaceNodes &nodes, std::shared_ptr<spdlog::logger> log) : nodes_(nodes), log_(std::move(log)) {}
  /// Offers all this; before, nothing is declared.
  void couple(LinearWall &wall, Alternation alternation);
  void declare(bus::Declaration &bus);
  /// The last estimate. It is of no use where steps have another size, or something else alternates.
  void visit(io::State &state, bool steps_are_the_same);

 private:
  void begin(const bus::Step &step);
  void add();
  void end(const bus::Step &step);

  const InterfaceNodes &nodes_;
  std::shared_ptr<spdlog::logger> log_;
  Alternation alternation_ = Alternation::steps;
  std::unique_ptr<AlphaLimit> alpha_limit_;
  double limit_ = 0;                             ///< 0: none yet
  std::vector<double> force_, velocity_, value_; ///< of the bus
};

} // namespace heartbus::interface
