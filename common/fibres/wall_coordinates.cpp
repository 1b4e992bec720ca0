#include "common/fibres/wall_coordinates.h"

#include "common/fem/constraints.h"
#include "common/linear_algebra/linear_solver.h"

#include <algorithm>
#include <cmath>

namespace heartbus::fem {
namespace {

/// int grad N_a . grad N_b + reaction N_a N_b
void assemble(const LagrangeSpace &space, double reaction, BlockMatrix<double> &A) {
  const unsigned n = space.nodes_per_cell();
  std::vector<VectorizedDouble> K(n * n);
  A.clear();
  for (unsigned batch = 0; batch < space.n_batches(); ++batch) {
    std::fill(K.begin(), K.end(), VectorizedDouble{});
    for (unsigned q = 0; q < space.n_q(); ++q) {
      const VectorizedDouble *g = space.gradients(batch) + q * n * 3, w = space.JxW(batch)[q];
      const double *N = space.shapes() + q * n;
      for (unsigned a = 0; a < n; ++a)
        for (unsigned b = 0; b < n; ++b)
          K[a * n + b] += w * (g[3 * a] * g[3 * b] + g[3 * a + 1] * g[3 * b + 1] + g[3 * a + 2] * g[3 * b + 2] +
                               reaction * N[a] * N[b]);
    }
    A.add_batch(batch, K.data());
  }
}

/// load_a += source int N_a
void add_source(const LagrangeSpace &space, double source, Vector &load) {
  const unsigned n = space.nodes_per_cell();
  for (unsigned slot = 0; slot < space.n_slots(); ++slot)
    for (unsigned q = 0; q < space.n_q() && space.slot_used(slot); ++q)
      for (unsigned a = 0; a < n; ++a)
        if (const unsigned node = space.cell_nodes(slot)[a]; node < space.n_owned_nodes())
          load.local_element(node) += source * space.JxW(slot / n_lanes)[q][slot % n_lanes] * space.shapes()[q * n + a];
}

Constraints nodes_on(const LagrangeSpace &space, const std::vector<std::string> &labels) {
  Constraints on(space.n_local_nodes());
  for (const auto &label : labels) {
    const auto here = space.nodes_on(label);
    std::transform(on.begin(), on.end(), here.begin(), on.begin(), [](auto a, auto b) { return a | b; });
  }
  return on;
}

/// -lap u + reaction u = source; `u` holds the values of the constrained nodes, ghosts included, and zero elsewhere.
Vector solve(const LagrangeSpace &space, const std::string &name, double reaction, double source,
             const Constraints &constrained, Vector u) {
  Vector residual = space.make_vector(1), correction = space.make_vector(1);
  BlockMatrix<double> A(space, 1);
  assemble(space, reaction, A);
  A.vmult(residual, u);
  residual *= -1;
  if (source != 0)
    add_source(space, source, residual);
  zero_constrained(residual, constrained);
  A.set_constraints(constrained);
  assemble(space, reaction, A);
  solve_linear(name, A, correction, residual, *make_preconditioner("amg", A), 1e-12);
  u += correction;
  u.update_ghost_values();
  return u;
}

Vector as_values(const LagrangeSpace &space, const Constraints &flags) {
  Vector u = space.make_vector(1);
  for (unsigned node = 0; node < space.n_local_nodes(); ++node)
    u.local_element(node) = flags[node];
  return u;
}

} // namespace

Vector transmural_coordinate(const LagrangeSpace &space) {
  return solve(space, "transmural coordinate", 0, 0, nodes_on(space, {"interface", "epicardium"}),
               as_values(space, nodes_on(space, {"epicardium"})));
}

Vector rise_to_rings(const LagrangeSpace &space, const std::vector<std::string> &rings) {
  return solve(space, "rise from the apex to the rings", 0, -1, nodes_on(space, rings), space.make_vector(1));
}

Vector nearness(const LagrangeSpace &space, const std::vector<std::string> &labels, double length) {
  const Constraints on = nodes_on(space, labels);
  return solve(space, "nearness of the outflow", 1 / (length * length), 0, on, as_values(space, on));
}

WallGradient::WallGradient(const LagrangeSpace &space, const Vector &function)
    : space_(space), function_(function), around_nodes_(space.make_vector(3)) {
  function_.update_ghost_values();
  Vector volumes = space.make_vector(1);
  for (unsigned slot = 0; slot < space.n_slots(); ++slot)
    for (unsigned q = 0; q < space.n_q() && space.slot_used(slot); ++q) {
      const Vec3<double> g = of_cell(slot, q);
      const double w = space.JxW(slot / n_lanes)[q][slot % n_lanes];
      for (unsigned a = 0; a < space.nodes_per_cell(); ++a)
        if (const unsigned node = space.cell_nodes(slot)[a]; node < space.n_owned_nodes()) {
          volumes.local_element(node) += w;
          for (unsigned i = 0; i < 3; ++i)
            around_nodes_.local_element(3 * node + i) += w * g[i];
        }
    }
  for (unsigned k = 0; k < around_nodes_.locally_owned_size(); ++k)
    around_nodes_.local_element(k) /= volumes.local_element(k / 3);
  around_nodes_.update_ghost_values();
}

Vec3<double> WallGradient::of_cell(unsigned slot, unsigned q) const {
  const unsigned n = space_.nodes_per_cell();
  const VectorizedDouble *gradients = space_.gradients(slot / n_lanes) + q * n * 3;
  Vec3<double> sum{};
  for (unsigned a = 0; a < n; ++a)
    for (unsigned i = 0; i < 3; ++i)
      sum[i] += gradients[3 * a + i][slot % n_lanes] * function_.local_element(space_.cell_nodes(slot)[a]);
  return sum;
}

Vec3<double> WallGradient::at(unsigned slot, unsigned q) const {
  const Vec3<double> here = of_cell(slot, q);
  Vec3<double> around{};
  for (unsigned a = 0; a < space_.nodes_per_cell(); ++a)
    for (unsigned i = 0; i < 3; ++i)
      around[i] += around_nodes_.local_element(3 * space_.cell_nodes(slot)[a] + i) / space_.nodes_per_cell();
  return dot(here, here) > 1e-12 * dot(around, around) ? here : around;
}

double value_at_frame(const LagrangeSpace &space, const Vector &function, unsigned slot, unsigned q) {
  const unsigned n = space.nodes_per_cell();
  double sum = 0;
  for (unsigned a = 0; a < n; ++a)
    sum += (n == 4 ? 0.25 : space.shapes()[q * n + a]) * function.local_element(space.cell_nodes(slot)[a]);
  return sum;
}

} // namespace heartbus::fem
