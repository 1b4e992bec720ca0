#include "fluid_solver/moved_surface.h"

#include "common/simd/small_matrix.h"

namespace heartbus::fluid {

MovedSurface::MovedSurface(const fem::LagrangeSpace &space, const std::string &label)
    : space_(space), faces_(space.faces(label)), area_vectors_(faces_.n_faces * faces_.n_q) {}

void MovedSurface::move(const fem::Vector &ale_displacement) {
  const unsigned n = faces_.nodes_per_cell;
  for (unsigned f = 0; f < faces_.n_faces; ++f)
    for (unsigned q = 0; q < faces_.n_q; ++q) {
      const std::size_t point = f * faces_.n_q + q;
      const auto d = [&](unsigned a, unsigned i) {
        return ale_displacement.begin()[3 * space_.cell_nodes(faces_.slots[f])[a] + i];
      };
      const fem::Mat3<double> F = fem::deformation_gradient(n, d, &faces_.gradients[point * n * 3]);
      const double *N = &faces_.normals[3 * point], w = faces_.JxW[point];
      area_vectors_[point] = fem::cofactor(F) * fem::Vec3<double>{w * N[0], w * N[1], w * N[2]};
    }
}

std::vector<double> MovedSurface::areas() const {
  std::vector<double> areas;
  for (const auto &a : area_vectors_)
    areas.push_back(std::sqrt(fem::dot(a, a)));
  return areas;
}

double MovedSurface::owned_sum(const std::vector<double> &weights) const {
  double sum = 0;
  for (unsigned f = 0; f < faces_.n_faces; ++f)
    for (unsigned q = 0; q < faces_.n_q; ++q)
      sum += faces_.owned[f] ? weights[f * faces_.n_q + q] : 0;
  return sum;
}

std::vector<double> MovedSurface::fluxes(const fem::Vector &u) const {
  std::vector<double> fluxes(area_vectors_.size());
  for (unsigned f = 0; f < faces_.n_faces; ++f)
    for (unsigned q = 0; q < faces_.n_q; ++q)
      for (unsigned k = 0; k < faces_.nodes_per_face; ++k)
        for (unsigned i = 0; i < 3; ++i)
          fluxes[f * faces_.n_q + q] +=
              shape(f, q, k) * u.begin()[4 * node(f, k) + i] * area_vectors_[f * faces_.n_q + q][i];
  return fluxes;
}

std::array<double, 2> MovedSurface::inflow(const fem::Vector &u) const {
  std::array<double, 2> sum{};
  for (unsigned f = 0; f < faces_.n_faces; ++f)
    for (unsigned q = 0; q < faces_.n_q && faces_.owned[f]; ++q) {
      geometry::Point3 value{};
      for (unsigned k = 0; k < faces_.nodes_per_face; ++k)
        for (unsigned i = 0; i < 3; ++i)
          value[i] += shape(f, q, k) * u.begin()[4 * node(f, k) + i];
      const double flux = std::max(0., -fem::dot(value, area_vectors_[f * faces_.n_q + q]));
      sum[0] += flux;
      sum[1] += flux * fem::dot(value, value) / 2;
    }
  return sum;
}

fem::Vector MovedSurface::flux_functional() const {
  fem::Vector c = space_.make_vector(4);
  for (unsigned f = 0; f < faces_.n_faces; ++f)
    for (unsigned k = 0; k < faces_.nodes_per_face; ++k)
      if (node(f, k) < space_.n_owned_nodes())
        for (unsigned q = 0; q < faces_.n_q; ++q)
          for (unsigned i = 0; i < 3; ++i)
            c.local_element(4 * node(f, k) + i) += shape(f, q, k) * area_vectors_[f * faces_.n_q + q][i];
  return c;
}

fem::Vector MovedSurface::pressure_functional(double area) const {
  const std::vector<double> weights = areas();
  fem::Vector c = space_.make_vector(4);
  for (unsigned f = 0; f < faces_.n_faces; ++f)
    for (unsigned k = 0; k < faces_.nodes_per_face; ++k)
      if (node(f, k) < space_.n_owned_nodes())
        for (unsigned q = 0; q < faces_.n_q; ++q)
          c.local_element(4 * node(f, k) + 3) += weights[f * faces_.n_q + q] * shape(f, q, k) / area;
  return c;
}

std::vector<double> MovedSurface::masses(const std::vector<double> &weights) const {
  const unsigned n = faces_.nodes_per_face;
  std::vector<double> masses(faces_.n_faces * n * n);
  for (unsigned f = 0; f < faces_.n_faces; ++f)
    for (unsigned q = 0; q < faces_.n_q; ++q)
      for (unsigned k = 0; k < n; ++k)
        for (unsigned l = 0; l < n; ++l)
          masses[(f * n + k) * n + l] += weights[f * faces_.n_q + q] * shape(f, q, k) * shape(f, q, l);
  return masses;
}

void MovedSurface::add_mass(const std::vector<double> &masses, fem::BlockMatrix<float> &A) const {
  const unsigned n = faces_.nodes_per_face;
  for (unsigned f = 0; f < faces_.n_faces; ++f)
    for (unsigned k = 0; k < n; ++k)
      for (unsigned l = 0; l < n; ++l)
        A.add_to_diagonals(faces_.slots[f], cell_node(f, k), cell_node(f, l), 3, masses[(f * n + k) * n + l]);
}

void MovedSurface::apply_mass(const std::vector<double> &masses, const fem::Vector &x, fem::Vector &y) const {
  const unsigned n = faces_.nodes_per_face;
  const double *values = x.begin();
  for (unsigned f = 0; f < faces_.n_faces; ++f)
    for (unsigned k = 0; k < n; ++k)
      if (const unsigned row = node(f, k); row < space_.n_owned_nodes())
        for (unsigned l = 0; l < n; ++l)
          for (unsigned i = 0; i < 3; ++i)
            y.begin()[4 * row + i] += masses[(f * n + k) * n + l] * values[4 * node(f, l) + i];
}

} // namespace heartbus::fluid
