#include "fsi_solver/merged_space.h"

namespace heartbus::fsi {

using fem::Vector;

MergedSpace::MergedSpace(const fem::LagrangeSpace &fluid, const fem::LagrangeSpace &solid)
    : fluid_(fluid), solid_(solid), map_(fluid, solid) {
  const std::uint64_t n = 4 * fluid.n_owned_nodes() + 3 * solid.n_owned_nodes(),
                      size = 4 * fluid.n_global_nodes() + 3 * solid.n_global_nodes(),
                      first = 4 * fluid.first_owned_node() + 3 * solid.first_owned_node();
  dealii::IndexSet owned(size);
  owned.add_range(first, first + n);
  partitioner_ = std::make_shared<const dealii::Utilities::MPI::Partitioner>(owned, fluid.communicator());
}

void MergedSpace::split(const Vector &x, Vector &fluid, Vector &solid) const {
  const double *middle = x.begin() + fluid.locally_owned_size();
  std::copy(x.begin(), middle, fluid.begin());
  std::copy(middle, middle + solid.locally_owned_size(), solid.begin());
}

void MergedSpace::merge(const Vector &fluid, const Vector &solid, Vector &x) const {
  double *middle = std::copy_n(fluid.begin(), fluid.locally_owned_size(), x.begin());
  std::copy_n(solid.begin(), solid.locally_owned_size(), middle);
}

void MergedSpace::move_wall(const Vector &fluid, double factor, Vector &solid) const {
  std::vector<double> values;
  for (const unsigned node : map_.fluid_nodes())
    for (unsigned i = 0; i < 3; ++i)
      values.push_back(factor * fluid.local_element(4 * node + i));
  values = map_.to_solid(values, 3);
  for (std::size_t k = 0; k < values.size(); ++k)
    solid.local_element(3 * map_.solid_nodes()[k / 3] + k % 3) = values[k];
}

void MergedSpace::add_force(const Vector &solid, Vector &fluid) const {
  std::vector<double> values;
  for (const unsigned node : map_.solid_nodes())
    for (unsigned i = 0; i < 3; ++i)
      values.push_back(solid.local_element(3 * node + i));
  values = map_.to_fluid(values, 3);
  for (std::size_t k = 0; k < values.size(); ++k)
    fluid.local_element(4 * map_.fluid_nodes()[k / 3] + k % 3) += values[k];
}

void MergedSpace::clear_wall(Vector &solid) const {
  for (const unsigned node : map_.solid_nodes())
    for (unsigned i = 0; i < 3; ++i)
      solid.local_element(3 * node + i) = 0;
}

} // namespace heartbus::fsi
