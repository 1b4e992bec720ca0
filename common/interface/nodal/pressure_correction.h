#pragma once

#include "common/bus/solver.h"
#include "common/interface/nodal/interface_nodes.h"

namespace heartbus::interface {

/// The pressure pi, the same everywhere, that makes up for what a step leaves of the cavity's volume (docs/schemes.md):
/// with the force b of a unit pressure, the wall's answer w = A^{-1} b to it, and the velocities u of the blood and v
/// of the wall,
///
///     pi = dt b.(u - v) / (b.w),    d += pi w,    L += pi b,    p += pi.
///
/// Here is what travels for it; whoever is told to `correct` does so. Values are those of the interface, of the bus.
class WallCorrection {
 public:
  explicit WallCorrection(const InterfaceNodes &nodes)
      : nodes_(nodes), blood_velocity_(nodes.values()), unit_force_(nodes.values()), pressure_(nodes.size()) {}
  void declare(bus::Declaration &bus, const std::function<void(const bus::Step &)> &correct) {
    bus.input("blood_velocity", "interface", 3, "m/s", blood_velocity_, "correct");
    bus.input("unit_pressure_force", "interface", 3, "m^2", unit_force_, "correct");
    bus.output("pressure_correction", "interface", 1, "Pa", "n+1", pressure_);
    bus.task("correct", correct);
  }
  /// b, as the blood has sent it.
  fem::Vector unit_force() const { return nodes_.vector(unit_force_); }
  /// pi, which is sent to the blood as well. Collective.
  double find(const fem::Vector &b, const fem::Vector &w, const std::vector<double> &wall_velocity, double dt) {
    std::vector<double> jump(blood_velocity_);
    for (std::size_t k = 0; k < jump.size(); ++k)
      jump[k] -= wall_velocity[k];
    const double pressure = dt * (b * nodes_.vector(jump)) / (b * w);
    pressure_.assign(pressure_.size(), pressure);
    return pressure;
  }

 private:
  const InterfaceNodes &nodes_;
  std::vector<double> blood_velocity_, unit_force_, pressure_;
};

} // namespace heartbus::interface
