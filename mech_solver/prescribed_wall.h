#pragma once

#include "common/bus/solver.h"
#include "common/config/table.h"
#include "common/interface/nodal/interface_nodes.h"
#include "mech_solver/cavity.h"

namespace heartbus::mech {

/// A wall without mechanics, for blood alone: its cavity has the volume that a table says, by the monotone cubic
/// through the entries. Its points move on straight lines,
///
///     d = lambda s (2 - s) (c - x),    s = (distance of x from the rim) / (the largest of them),
///
/// with c half-way between the rim's centre and the point farthest from the rim: the rim rests. The volume is a
/// polynomial of third degree in lambda, which is found from it in each step.
class PrescribedWall : public bus::Solver {
 public:
  /// Failure(scene) when the table has a volume that no lambda from -0.5 (wide) to 0.8 (narrow) gives.
  PrescribedWall(const fem::LagrangeSpace &space, const config::Table &volume);
  void declare(bus::Declaration &declaration) override;
  void prepare_step(const bus::Step &) override {}
  void solve_step(const bus::Step &step) override { move(step.time); }
  void commit_step(const bus::Step &) override {}
  void load_state(const std::string &, const bus::Step &step) override { move(step.time); }

 private:
  void find_direction();
  void find_polynomial();
  void check_table() const;
  double volume_of(double lambda) const;
  double lambda_of(double volume) const;
  void move(double time);

  const fem::LagrangeSpace &space_;
  const config::Table table_;
  const Cavity cavity_;
  const interface::InterfaceNodes interface_;
  fem::Vector direction_;            ///< d of lambda = 1
  std::array<double, 4> polynomial_; ///< coefficients of the volume [m^3]
  std::vector<double> displacement_; ///< of the bus
  double volume_ = 0;                ///< of the moved wall [m^3]
};

} // namespace heartbus::mech
