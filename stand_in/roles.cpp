#include "stand_in/roles.h"

#include "common/base/failure.h"
#include "common/bus/solver.h"

#include <map>

namespace heartbus::stand_in {

const Role &role(const std::string &name) {
  static const std::map<std::string, Role> roles{
      {"ep", {{{"calcium", "tissue", 1, "uM", true, 0.2, 0.05}}, {}}},
      {"mech",
       {{{"calcium", "tissue", 1, "uM", false},
         {"blood_force", "interface", 3, "N", false},
         {"held", "interface", 3, "1", true},
         {"displacement", "interface", 3, "m", true, 0, 1e-6},
         {"wall_velocity", "interface", 3, "m/s", true, 0, 1e-4},
         {"wall_force", "interface", 3, "N", true, 0, 1e-6},
         {"cavity_volume", bus::Declaration::global, 1, "m^3", true, 120e-6, 1e-6},
         {"cavity_compliance", bus::Declaration::global, 1, "m^3/Pa", true, 2e-8},
         {"cavity_pressure_guess", bus::Declaration::global, 1, "Pa", true, 1333},
         {"cavity_pressure", bus::Declaration::global, 1, "Pa", false}},
        {"inflate", "press"}}},
      {"ale", {{{"displacement", "interface", 3, "m", false}, {"mesh_motion", "cavity", 3, "m", true, 0, 1e-6}}, {}}},
      {"fluid",
       {{{"mesh_motion", "cavity", 3, "m", false},
         {"held", "interface", 3, "1", false},
         {"wall_velocity", "interface", 3, "m/s", false},
         {"wall_force", "interface", 3, "N", false},
         {"blood_force", "interface", 3, "N", true, 0, 1e-4}},
        {"hold", "start", "budget"}}}};
  const auto found = roles.find(name);
  if (found == roles.end())
    throw Failure(ExitCode::scene, "there is no stand-in for '" + name + "'; there are ep, mech, ale, fluid");
  return found->second;
}

} // namespace heartbus::stand_in
