#pragma once

#include "common/bus/solver.h"
#include "common/interface/instability_watch.h"
#include "common/interface/nodal/interface_nodes.h"
#include "common/interface/nodal/robin_condition.h"
#include "common/interface/settings.h"

namespace heartbus::interface {

/// The blood's end of the interface on the bus: the data of its condition, and for the Robin condition what serves
/// alpha, probes and the correction, and the watch over stability. Vectors have four components a node.
class BloodSide {
 public:
  BloodSide(const fem::LagrangeSpace &space, const BloodSettings &settings, double dt);

  const BloodSettings settings;
  bool is_robin() const { return settings.condition == BloodSettings::Condition::robin; }
  const InterfaceNodes &nodes() const { return nodes_; }
  void declare_data(bus::Declaration &bus);
  void declare_more(bus::Declaration &bus); ///< of the Robin condition

  fem::Vector wall_velocity() const { return nodes_.vector(wall_velocity_); }
  fem::Vector wall_force() const { return nodes_.vector(wall_force_); }
  fem::Vector held() const { return nodes_.vector(held_); } ///< 1 where the wall cannot move; by default nowhere
  fem::Vector probe_force() const { return nodes_.vector(probe_force_); }
  void give_force(const fem::Vector &L) { nodes_.get(L, blood_force_); }
  void give_probe_velocity(const fem::Vector &u) { nodes_.get(u, probe_velocity_); }
  void give_for_correction(const fem::Vector &u, const fem::Vector &unit_pressure_force);

  // Collective:
  /// Failure(scene) as long as nobody has sent what the Robin condition is made of.
  void require_wall();
  /// By the policy of alpha.h, from the limit that has come; from now on alpha follows it.
  double followed_alpha();
  double pressure_correction() const { return uniform(pressure_correction_); } ///< [Pa]
  /// After each step: whether blood and wall run away from each other; and why, given the blood's mean pressure [Pa].
  bool runs_away(const Budget &budget, double alpha);
  std::string explanation(double mean_pressure) const { return interface::explanation(seen_, mean_pressure); }

 private:
  /// The same value at all nodes of the interface, of which this rank may have none.
  double uniform(const std::vector<double> &values) const;

  InterfaceNodes nodes_;
  InstabilityWatch watch_;
  Runaway seen_;
  bool has_wall_ = false;
  // what the bus reads and fills
  std::vector<double> wall_velocity_, wall_force_, blood_force_, held_;
  std::vector<double> probe_force_, probe_velocity_, alpha_limit_;
  std::vector<double> blood_velocity_, unit_pressure_force_, pressure_correction_;
};

} // namespace heartbus::interface
