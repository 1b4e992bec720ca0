#pragma once

#include "common/config/section.h"
#include "common/config/table.h"
#include "mech_solver/constitutive/laws.h"

#include <map>
#include <string>
#include <vector>

namespace heartbus::mech {

/// Force generation: T = tension_max G(s), with the state s of `model` at each node; or T as a table in time.
struct ActiveParameters {
  std::string model = "rdq18_ann";
  double tension_max = 500e3;     ///< [Pa]
  double sarcomere_length = 1.75; ///< SL0, at rest [um]
  config::Table tension;          ///< of model `prescribed` [Pa]
  std::string measure = "nominal";
  void describe(config::Section &section);
};

/// The pericardium as springs and dampers (paper, eq. (pericardium)), over the reference area.
struct PericardiumParameters {
  std::vector<std::string> labels{"epicardium"};
  double K_perp = 2e5, K_par = 2e4; ///< [Pa/m]
  double C_perp = 2e4, C_par = 2e3; ///< [Pa s/m]
  void describe(config::Section &section);
};

/// What pushes or pulls at one part of the boundary: a pressure that follows the surface, and a traction that stays
/// what it is per area at rest, in time.
struct LoadParameters {
  std::string label;
  config::Table pressure;                ///< from outside [Pa]
  std::vector<double> traction{0, 0, 0}; ///< [Pa]
  config::Table share{{0}, {1}};         ///< of the traction
  void describe(config::Section &section);
};

/// What the wall is made of: the name of its law, and the parameters of each law under the law's name.
struct MaterialParameters {
  std::string law = "guccione";
#define HEARTBUS_MEMBER(Law, name) Law name;
  HEARTBUS_LAWS(HEARTBUS_MEMBER)
#undef HEARTBUS_MEMBER
  double density = 1000; ///< [kg/m^3]
  Law chosen_law() const;
  void describe(config::Section &section);
};

/// A region of the mesh, by name, that differs from the rest.
struct RegionParameters : MaterialParameters {
  bool contracts = true;
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
struct Parameters : MaterialParameters {
  std::string model = "elastic";
  config::Table cavity_volume; ///< of model `prescribed` [m^3]
  std::map<std::string, RegionParameters> regions;
  std::string volume = "penalty";
  bool inertia = true;
  ActiveParameters active;
  PericardiumParameters pericardium;
  std::vector<std::string> fixed{"base"}, rollers;
  double initial_pressure = 1333; ///< [Pa]
  int inflation_steps = 2;
  std::map<std::string, LoadParameters> loads;
  std::vector<double> gravity{0, 0, 0};              ///< [m/s^2]
  std::map<std::string, std::vector<double>> probes; ///< points of the wall at rest [m]
  bool active_increment = true;
  SolverParameters solver;
  void describe(config::Section &section);
};

} // namespace heartbus::mech
