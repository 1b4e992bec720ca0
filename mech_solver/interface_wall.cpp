#include "mech_solver/interface_wall.h"

namespace heartbus::mech {

using fem::Vector;

void InterfaceWall::linearise(double tau, double time) {
  problem_.time = time;
  problem_.begin_dynamic(tau);
  problem_.linearise(problem_.past[0]);
}

Vector InterfaceWall::answer(const Vector &force) {
  Vector w = space().make_vector(3);
  problem_.solve_tangent(w, force);
  return w;
}

Vector InterfaceWall::interface_mass(const Vector &x) const {
  Vector y = space().make_vector(3), ghosted(x);
  ghosted.update_ghost_values();
  surface_.apply_mass(problem_.past[0], ghosted, y);
  y.zero_out_ghost_values();
  fem::zero_constrained(y, constrained());
  return y;
}

const Vector &PressureResponse::to(const Vector &b, const Vector &d) {
  if (!problem_.has_tangent())
    problem_.linearise(d);
  if (tangent_ != problem_.n_tangents()) {
    response_.reinit(b);
    problem_.solve_tangent(response_, b);
    tangent_ = problem_.n_tangents();
  }
  return response_;
}

} // namespace heartbus::mech
