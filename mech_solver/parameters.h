#pragma once

#include "common/config/section.h"
#include "mech_solver/constitutive/guccione.h"
#include "mech_solver/constitutive/neo_hookean.h"

#include <string>
#include <vector>

namespace heartbus::mech {

/// Force generation: T = tension_max G(s), with the state s of `model` at each node.
struct ActiveParameters {
  std::string model = "rdq18_ann";
  double tension_max = 500e3;     ///< [Pa]
  double sarcomere_length = 1.75; ///< SL0, at rest [um]
  void describe(config::Section &section);
};

/// The pericardium as springs and dampers (paper, eq. (pericardium)), over the reference area.
struct PericardiumParameters {
  std::vector<std::string> labels{"epicardium"};
  double K_perp = 2e5, K_par = 2e4; ///< [Pa/m]
  double C_perp = 2e4, C_par = 2e3; ///< [Pa s/m]
  void describe(config::Section &section);
};

/// A pressure from outside on one part of the boundary, rising linearly in time.
struct EndPressureParameters {
  std::string label;                          ///< empty: none
  double initial = 0, final = 0, ramp = 0.05; ///< [Pa], [Pa], [s]
  double at(double time) const;
  void describe(config::Section &section);
};

/// How well the nonlinear and linear systems are solved.
struct SolverParameters {
  double residual_tolerance = 1e-7; ///< relative to the norm of the nodal forces
  double update_tolerance = 1e-6;   ///< relative to the size of the smallest cell
  double linear_tolerance = 1e-3;
  int max_iterations = 30;
  std::string preconditioner = "auto";
  void describe(config::Section &section);
};

/// The keys of the scene block `mechanics`.
struct Parameters {
  std::string law = "guccione";
  Guccione guccione;
  NeoHookean neo_hookean;
  std::vector<std::string> passive_regions;
  double density = 1000; ///< [kg/m^3]
  ActiveParameters active;
  PericardiumParameters pericardium;
  std::vector<std::string> fixed{"base"}, rollers;
  double initial_pressure = 1333; ///< [Pa]
  int inflation_steps = 2;
  EndPressureParameters end_pressure;
  bool active_increment = true;
  SolverParameters solver;
  void describe(config::Section &section);
};

} // namespace heartbus::mech
