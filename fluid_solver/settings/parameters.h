#pragma once

#include "common/config/section.h"
#include "common/config/table.h"
#include "fluid_solver/models/valves.h"
#include "fluid_solver/models/windkessel.h"

#include <string>
#include <vector>

namespace heartbus::fluid {

/// An opening in which the blood stands under a pressure from outside, in time.
struct InletParameters {
  std::string label;      ///< empty: none
  config::Table pressure; ///< [Pa]
  void describe(config::Section &section);
};

/// The keys of the scene block `fluid`.
struct Parameters {
  double density = 1060;            ///< rho [kg/m^3]
  double viscosity = 3.5e-3;        ///< mu [Pa s]
  double initial_pressure = 1333;   ///< p0 [Pa]
  double aortic_resistance = 1.3e7; ///< R_AV [kg/(s m^4)]
  ValveRules valves;                ///< with p_MV and p_AV0
  Windkessel arteries;              ///< behind the aortic valve
  double backflow = 1;              ///< beta of the stabilisation of inflow through open boundaries
  std::vector<std::string> no_slip{"base"}, slip;
  InletParameters inlet;
  double tolerance = 1e-7; ///< of the linear solver, relative to all loads
  std::string preconditioner = "ilu";
  void describe(config::Section &section);
};

} // namespace heartbus::fluid
