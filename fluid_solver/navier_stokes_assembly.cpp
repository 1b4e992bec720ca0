#include "fluid_solver/models/navier_stokes_kernel.h"
#include "fluid_solver/navier_stokes_problem.h"

// The loops over cells and boundary faces.

namespace heartbus::fluid {

using fem::n_lanes;
using fem::Vector;
using fem::VectorizedDouble;

namespace {

/// The components [first, first + count) of a nodal field at the nodes of a batch of cells.
void gather(const fem::LagrangeSpace &space, unsigned batch, const Vector &field, unsigned components, unsigned count,
            VectorizedDouble *values) {
  const double *v = field.begin();
  for (unsigned lane = 0; lane < n_lanes; ++lane) {
    const unsigned *nodes = space.cell_nodes(batch * n_lanes + lane);
    for (unsigned a = 0; a < space.nodes_per_cell(); ++a)
      for (unsigned i = 0; i < count; ++i)
        values[a * count + i][lane] = v[nodes[a] * components + i];
  }
}

void scatter(const fem::LagrangeSpace &space, unsigned batch, const VectorizedDouble *values, Vector &field) {
  for (unsigned lane = 0; lane < n_lanes; ++lane) {
    const unsigned slot = batch * n_lanes + lane, *nodes = space.cell_nodes(slot);
    for (unsigned a = 0; a < space.nodes_per_cell() && space.slot_used(slot); ++a)
      for (unsigned i = 0; i < 4 && nodes[a] < space.n_owned_nodes(); ++i)
        field.local_element(4 * nodes[a] + i) += values[4 * a + i][lane];
  }
}

} // namespace

template <class Action>
void NavierStokesProblem::visit_batches(const Vector &state, const Action &action) const {
  const unsigned n = space_.nodes_per_cell(), n_q = space_.n_q();
  std::vector<VectorizedDouble> d(3 * n), d_old(3 * n), u_old(3 * n), convection(3 * n), x(4 * n), force(3 * n_q);
  NavierStokesCells cells;
  cells.nodes_per_cell = n;
  cells.n_q = n_q;
  cells.shapes = space_.shapes();
  cells.unit_nodes = unit_nodes_.data();
  cells.rho = parameters_.density;
  cells.mu = parameters_.viscosity;
  cells.dt = dt_;
  cells.inertia = inertia_;
  cells.pressure_scale = pressure_scale_;
  cells.ale_displacement = d.data();
  cells.convection = convection.data();
  cells.old_velocity = u_old.data();
  cells.state = x.data();
  cells.force = body_force ? force.data() : nullptr;
  for (unsigned batch = 0; batch < space_.n_batches(); ++batch) {
    cells.gradients = space_.gradients(batch);
    cells.JxW = space_.JxW(batch);
    gather(space_, batch, d_np1_, 3, 3, d.data());
    gather(space_, batch, d_n_, 3, 3, d_old.data());
    gather(space_, batch, past_[0], 4, 3, u_old.data());
    gather(space_, batch, state, 4, 4, x.data());
    for (unsigned k = 0; k < 3 * n; ++k) // u* = u^n - u_ALE^{n+1}
      convection[k] = u_old[k] - (d[k] - d_old[k]) / dt_;
    if (body_force)
      for (unsigned q = 0; q < n_q; ++q)
        for (unsigned lane = 0; lane < n_lanes; ++lane) {
          geometry::Point3 point = space_.quadrature_point(batch * n_lanes + lane, q);
          for (unsigned k = 0; k < 3 * n; ++k)
            point[k % 3] += cells.shapes[q * n + k / 3] * d[k][lane];
          const geometry::Point3 f = body_force(point);
          for (unsigned i = 0; i < 3; ++i)
            force[3 * q + i][lane] = f[i];
        }
    action(batch, cells);
  }
}

void NavierStokesProblem::integrate_cells(const Vector &state, fem::BlockMatrix<float> *A, Vector &residual) const {
  const unsigned n = space_.nodes_per_cell();
  std::vector<VectorizedDouble> K(16 * n * n), r(4 * n);
  double smallest_J = std::numeric_limits<double>::max();
  unsigned worst_slot = 0;
  visit_batches(state, [&](unsigned batch, const NavierStokesCells &cells) {
    VectorizedDouble J;
    integrate_navier_stokes(cells, K.data(), r.data(), J);
    for (unsigned lane = 0; lane < n_lanes; ++lane)
      if (!(J[lane] >= smallest_J)) {
        smallest_J = J[lane];
        worst_slot = batch * n_lanes + lane;
      }
    if (A)
      A->add_batch(batch, K.data());
    scatter(space_, batch, r.data(), residual);
  });
  fem::refuse_inverted_cells(space_, smallest_J, worst_slot, "the motion of the fluid mesh");
}

void NavierStokesProblem::assemble() {
  const bus::Stopwatch::Section section(stopwatch, "assembly");
  A_.clear();
  residual_ = 0;
  integrate_cells(guess_, &A_, residual_);
  add_surface_terms();
  fem::zero_constrained(residual_, constrained_);
}

void NavierStokesProblem::add_surface_terms() {
  if (interface_) {
    std::vector<double> weights = interface_->areas();
    interface_area_ = interface_->owned_sum(weights);
    for (double &weight : weights)
      weight *= robin_.alpha;
    interface_masses_ = interface_->masses(weights);
    interface_->add_mass(interface_masses_, A_);
    interface_->apply_mass(interface_masses_, guess_, residual_);
    interface_flux_ = interface_->flux_functional();
  }
  for (const auto &orifice : orifices_) {
    orifice->move(d_np1_);
    orifice->add_terms(past_[0], guess_, parameters_.backflow * parameters_.density, constrained_, A_, residual_);
  }
}

Vector NavierStokesProblem::reaction() const {
  Vector r = space_.make_vector(4);
  integrate_cells(x_, nullptr, r);
  r *= -1;
  return r;
}

/// What holds the blood on the interface, it puts on the wall.
void NavierStokesProblem::set_reaction_force() {
  const auto on = space_.nodes_on("interface");
  fem::copy_owned(reaction(), force_);
  for (unsigned k = 0; k < 4 * space_.n_owned_nodes(); ++k)
    if (!on[k / 4] || k % 4 == 3)
      force_.local_element(k) = 0;
}

void NavierStokesProblem::update_averages() {
  const bus::Stopwatch::Section section(stopwatch, "averages");
  double sums[2] = {}; // volume, pressure
  visit_batches(x_, [&](unsigned batch, const NavierStokesCells &cells) {
    VectorizedDouble volume, pressure;
    integrate_pressure(cells, volume, pressure);
    for (unsigned lane = 0; lane < n_lanes; ++lane)
      if (space_.slot_owned(batch * n_lanes + lane)) {
        sums[0] += volume[lane];
        sums[1] += pressure[lane];
      }
  });
  volume_ = dealii::Utilities::MPI::sum(sums[0], space_.communicator());
  mean_pressure_ = dealii::Utilities::MPI::sum(sums[1], space_.communicator()) / volume_;
}

} // namespace heartbus::fluid
