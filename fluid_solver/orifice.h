#pragma once

#include "fluid_solver/models/inflow_watch.h"
#include "fluid_solver/moved_surface.h"

#include <string>

namespace heartbus::fluid {

/// A part of the boundary that is a wall or, when open, carries sigma n = -(p + R int u.n) n: valves, and the inlet.
struct Orifice {
  /// Closed at first. Collective.
  Orifice(const fem::LagrangeSpace &space, const std::string &label, double pressure, double resistance);

  /// Takes the motion of the mesh, ghosts valid.
  void move(const fem::Vector &ale_displacement);
  /// When open: adds to matrix and residual what the condition and the inflow's energy make at the state `guess`, and
  /// clears the flux where blood is held. `beta_rho`: beta times the density, of the term for blood that comes in,
  /// -beta rho/2 min(u^n.n, 0) u.w (doi:10.1007/s00466-011-0599-0, Moghadam). Ghosts of both states valid.
  void add_terms(const fem::Vector &old_state, const fem::Vector &guess, double beta_rho,
                 const fem::Constraints &constrained, fem::BlockMatrix<float> &A, fem::Vector &residual);
  /// Of a state, ghosts valid; one sum over the ranks.
  Inflow inflow(const fem::Vector &state, double density) const;

  std::string label;
  double pressure, resistance;
  bool open = false;
  MovedSurface surface;
  double area = 0;           ///< at rest
  fem::Vector flux;          ///< of the moved surface: flux * u = int u.n
  fem::Vector mean_pressure; ///< of the surface at rest: mean_pressure * x, scaled as x is
};

} // namespace heartbus::fluid
