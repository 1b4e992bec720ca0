#pragma once

#include "common/bus/solver.h"
#include "scene/scene.h"
#include "stand_in/roles.h"

#include <deque>
#include <string>
#include <vector>

namespace heartbus::stand_in {

/// Plays a role without any physics, on one rank, with the points of the scene's meshes: the partner of a program that
/// is looked at alone. The outputs are a matter of time and place only, the same at each iteration. At `step` (0:
/// never) it does what it is told to do wrong: "nan" (first output), "fail", "silence".
class StandIn : public bus::Solver {
 public:
  struct Conduct {
    std::string mischief;
    int step = 0;
    double delay = 0; ///< of each solve [s]
  };
  StandIn(const std::string &role_name, const SceneParameters &scene, const Conduct &conduct);
  void declare(bus::Declaration &declaration) override;
  void prepare_step(const bus::Step &step) override { fill(step); }
  void solve_step(const bus::Step &step) override;
  void commit_step(const bus::Step &) override {}
  void load_state(const std::string &, const bus::Step &step) override { fill(step); }

 private:
  struct Values {
    const RoleField *field;
    const std::vector<double> *points;
    std::vector<double> values;
  };
  const std::vector<double> &points(const std::string &set, bus::Declaration &declaration);
  void fill(const bus::Step &step);

  const Role &role_;
  const SceneParameters &scene_;
  const Conduct conduct_;
  struct PointSet {
    std::string name;
    std::vector<double> points;
  };
  std::deque<PointSet> sets_;
  std::deque<Values> outputs_;
  std::deque<std::vector<double>> inputs_;
};

} // namespace heartbus::stand_in
