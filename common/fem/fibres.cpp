#include "common/fem/fibres.h"

#include "common/bus/failure.h"
#include "common/fem/linear_solver.h"
#include "common/fem/nodal_matrix.h"

#include <algorithm>
#include <cmath>

namespace heartbus::fem {
namespace {

using Direction = Vec3<double>;

Direction cross(const Direction &a, const Direction &b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Direction scaled(double s, const Direction &a) { return {s * a[0], s * a[1], s * a[2]}; }

Direction sum(const Direction &a, const Direction &b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }

Direction normalised(const Direction &a) { return scaled(1 / std::sqrt(dot(a, a)), a); }

/// The part of `a` orthogonal to the unit vector `e`.
Direction reject(const Direction &a, const Direction &e) { return sum(a, scaled(-dot(a, e), e)); }

void set_frame(Mat3<Lanes> &frame, unsigned lane, const Direction &f, const Direction &s) {
  const Direction n = cross(f, s);
  for (unsigned i = 0; i < 3; ++i) {
    frame[i][0][lane] = f[i];
    frame[i][1][lane] = s[i];
    frame[i][2][lane] = n[i];
  }
}

void assemble_laplace(const LagrangeSpace &space, NodalMatrix &A) {
  const unsigned n = space.nodes_per_cell();
  std::vector<Lanes> K(n * n);
  A.clear();
  for (unsigned batch = 0; batch < space.n_batches(); ++batch) {
    std::fill(K.begin(), K.end(), Lanes{});
    for (unsigned q = 0; q < space.n_q(); ++q) {
      const Lanes *g = space.gradients(batch) + q * n * 3, w = space.JxW(batch)[q];
      for (unsigned a = 0; a < n; ++a)
        for (unsigned b = 0; b < n; ++b)
          K[a * n + b] += w * (g[3 * a] * g[3 * b] + g[3 * a + 1] * g[3 * b + 1] + g[3 * a + 2] * g[3 * b + 2]);
    }
    A.add_batch(batch, K.data());
  }
}

/// phi of the class comment, ghosts included.
Vector transmural_coordinate(const LagrangeSpace &space) {
  const auto endo = space.nodes_on("interface"), epi = space.nodes_on("epicardium");
  Vector phi = space.make_vector(1), residual = space.make_vector(1), correction = space.make_vector(1);
  std::vector<std::uint8_t> constrained(space.n_local_nodes());
  for (unsigned node = 0; node < space.n_local_nodes(); ++node) {
    constrained[node] = endo[node] || epi[node];
    phi.local_element(node) = epi[node];
  }
  NodalMatrix A(space, 1);
  assemble_laplace(space, A);
  A.vmult(residual, phi);
  residual *= -1;
  zero_constrained(residual, constrained);
  A.set_constraints(constrained);
  assemble_laplace(space, A);
  // Tight, so that the fibres do not depend on the partition.
  solve_linear("transmural coordinate", A, correction, residual, *make_preconditioner("amg", A), 1e-12);
  phi += correction;
  phi.update_ghost_values();
  return phi;
}

/// Where e_t is parallel to k, at the apex, any direction across e_t is as good as another.
Direction upwards(const Direction &e_t) {
  const Direction up = reject({0, 0, 1}, e_t);
  return normalised(dot(up, up) > 1e-6 ? up : reject({1, 0, 0}, e_t));
}

/// nu of the class comment; `transmural` is e_t.
double dispersed_share(const Direction &transmural, double angle) {
  const Direction up = reject({0, 0, 1}, transmural);
  const double x2 = angle > 0 ? std::min(1.0, dot(up, up) / std::pow(std::sin(angle), 2)) : 1;
  return 0.5 * (1 - x2 * (2 - x2));
}

/// Principal direction of a symmetric, positive semidefinite matrix: its powers tend to the projector on it.
Direction principal_direction(Mat3<double> M) {
  for (unsigned squaring = 0; squaring < 8; ++squaring) {
    M = (1 / (M[0][0] + M[1][1] + M[2][2])) * M;
    M = M * M;
  }
  const unsigned i = M[0][0] >= std::max(M[1][1], M[2][2]) ? 0 : M[1][1] >= M[2][2] ? 1 : 2;
  return normalised(M[i]);
}

} // namespace

Fibres::Fibres(const LagrangeSpace &space, const geometry::FibreParameters &parameters)
    : n_q_(space.n_q()), frames_(std::size_t(space.n_batches()) * space.n_q()), dispersion_(frames_.size()) {
  if (parameters.rule == "constant")
    lay_constant(parameters);
  else if (parameters.rule == "ellipsoid")
    lay_in_ellipsoid(space, parameters);
  else
    lay_transmural(space, parameters);
  average_at_nodes(space);
}

void Fibres::lay_constant(const geometry::FibreParameters &parameters) {
  const auto &d = parameters.direction, &t = parameters.sheet;
  const Direction f = normalised({d[0], d[1], d[2]}), s = normalised(reject({t[0], t[1], t[2]}, f));
  for (auto &frame : frames_)
    for (unsigned lane = 0; lane < n_lanes; ++lane)
      set_frame(frame, lane, f, s);
}

void Fibres::lay_transmural(const LagrangeSpace &space, const geometry::FibreParameters &parameters) {
  if (!space.has_label("interface") || !space.has_label("epicardium"))
    throw Failure(ExitCode::scene, "fibres: the rule `transmural` needs the boundary labels interface and epicardium, "
                                   "which this shape lacks; take `rule: constant`");
  const Vector phi = transmural_coordinate(space);
  const unsigned n = space.nodes_per_cell();
  for (unsigned slot = 0; slot < space.n_slots(); ++slot) {
    const unsigned batch = slot / n_lanes, lane = slot % n_lanes;
    for (unsigned q = 0; q < n_q_; ++q) {
      double depth = 0;
      Direction gradient{};
      for (unsigned a = 0; a < n; ++a) {
        const double value = phi.local_element(space.cell_nodes(slot)[a]);
        depth += space.shapes()[q * n + a] * value;
        for (unsigned i = 0; i < 3; ++i)
          gradient[i] += space.gradients(batch)[(q * n + a) * 3 + i][lane] * value;
      }
      lay(slot, q, depth, normalised(gradient), parameters);
    }
  }
}

void Fibres::lay(unsigned slot, unsigned q, double depth, const Vec3<double> &transmural,
                 const geometry::FibreParameters &parameters) {
  const std::size_t at = std::size_t(slot / n_lanes) * n_q_ + q;
  const Direction e_n = upwards(transmural), e_l = cross(e_n, transmural);
  const double theta = parameters.angle_endo * (1 - depth) + parameters.angle_epi * depth;
  set_frame(frames_[at], slot % n_lanes, sum(scaled(std::cos(theta), e_l), scaled(std::sin(theta), e_n)), transmural);
  dispersion_[at][slot % n_lanes] = dispersed_share(transmural, parameters.dispersion_angle);
}

void Fibres::lay_in_ellipsoid(const LagrangeSpace &space, const geometry::FibreParameters &parameters) {
  const geometry::VentricleParameters &p = parameters.ventricle;
  for (unsigned slot = 0; slot < space.n_slots(); ++slot)
    for (unsigned q = 0; q < n_q_; ++q) {
      const geometry::Point3 x = space.quadrature_point(slot, q);
      const double r = std::hypot(x[0], x[1]);
      double low = -0.9 * p.endocardium_across / p.wall, high = 2; // of t: straight faces lie a little inside the curved
      for (unsigned halving = 0; halving < 60; ++halving) {
        const double t = (low + high) / 2;
        const bool outside =
            std::hypot(r / (p.endocardium_across + t * p.wall), x[2] / (p.endocardium_along + t * p.wall)) > 1;
        (outside ? low : high) = t;
      }
      const double a = p.endocardium_across + low * p.wall, c = p.endocardium_along + low * p.wall;
      lay(slot, q, low, normalised({x[0] / (a * a), x[1] / (a * a), x[2] / (c * c)}), parameters);
    }
}

void Fibres::average_at_nodes(const LagrangeSpace &space) {
  const unsigned n = space.nodes_per_cell();
  std::vector<Mat3<double>> mean(space.n_local_nodes());
  std::vector<Direction> sense(space.n_local_nodes());
  for (unsigned slot = 0; slot < space.n_slots(); ++slot)
    for (unsigned q = 0; q < n_q_ && space.slot_used(slot); ++q) {
      const unsigned batch = slot / n_lanes, lane = slot % n_lanes;
      const Mat3<Lanes> &frame = frames(batch)[q];
      const Direction f{frame[0][0][lane], frame[1][0][lane], frame[2][0][lane]};
      for (unsigned a = 0; a < n; ++a) {
        const unsigned node = space.cell_nodes(slot)[a];
        const double weight = space.JxW(batch)[q][lane];
        sense[node] = sum(sense[node], scaled(weight, f));
        for (unsigned i = 0; i < 3; ++i)
          for (unsigned j = 0; j < 3; ++j)
            mean[node][i][j] += weight * f[i] * f[j];
      }
    }
  for (unsigned node = 0; node < space.n_owned_nodes(); ++node) {
    const Direction f = principal_direction(mean[node]);
    for (double component : scaled(dot(f, sense[node]) < 0 ? -1 : 1, f))
      nodal_fibres_.push_back(component);
  }
}

} // namespace heartbus::fem
