#pragma once

#include "common/simd/vectorized_double.h"

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

/// How a step is made of the equations of one cell, dw/dt = F_w(v, w), dz/dt = F_z(v, w, z), I_ion(v, w, z).
///
/// imex_euler, of first order, is the scheme of the paper (section 3.1, step 1a): gates w implicitly with v^n,
/// concentrations z explicitly from (v^n, w^n, z^n), then I_ion(v^n, w^{n+1}, z^{n+1}).
///
/// exponential_midpoint, of second order, evaluates everything once, in the middle: v and z there are extrapolated,
/// z^{n+1/2} = z^n + dt/2 (z^n - z^{n-1}) / dt^{n-1}; the gates follow exactly with the rates that belong to them,
/// w(t) = w_inf + (w^n - w_inf) e^{-(t - t^n)/tau}; then z^{n+1} = z^n + dt F_z and I_ion. An exponential midpoint rule
/// as the generalised Rush-Larsen scheme (Sundnes, Artebrant, Skavhaug, Tveito, IEEE TBME 56 (2009) 2546) with the
/// middle from the last step instead of half a step, as in exponential Adams-Bashforth schemes (Coudiere,
/// Douanla-Lontsi, Pierre, ESAIM M2AN 52 (2018) 1733).
enum class Integrator { imex_euler, exponential_midpoint };
Integrator integrator(const std::string &name);

/// An ionic model: the equations of one cell, and how they are advanced.
///
/// Outside, everything is in SI units: v in V, I_ion in A/F = V/s, time in s; a model keeps its own units inside.
///
/// What is kept of a cell are its states and, for the extrapolation, the rates of the concentrations over the last
/// step.
///
/// States of many nodes are stored in blocks of n_lanes nodes: states[block * n_kept() + s] holds state s of the
/// nodes n_lanes*block ... n_lanes*(block + 1) - 1; the last block is filled up with copies.
///
/// To add a model: a file pair in this folder, a test in tests/unit, a line in ionic_models.h.
class IonicModel {
 public:
  virtual ~IonicModel() = default;
  virtual unsigned n_states() const = 0; ///< w and z
  virtual unsigned n_kept() const = 0;   ///< numbers kept of a cell: the states, then what the next step needs
  /// "limit_cycle": periodic state at the end of a paced beat; "published": the initial state of the publication.
  virtual CellState initial_state(const std::string &kind) const = 0;
  /// One step of `n_nodes` cells from states_n to states_np1 (the same array is allowed). `v` is the potential that the
  /// integrator asks for: at the start of the step or in its middle. `error` becomes the largest difference of a cell's
  /// states from their extrapolation, of a scale that the model chooses: an estimate of what a step so long misses.
  virtual void step(Integrator integrator, std::size_t n_nodes, const double *v, const fem::VectorizedDouble *states_n,
                    fem::VectorizedDouble *states_np1, double dt, double *i_ion, double *error) const = 0;
  /// One step of a single cell, in place, in plain doubles; `i_app` is the applied current [V/s], which has to be
  /// carried by some ion if a paced cell shall reach a limit cycle. Returns I_ion.
  virtual double step_cell(Integrator integrator, double v, std::vector<double> &states, double dt,
                           double i_app) const = 0;
  /// Which state is the calcium of the cytosol, and the factor that turns it into uM.
  virtual unsigned calcium_state() const = 0;
  virtual double calcium_to_micromolar() const = 0;
  /// Speed of a plane front in tissue at rest, over the root of the conductivity [s^-1/2]: the monodomain equation
  /// knows no length but sqrt(D) times the square root of time. tests/unit/front_speed.cpp measures it.
  virtual double front_speed() const = 0;

  /// All nodes in the same state.
  std::vector<fem::VectorizedDouble> uniform_states(std::size_t n_nodes, const std::vector<double> &states) const;
  /// calcium [uM] of every node.
  void get_calcium(std::size_t n_nodes, const std::vector<fem::VectorizedDouble> &states, double *calcium) const;
  /// From the cells of all nodes those of `nodes`, in blocks of their own, and back.
  void gather(const std::vector<unsigned> &nodes, const std::vector<fem::VectorizedDouble> &all,
              std::vector<fem::VectorizedDouble> &some) const;
  void scatter(const std::vector<unsigned> &nodes, const std::vector<fem::VectorizedDouble> &some,
               std::vector<fem::VectorizedDouble> &all) const;

 protected:
  static std::size_t n_blocks(std::size_t n_nodes) { return (n_nodes + fem::n_lanes - 1) / fem::n_lanes; }
};

/// `name` is one of ionic_model_names().
std::unique_ptr<IonicModel> make_ionic_model(const std::string &name);

} // namespace heartbus::ep
