#include "fluid_solver/models/inflow_watch.h"

#include <cstdio>

namespace heartbus::fluid {

std::string explanation(const std::string &orifice, const Inflow &inflow, double push, double backflow) {
  char text[400];
  std::snprintf(text, sizeof text,
                "inflow through '%s' runs away: %.0f mL/s bring %.3g W of kinetic energy, %.0f Pa per volume where the "
                "pressure outside has pushed with %.0f Pa; fluid.backflow is %g: %s",
                orifice.c_str(), 1e6 * inflow.flow, inflow.power, inflow.energy(), push, backflow,
                backflow < 1
                    ? "write 'fluid.backflow: 1', with which blood has to bring along the kinetic energy it has"
                    : "take a shorter time.step or a finer mesh");
  return text;
}

} // namespace heartbus::fluid
