#include "fluid_solver/moved_surface.h"

#include "common/fem/small_matrix.h"

namespace heartbus::fluid {

MovedSurface::MovedSurface(const fem::LagrangeSpace &space, const std::string &label)
    : space_(space), faces_(space.faces(label)), area_vectors_(faces_.n_faces * faces_.n_q) {}

void MovedSurface::move(const fem::Vector &motion) {
  const unsigned n = faces_.nodes_per_cell;
  for (unsigned f = 0; f < faces_.n_faces; ++f)
    for (unsigned q = 0; q < faces_.n_q; ++q) {
      const std::size_t point = f * faces_.n_q + q;
      fem::Mat3<double> F = fem::identity<double>();
      for (unsigned a = 0; a < n; ++a)
        for (unsigned i = 0; i < 3; ++i)
          for (unsigned j = 0; j < 3; ++j)
            F[i][j] += motion.begin()[3 * space_.cell_nodes(faces_.slots[f])[a] + i] *
                       faces_.gradients[(point * n + a) * 3 + j];
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

double MovedSurface::area() const {
  const std::vector<double> areas = this->areas();
  double sum = 0;
  for (unsigned f = 0; f < faces_.n_faces; ++f)
    for (unsigned q = 0; q < faces_.n_q; ++q)
      sum += faces_.owned[f] ? areas[f * faces_.n_q + q] : 0;
  return dealii::Utilities::MPI::sum(sum, space_.communicator());
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

std::vector<double> MovedSurface::face_mass(const std::vector<double> &weights, unsigned f) const {
  const unsigned n = faces_.nodes_per_face;
  std::vector<double> mass(n * n);
  for (unsigned q = 0; q < faces_.n_q; ++q)
    for (unsigned k = 0; k < n; ++k)
      for (unsigned l = 0; l < n; ++l)
        mass[k * n + l] += weights[f * faces_.n_q + q] * shape(f, q, k) * shape(f, q, l);
  return mass;
}

void MovedSurface::add_mass(const std::vector<double> &weights, fem::RoundedMatrix &A) const {
  const unsigned n = faces_.nodes_per_face;
  for (unsigned f = 0; f < faces_.n_faces; ++f) {
    const std::vector<double> mass = face_mass(weights, f);
    for (unsigned k = 0; k < n; ++k)
      for (unsigned l = 0; l < n; ++l) {
        double block[16] = {};
        block[0] = block[5] = block[10] = mass[k * n + l];
        A.add_block(faces_.slots[f], cell_node(f, k), cell_node(f, l), block);
      }
  }
}

void MovedSurface::apply_mass(const std::vector<double> &weights, const fem::Vector &x, fem::Vector &y) const {
  const unsigned n = faces_.nodes_per_face;
  for (unsigned f = 0; f < faces_.n_faces; ++f) {
    const std::vector<double> mass = face_mass(weights, f);
    for (unsigned k = 0; k < n; ++k)
      for (unsigned l = 0; l < n && node(f, k) < space_.n_owned_nodes(); ++l)
        for (unsigned i = 0; i < 3; ++i)
          y.local_element(4 * node(f, k) + i) += mass[k * n + l] * x.begin()[4 * node(f, l) + i];
  }
}

} // namespace heartbus::fluid
