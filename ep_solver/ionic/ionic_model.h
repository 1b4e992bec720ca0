#pragma once

#include "common/fem/lanes.h"

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace heartbus::ep {

/// Potential and states of one cell.
struct CellState {
  double v; ///< [V]
  std::vector<double> states;
};

/// An ionic model: the equations of one cell, dw/dt = F_w(v, w), dz/dt = F_z(v, w, z), and its current I_ion(v, w, z),
/// advanced by the scheme of the paper (section 3.1, step 1a): gates w implicitly with v^n, concentrations z explicitly
/// from (v^n, w^n, z^n), then I_ion(v^n, w^{n+1}, z^{n+1}).
///
/// Outside, everything is in SI units: v in V, I_ion in A/F = V/s, time in s; a model keeps its own units inside.
///
/// States of many nodes are stored in blocks of n_lanes nodes: states[block * n_states() + s] holds state s of the
/// nodes n_lanes*block ... n_lanes*(block + 1) - 1; the last block is filled up with copies.
///
/// To add a model: a file pair in this folder, a test in tests/unit, a line in ionic_models.h.
class IonicModel {
 public:
  virtual ~IonicModel() = default;
  virtual unsigned n_states() const = 0;
  /// "limit_cycle": periodic state at the end of a paced beat; "published": the initial state of the publication.
  virtual CellState initial_state(const std::string &kind) const = 0;
  /// One step of `n_nodes` cells from states_n to states_np1 (the same array is allowed).
  virtual void step(std::size_t n_nodes, const double *v, const fem::Lanes *states_n, fem::Lanes *states_np1, double dt,
                    double *i_ion) const = 0;
  /// One step of a single cell, in place, in plain doubles; `i_app` is the applied current [V/s], which has to be
  /// carried by some ion if a paced cell shall reach a limit cycle. Returns I_ion.
  virtual double step_cell(double v, std::vector<double> &states, double dt, double i_app) const = 0;
  /// Which state is the calcium of the cytosol, and the factor that turns it into uM.
  virtual unsigned calcium_state() const = 0;
  virtual double calcium_to_micromolar() const = 0;

  /// All nodes in the same state.
  std::vector<fem::Lanes> uniform_states(std::size_t n_nodes, const std::vector<double> &states) const;
  /// calcium [uM] of every node.
  void get_calcium(std::size_t n_nodes, const std::vector<fem::Lanes> &states, double *calcium) const;

 protected:
  static std::size_t n_blocks(std::size_t n_nodes) { return (n_nodes + fem::n_lanes - 1) / fem::n_lanes; }
};

/// `name` is one of ionic_model_names().
std::unique_ptr<IonicModel> make_ionic_model(const std::string &name);

} // namespace heartbus::ep
