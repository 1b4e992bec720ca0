#pragma once

#include "common/config/table.h"

#include <map>
#include <string>
#include <vector>

namespace heartbus::ep {

/// Where tissue is stimulated: a ball, whose edge is smooth, or a cube with sharp edges.
struct StimulusSite {
  std::string shape = "ball";
  std::vector<double> centre{0, 0, 0}; ///< [m], reference configuration
  double radius = 5e-3;                ///< [m], of the cube half an edge
  void describe(config::Section &section);
};

/// The applied current I_app of the monodomain equation: a model of the Purkinje network. The default is three places
/// of the endocardium of the default ventricle, so high that apex and base are reached together, with the current of
/// the benchmark of Niederer et al. 2011 (doi 10.1098/rsta.2011.0139): 50000 uA/cm^3 over 1400 /cm and 1 uF/cm^2.
struct StimulusParameters {
  double amplitude = 35.714, duration = 3e-3, period = 0.8; ///< [V/s], [s], [s]
  std::vector<StimulusSite> sites{{"ball", {21.43e-3, 0, -14e-3}, 5e-3},
                                  {"ball", {-10.72e-3, 18.56e-3, -14e-3}, 5e-3},
                                  {"ball", {-10.72e-3, -18.56e-3, -14e-3}, 5e-3}};
  void describe(config::Section &section);
};

/// Diffusion along fibres, sheets and their normals, conductivity over membrane area and capacitance [m^2/s]; the
/// defaults are the paper's.
struct Conductivity {
  double fibre = 1.68e-4, sheet = 0.769e-4, normal = 0.248e-4;
  void describe(config::Section &section);
};

struct ConductivityParameters : Conductivity {
  std::map<std::string, Conductivity> regions; ///< of the mesh that differ, by name
  void describe(config::Section &section);
  double smallest() const; ///< in any direction and region
};

/// Of the model eikonal.
struct EikonalParameters {
  double speed = 0.8; ///< of a plane front along the fibres [m/s]; in other directions as the root of the conductivity
  bool automatic_speed = true; ///< in place of `speed`: that of the ionic model in tissue of this conductivity
  void describe(config::Section &section);
};

/// Of the model prescribed.
struct PrescribedParameters {
  std::string activation; ///< file of times of activation; empty: all of the wall at the beginning of each beat
  config::Table calcium;  ///< [uM], over the time since activation; fewer than two entries: that of the ionic model
  bool has_calcium() const { return calcium.values.size() > 1; }
  void describe(config::Section &section);
};

/// The keys of the scene block `electrophysiology`.
struct Parameters {
  std::string model = "monodomain";
  int degree = 1; ///< of the elements; 2: on tetrahedra, with nodes at the middle of edges too
  int refinements = 1;
  bool automatic_refinements = true; ///< in place of `refinements`: as few as bring nodes within `longest_edge`
  std::string integrator = "exponential_midpoint";
  int substeps = 1;
  bool automatic_substeps = true; ///< in place of `substeps`: as many as an error estimate asks for
  double substep_tolerance = 0.1; ///< of this estimate
  std::string ionic_model = "ttp06_epi";
  std::string initial_state = "limit_cycle";
  ConductivityParameters conductivity;
  StimulusParameters stimulus;
  EikonalParameters eikonal;
  PrescribedParameters prescribed;
  double tolerance = 1e-6;
  std::string preconditioner = "ilu"; ///< measured cheapest: 3 iterations where jacobi takes 28 and amg 10
  void describe(config::Section &section);

  static constexpr double longest_edge = 4e-3; ///< [m] or between nodes along it; a wave along fibres is still captured
  /// Of a mesh whose longest edge is this [m].
  int refinements_of(double longest_edge_of_mesh) const;
};

} // namespace heartbus::ep
