#include "mech_solver/boundary_terms.h"

#include <algorithm>

namespace heartbus::mech {

using fem::Vec3;

Pericardium::Pericardium(const fem::LagrangeSpace &space, const PericardiumParameters &parameters) {
  for (const auto &label : parameters.labels) {
    const fem::BoundaryFaces faces = space.faces(label);
    for (unsigned f = 0; f < faces.n_faces; ++f)
      add_face(space, faces, f, parameters);
  }
  merge_pairs();
}

/// Faces side by side share pairs of nodes.
void Pericardium::merge_pairs() {
  const auto place = [](const Pair &pair) { return std::make_pair(pair.row, pair.column); };
  std::stable_sort(pairs_.begin(), pairs_.end(), [&](const Pair &x, const Pair &y) { return place(x) < place(y); });
  std::vector<Pair> merged;
  for (const Pair &pair : pairs_) {
    if (merged.empty() || place(merged.back()) != place(pair)) {
      merged.push_back(pair);
      continue;
    }
    for (unsigned i = 0; i < 9; ++i) {
      merged.back().stiffness[i] += pair.stiffness[i];
      merged.back().damping[i] += pair.damping[i];
    }
  }
  pairs_ = std::move(merged);
}

void Pericardium::add_face(const fem::LagrangeSpace &space, const fem::BoundaryFaces &faces, unsigned f,
                           const PericardiumParameters &parameters) {
  const unsigned *nodes = space.cell_nodes(faces.slots[f]);
  for (unsigned k = 0; k < faces.nodes_per_face; ++k)
    for (unsigned l = 0; l < faces.nodes_per_face; ++l) {
      const unsigned a = faces.face_nodes[f * faces.nodes_per_face + k];
      const unsigned b = faces.face_nodes[f * faces.nodes_per_face + l];
      if (nodes[a] >= space.n_owned_nodes())
        continue;
      Pair pair{faces.slots[f], a, b, nodes[a], nodes[b], {}, {}};
      for (unsigned q = 0; q < faces.n_q; ++q) {
        const double *N = &faces.shapes[(f * faces.n_q + q) * faces.nodes_per_cell];
        const double *n = &faces.normals[(f * faces.n_q + q) * 3];
        const double weight = N[a] * N[b] * faces.JxW[f * faces.n_q + q];
        for (unsigned i = 0; i < 9; ++i) {
          const double normal = n[i / 3] * n[i % 3], tangential = (i % 4 == 0 ? 1.0 : 0.0) - normal;
          pair.stiffness[i] += weight * (parameters.K_perp * normal + parameters.K_par * tangential);
          pair.damping[i] += weight * (parameters.C_perp * normal + parameters.C_par * tangential);
        }
      }
      pairs_.push_back(pair);
    }
}

void Pericardium::add_force(const fem::Vector &d, const fem::Vector *v, fem::Vector &r) const {
  const double *values = d.begin(), *velocities = v ? v->begin() : nullptr;
  double *force = r.begin();
  for (const Pair &pair : pairs_)
    for (unsigned i = 0; i < 9; ++i) {
      const unsigned column = pair.column * 3 + i % 3;
      force[pair.row * 3 + i / 3] +=
          pair.stiffness[i] * values[column] + (velocities ? pair.damping[i] * velocities[column] : 0.0);
    }
}

void Pericardium::add_tangent(double damping_factor, fem::BlockMatrix<double> &K) const {
  for (const Pair &pair : pairs_) {
    std::array<double, 9> block;
    for (unsigned i = 0; i < 9; ++i)
      block[i] = pair.stiffness[i] + damping_factor * pair.damping[i];
    K.add_block(pair.slot, pair.a, pair.b, block.data());
  }
}

LoadedSurface::LoadedSurface(const fem::LagrangeSpace &space, const std::string &label)
    : space_(space), faces_(space.faces(label)) {}

Mat3<double> LoadedSurface::deformation(unsigned f, unsigned q, const fem::Vector &d) const {
  const unsigned *nodes = space_.cell_nodes(faces_.slots[f]), n = faces_.nodes_per_cell;
  return fem::deformation_gradient(
      n, [&](unsigned a, unsigned i) { return d.begin()[nodes[a] * 3 + i]; },
      &faces_.gradients[(f * faces_.n_q + q) * n * 3]);
}

void LoadedSurface::add_force(double pressure, const fem::Vector &d, fem::Vector &r) const {
  for (unsigned f = 0; f < faces_.n_faces; ++f)
    for (unsigned q = 0; q < faces_.n_q; ++q) {
      const unsigned fq = f * faces_.n_q + q;
      const Vec3<double> N = {faces_.normals[3 * fq], faces_.normals[3 * fq + 1], faces_.normals[3 * fq + 2]};
      const Vec3<double> area = fem::cofactor(deformation(f, q, d)) * N;
      for (unsigned k = 0; k < faces_.nodes_per_face; ++k) {
        const unsigned a = faces_.face_nodes[f * faces_.nodes_per_face + k];
        const double weight = pressure * faces_.JxW[fq] * faces_.shapes[fq * faces_.nodes_per_cell + a];
        for (unsigned i = 0; i < 3; ++i)
          r.begin()[space_.cell_nodes(faces_.slots[f])[a] * 3 + i] += weight * area[i];
      }
    }
}

void LoadedSurface::add_traction(const Vec3<double> &traction, fem::Vector &r) const {
  for (unsigned f = 0; f < faces_.n_faces; ++f)
    for (unsigned q = 0; q < faces_.n_q; ++q) {
      const unsigned fq = f * faces_.n_q + q;
      for (unsigned a = 0; a < faces_.nodes_per_cell; ++a)
        for (unsigned i = 0; i < 3; ++i)
          r.begin()[space_.cell_nodes(faces_.slots[f])[a] * 3 + i] +=
              faces_.JxW[fq] * faces_.shapes[fq * faces_.nodes_per_cell + a] * traction[i];
    }
}

double LoadedSurface::own_volume(const fem::Vector &d) const {
  double volume = 0;
  for (unsigned f = 0; f < faces_.n_faces; ++f)
    for (unsigned q = 0; q < faces_.n_q && faces_.owned[f]; ++q) {
      const unsigned fq = f * faces_.n_q + q, *nodes = space_.cell_nodes(faces_.slots[f]);
      const Vec3<double> N = {faces_.normals[3 * fq], faces_.normals[3 * fq + 1], faces_.normals[3 * fq + 2]};
      const Vec3<double> area = fem::cofactor(deformation(f, q, d)) * N;
      for (unsigned a = 0; a < faces_.nodes_per_cell; ++a)
        for (unsigned i = 0; i < 2; ++i)
          volume += 0.5 * faces_.JxW[fq] * faces_.shapes[fq * faces_.nodes_per_cell + a] * area[i] *
                    (space_.points()[nodes[a]][i] + d.begin()[3 * nodes[a] + i]);
    }
  return volume;
}

void LoadedSurface::apply_mass(const fem::Vector &d, const fem::Vector &x, fem::Vector &y) const {
  for (unsigned f = 0; f < faces_.n_faces; ++f)
    for (unsigned q = 0; q < faces_.n_q; ++q) {
      const unsigned fq = f * faces_.n_q + q, *nodes = space_.cell_nodes(faces_.slots[f]);
      const Vec3<double> N = {faces_.normals[3 * fq], faces_.normals[3 * fq + 1], faces_.normals[3 * fq + 2]};
      const Vec3<double> area = fem::cofactor(deformation(f, q, d)) * N;
      const double weight = faces_.JxW[fq] * std::sqrt(fem::dot(area, area));
      const double *shapes = &faces_.shapes[fq * faces_.nodes_per_cell];
      Vec3<double> value{};
      for (unsigned a = 0; a < faces_.nodes_per_cell; ++a)
        for (unsigned i = 0; i < 3; ++i)
          value[i] += shapes[a] * x.begin()[nodes[a] * 3 + i];
      for (unsigned a = 0; a < faces_.nodes_per_cell; ++a)
        for (unsigned i = 0; i < 3; ++i)
          y.begin()[nodes[a] * 3 + i] += weight * shapes[a] * value[i];
    }
}

void LoadedSurface::add_tangent(double pressure, const fem::Vector &d, fem::BlockMatrix<double> &K) const {
  for (unsigned f = 0; f < faces_.n_faces; ++f)
    add_face_tangent(f, pressure, d, K);
}

void LoadedSurface::add_face_tangent(unsigned f, double pressure, const fem::Vector &d,
                                     fem::BlockMatrix<double> &K) const {
  for (unsigned q = 0; q < faces_.n_q; ++q) {
    const unsigned fq = f * faces_.n_q + q;
    const double *N = &faces_.normals[3 * fq], *shape = &faces_.shapes[fq * faces_.nodes_per_cell];
    const Mat3<double> F = deformation(f, q, d);
    for (unsigned l = 0; l < faces_.nodes_per_face; ++l) { // nodes off the face have a gradient along N: no part
      const unsigned b = faces_.face_nodes[f * faces_.nodes_per_face + l];
      const double *g = &faces_.gradients[(fq * faces_.nodes_per_cell + b) * 3];
      const Vec3<double> N_x_g = {N[1] * g[2] - N[2] * g[1], N[2] * g[0] - N[0] * g[2], N[0] * g[1] - N[1] * g[0]};
      const Vec3<double> w = F * N_x_g;
      for (unsigned k = 0; k < faces_.nodes_per_face; ++k) {
        const unsigned a = faces_.face_nodes[f * faces_.nodes_per_face + k];
        const double c = pressure * faces_.JxW[fq] * shape[a];
        const double block[9] = {0, c * w[2], -c * w[1], -c * w[2], 0, c * w[0], c * w[1], -c * w[0], 0};
        K.add_block(faces_.slots[f], a, b, block);
      }
    }
  }
}

} // namespace heartbus::mech
