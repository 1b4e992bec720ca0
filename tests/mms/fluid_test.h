#pragma once

#include "common/geometry/mesh_tools.h"
#include "common/simd/small_matrix.h"
#include "fluid_solver/navier_stokes_problem.h"

#include <functional>

/// What the tests of the fluid share: fields given by formulas.
namespace heartbus::test {

using geometry::Point3;
using Field = std::function<Point3(const Point3 &)>;
using Scalar = std::function<double(const Point3 &)>;
using Stress = std::function<fem::Mat3<double>(const Point3 &)>;

inline const Field zero = [](const Point3 &) { return Point3{}; };

inline double sum(double x) { return dealii::Utilities::MPI::sum(x, MPI_COMM_WORLD); }

/// A unit cube of n^3 cells, its faces x_low ... z_high renamed.
inline geometry::Mesh cube(unsigned n, const std::vector<std::string> &labels, bool tetrahedra = false) {
  geometry::Mesh mesh = geometry::make_box({0, 0, 0}, {1, 1, 1}, {n, n, n});
  mesh.labels = labels;
  return tetrahedra ? geometry::make_tetrahedra(mesh) : mesh;
}

inline Point3 operator+(const Point3 &a, const Point3 &b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }

/// The motion d(X) as a nodal vector.
inline fem::Vector motion(const fem::LagrangeSpace &space, const Field &d) {
  fem::Vector v = space.make_vector(3);
  for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
    for (unsigned i = 0; i < 3; ++i)
      v.local_element(3 * node + i) = d(space.points()[node])[i];
  v.update_ghost_values();
  return v;
}

/// Velocity u(x) and pressure p(x) / scale at the nodes of the mesh moved by d.
inline fem::Vector flow(const fem::LagrangeSpace &space, const Field &d, const Field &u, const Scalar &p,
                        double scale) {
  fem::Vector v = space.make_vector(4);
  for (unsigned node = 0; node < space.n_owned_nodes(); ++node) {
    const Point3 x = space.points()[node] + d(space.points()[node]);
    for (unsigned i = 0; i < 3; ++i)
      v.local_element(4 * node + i) = u(x)[i];
    v.local_element(4 * node + 3) = p(x) / scale;
  }
  v.update_ghost_values();
  return v;
}

/// The nodal force -int sigma n.phi of a stress field on the interface of the mesh moved by d.
inline fem::Vector interface_force(const fem::LagrangeSpace &space, const Field &d, const Stress &sigma) {
  const fem::BoundaryFaces faces = space.faces("interface");
  fem::Vector force = space.make_vector(4);
  for (unsigned f = 0; f < faces.n_faces; ++f)
    for (unsigned q = 0; q < faces.n_q; ++q) {
      const std::size_t point = f * faces.n_q + q;
      fem::Mat3<double> F = fem::identity<double>();
      Point3 x{};
      for (unsigned a = 0; a < faces.nodes_per_cell; ++a) {
        const Point3 X = space.points()[space.cell_nodes(faces.slots[f])[a]], dX = d(X);
        for (unsigned i = 0; i < 3; ++i) {
          x[i] += faces.shapes[point * faces.nodes_per_cell + a] * (X[i] + dX[i]);
          for (unsigned j = 0; j < 3; ++j)
            F[i][j] += dX[i] * faces.gradients[(point * faces.nodes_per_cell + a) * 3 + j];
        }
      }
      const double *N = &faces.normals[3 * point], w = faces.JxW[point];
      const Point3 traction = sigma(x) * (fem::cofactor(F) * Point3{w * N[0], w * N[1], w * N[2]});
      for (unsigned a = 0; a < faces.nodes_per_cell; ++a)
        if (const unsigned node = space.cell_nodes(faces.slots[f])[a]; node < space.n_owned_nodes())
          for (unsigned i = 0; i < 3; ++i)
            force.local_element(4 * node + i) -= faces.shapes[point * faces.nodes_per_cell + a] * traction[i];
    }
  return force;
}

inline Stress pressure(double p) {
  return [p](const Point3 &) { return -p * fem::identity<double>(); };
}

/// L2 errors of velocity and pressure on the mesh moved by d (weights of the mesh at rest: equivalent norms).
inline std::array<double, 2> errors(const fluid::NavierStokesProblem &problem, const Field &d, const Field &u,
                                    const Scalar &p) {
  const fem::LagrangeSpace &space = problem.space();
  double e[2] = {};
  for (unsigned slot = 0; slot < space.n_slots(); ++slot)
    for (unsigned q = 0; q < space.n_q() && space.slot_owned(slot); ++q) {
      Point3 x{}, u_h{};
      double p_h = 0;
      for (unsigned a = 0; a < space.nodes_per_cell(); ++a) {
        const unsigned node = space.cell_nodes(slot)[a];
        const double N = space.shapes()[q * space.nodes_per_cell() + a];
        const Point3 X = space.points()[node], moved = X + d(X);
        for (unsigned i = 0; i < 3; ++i) {
          x[i] += N * moved[i];
          u_h[i] += N * problem.state().begin()[4 * node + i];
        }
        p_h += N * problem.state().begin()[4 * node + 3] * problem.pressure_scale();
      }
      const double w = space.JxW(slot / fem::n_lanes)[q][slot % fem::n_lanes];
      for (unsigned i = 0; i < 3; ++i)
        e[0] += w * std::pow(u_h[i] - u(x)[i], 2);
      e[1] += w * std::pow(p_h - p(x), 2);
    }
  return {std::sqrt(sum(e[0])), std::sqrt(sum(e[1]))};
}

inline double largest_difference(const fem::Vector &a, const fem::Vector &b) {
  fem::Vector c = a;
  c -= b;
  return c.linfty_norm();
}

} // namespace heartbus::test
