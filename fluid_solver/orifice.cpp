#include "fluid_solver/orifice.h"

namespace heartbus::fluid {

using fem::Vector;

Orifice::Orifice(const fem::LagrangeSpace &space, const std::string &label, double pressure, double resistance)
    : label(label), pressure(pressure), resistance(resistance), surface(space, label) {
  Vector at_rest = space.make_vector(3);
  at_rest.update_ghost_values();
  surface.move(at_rest);
  area = dealii::Utilities::MPI::sum(surface.owned_sum(surface.areas()), space.communicator());
  flux = surface.flux_functional();
  mean_pressure = surface.pressure_functional(area);
}

void Orifice::move(const Vector &ale_displacement) {
  surface.move(ale_displacement);
  flux = surface.flux_functional();
}

void Orifice::add_terms(const Vector &old_state, const Vector &guess, double beta_rho,
                        const fem::Constraints &constrained, fem::BlockMatrix<float> &A, Vector &residual) {
  if (!open)
    return;
  std::vector<double> backflow = surface.fluxes(old_state);
  for (double &u_n : backflow)
    u_n *= u_n < 0 ? -beta_rho / 2 : 0;
  const std::vector<double> masses = surface.masses(backflow);
  surface.add_mass(masses, A);
  surface.apply_mass(masses, guess, residual);
  fem::zero_constrained(flux, constrained);
  residual.add(pressure + resistance * (flux * guess), flux);
}

Inflow Orifice::inflow(const Vector &state, double density) const {
  const auto [flow, power] = surface.inflow(state);
  const double here[] = {flow, power};
  double sums[2];
  dealii::Utilities::MPI::sum(here, state.get_mpi_communicator(), sums);
  return {sums[0], density * sums[1]};
}

} // namespace heartbus::fluid
