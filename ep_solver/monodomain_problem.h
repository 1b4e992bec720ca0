#pragma once

#include "common/base/stopwatch.h"
#include "common/linear_algebra/linear_solver.h"
#include "ep_solver/monodomain_kernel.h"

namespace heartbus::ep {

/// One step of the monodomain equation (paper, section 3.1, step 1b), in the reference configuration:
///
///     (v^{n+1} - v^n) / dt - div(D grad v^{n+1}) = I,   D grad v . n = 0,      I = I_app^{n+1} - I_ion
///
/// with linear elements: (M/dt + K) v^{n+1} = M (v^n/dt + I). The current is interpolated from its nodal values (ionic
/// current interpolation). M is never lumped: on coarse meshes lumping slows the wave to half its speed or stops it.
/// The residual, M (v^n/dt + I - v/dt) - K v, takes both matrices in single precision: there M multiplies a change, and
/// K v is some hundredths of M v/dt, so that rounding leaves 1e-8 of the right-hand side.
class MonodomainProblem {
 public:
  /// `D`: conductivity [m^2/s] at the quadrature points, [batch * n_q + q].
  MonodomainProblem(const fem::LagrangeSpace &space, const std::vector<fem::Mat3<fem::VectorizedDouble>> &D,
                    double tolerance, const std::string &preconditioner);

  /// Sets the step. The matrices of each step that was ever set are kept.
  void set_step(double dt);
  /// `v` holds a guess of v^{n+1} when called, v^{n+1} in the end. The tolerance is relative to the
  /// right-hand side (with M lumped).
  fem::LinearStatistics solve(const fem::Vector &v_n, const fem::Vector &I, fem::Vector &v);

  bus::Stopwatch stopwatch;

 private:
  void find_residual(const fem::Vector &v);
  fem::LinearStatistics correct(fem::Vector &v, double reduction);

  /// M/dt + K for iterations, and its preconditioner.
  struct Operator {
    double dt;
    fem::BlockMatrix<float> matrix;
    std::unique_ptr<fem::Preconditioner> preconditioner;
  };

  fem::BlockMatrix<double> M_, K_, A_; ///< A = M/dt + K of the last step that was new
  std::vector<float> entries_;         ///< of M and -K, side by side
  std::vector<double> wv_;             ///< rate - v/dt and v of each node, side by side
  fem::Vector weights_;                ///< of the nodes: the integrals of their shape functions
  double tolerance_, dt_ = 0;
  std::string preconditioner_kind_;
  std::vector<Operator> operators_;
  std::size_t current_ = 0; ///< operator
  fem::Vector rate_, residual_, increment_;
};

} // namespace heartbus::ep
