#pragma once

#include "common/config/section.h"

#include <string>
#include <vector>

namespace heartbus::geometry {

/// Truncated prolate ellipsoids around the origin: apex down at negative z, the widest section at z = 0, the flat base
/// at z = base_height with outward normal +z. Literature values for the human left ventricle scaled to about 83 mL
/// unloaded.
struct VentricleParameters {
  double endocardium_across = 22e-3, endocardium_along = 62e-3; ///< semi-axes
  double wall = 10e-3;                                          ///< added to both semi-axes
  double base_height = 15e-3;
  /// Discs in the base plane with centres on the x axis; the faces of the base whose centre lies in a disc are a valve.
  double mitral_radius = 11e-3, aortic_radius = 10e-3;
  double mitral_centre = -10.1e-3, aortic_centre = 11.1e-3;
  int cells_along = 5, cells_across = 6, shells = 2, layers = 4; ///< of mesh `custom`, as those of the tube
  void describe(config::Section &section);
};

/// An elastic column below a closed box of fluid, meeting at z = 0 (`interface`).
struct PistonParameters {
  double width = 10e-3, column = 10e-3, fluid = 10e-3;
  int cells_across = 2, cells_column = 3, cells_fluid = 3;
  void describe(config::Section &section);
};

/// A box of tissue with a corner at the origin; the defaults are those of the benchmark of Niederer et al. 2011
/// (doi 10.1098/rsta.2011.0139).
struct SlabParameters {
  std::vector<double> size{20e-3, 7e-3, 3e-3};
  double cell = 0.5e-3;      ///< wanted edge of a cell; each side is divided evenly
  std::vector<double> cells; ///< numbers of cells along x, y, z in its place
  double hollow = 0;         ///< radius of a cylinder along z which the end at low x clasps; 0: it is flat
  void describe(config::Section &section);
};

/// A straight tube along z, fluid inside an elastic wall.
struct TubeParameters {
  double length = 50e-3, radius = 5e-3, wall = 1e-3;
  int cells_along = 40, cells_across = 4, shells = 2, layers = 2;
  void describe(config::Section &section);
};

/// The keys of the scene block `geometry`.
struct Parameters {
  std::string shape = "ideal_left_ventricle";
  std::string mesh = "M0"; ///< of the ventricle; of the shape `file` the mesh file
  std::string cells =
      "hexahedra"; ///< or "tetrahedra": five in each hexahedron, on the same vertices; of a file what it has
  VentricleParameters ventricle;
  PistonParameters piston;
  SlabParameters slab;
  TubeParameters tube;
  void describe(config::Section &section);
};

/// Fibres around an outflow tract, where the wall has one.
struct OutflowFibreParameters {
  std::vector<std::string> rings;                        ///< boundary parts around its orifice; none: no such tract
  double angle_endo = 1.5707963267948966, angle_epi = 0; ///< [rad]
  double length = 10e-3; ///< [m] over which fibres turn into those of the rest of the wall
  void describe(config::Section &section);
};

/// The keys of the scene block `fibres`.
struct FibreParameters {
  /// "transmural", "apicobasal", "ellipsoid": angles through the wall, see fem::Fibres; "constant": one direction
  /// everywhere; "file": of the mesh
  std::string rule = "transmural";
  double angle_endo = 1.0471975511965976, angle_epi = -1.0471975511965976; ///< [rad] against the circumference
  double dispersion_angle = 0.5235987755982988;                            ///< [rad] at the apex, see fem::Fibres
  std::vector<std::string> rings{"base"}; ///< of "apicobasal": boundary parts around the orifices
  OutflowFibreParameters outflow;
  std::vector<double> direction{1, 0, 0}; ///< of "constant"
  std::vector<double> sheet{0, 0, 1};     ///< of "constant"; made orthogonal to it
  VentricleParameters ventricle;          ///< of "ellipsoid": that of the geometry
  void describe(config::Section &section);
};

} // namespace heartbus::geometry
