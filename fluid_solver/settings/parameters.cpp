#include "fluid_solver/settings/parameters.h"

#include <algorithm>

namespace heartbus::fluid {

using config::non_negative;
using config::positive;

namespace {

constexpr config::Range blood_pressure = config::between(-1e6, 1e6, "pressures of blood are a few 10 kPa at most");

} // namespace

void InletParameters::describe(config::Section &s) {
  s.text("label", label, "boundary part through which it comes; empty: none");
  pressure.describe(s.section("pressure", "on the blood there; 0 Pa on all boundaries without a condition"), "Pa",
                    blood_pressure, "pressure");
}

void Parameters::describe(config::Section &s) {
  s.quantity("density", density, "kg/m^3", positive, "density of blood");
  s.quantity("viscosity", viscosity, "Pa s", positive, "dynamic viscosity of blood");
  s.quantity("initial_pressure", initial_pressure, "Pa", blood_pressure, "pressure at the start");
  s.texts("no_slip", no_slip, "boundary labels where the blood is at rest; closed valves join them");
  s.texts("slip", slip, "flat boundary labels, each normal to a coordinate axis, along which the blood slides");
  inlet.describe(s.section("inlet", "an opening under pressure"));
  s.quantity("mitral_pressure", valves.mitral_pressure, "Pa", blood_pressure,
             "atrial pressure at the open mitral valve");
  s.quantity("aortic_pressure", valves.aortic_pressure, "Pa", blood_pressure,
             "pressure of the aorta without flow; of a windkessel at the start");
  s.quantity("aortic_resistance", aortic_resistance, "kg/(s m^4)", non_negative,
             "rise of the aortic pressure per flow through the open valve");
  config::Section &windkessel = s.section("windkessel", "arteries whose pressure follows the blood that comes");
  windkessel.quantity("compliance", arteries.compliance, "m^3/Pa", non_negative,
                      "of the arteries; 0: their pressure is constant");
  windkessel.quantity("peripheral_resistance", arteries.peripheral_resistance, "kg/(s m^4)", non_negative,
                      "from the arteries to the veins");
  windkessel.quantity("venous_pressure", arteries.venous_pressure, "Pa", blood_pressure, "of the veins");
  if ((arteries.compliance > 0) != (arteries.peripheral_resistance > 0))
    s.fail("windkessel", "needs 'compliance' and 'peripheral_resistance', or neither");
  s.quantity("valve_hysteresis", valves.hysteresis, "Pa", non_negative, "excess of pressure that opens a closed valve");
  s.quantity("valve_blanking", valves.blanking, "s", non_negative, "time after a switch without another one");
  s.quantity("mitral_guard", valves.mitral_guard, "s", non_negative,
             "time from the start during which the mitral valve stays closed");
  s.number(
      "backflow", backflow, config::between(0, 1),
      "share of its kinetic energy that inflow through an open valve has to bring along; 1: the pressure outside is "
      "that of blood at rest, and energy is bounded; 0: inflow is pushed for free");
  s.number("tolerance", tolerance, config::between(1e-14, 1e-2), "of the linear solver, relative to the loads");
  s.choice("preconditioner", preconditioner, {"ilu", "simplec"}, "of the linear solver");
  if (std::count(no_slip.begin(), no_slip.end(), inlet.label))
    s.fail("inlet", "nothing comes through '" + inlet.label + "', which is in 'no_slip'");
}

} // namespace heartbus::fluid
