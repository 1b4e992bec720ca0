#include "common/fibres/fibres.h"

#include "common/base/failure.h"
#include "common/fibres/wall_coordinates.h"

#include <algorithm>
#include <cmath>
#include <optional>

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

void set_frame(Mat3<VectorizedDouble> &frame, unsigned lane, const Direction &f, const Direction &s) {
  const Direction n = cross(f, s);
  for (unsigned i = 0; i < 3; ++i) {
    frame[i][0][lane] = f[i];
    frame[i][1][lane] = s[i];
    frame[i][2][lane] = n[i];
  }
}

/// The direction in the wall, across e_t, that is nearest to k. Where e_t is parallel to k, at the apex, any is as good
/// as another.
Direction upwards(const Direction &e_t, const Direction &k) {
  const Direction up = reject(k, e_t);
  if (dot(up, up) > 1e-6 * dot(k, k))
    return normalised(up);
  return normalised(reject(std::abs(e_t[0]) < 0.9 ? Direction{1, 0, 0} : Direction{0, 1, 0}, e_t));
}

/// nu of the class comment; `axis`, k of the class comment, is a unit vector.
double dispersed_share(const Direction &e_t, const Direction &axis, double angle) {
  const Direction up = reject(axis, e_t);
  const bool at_apex = angle > 0 && dot(e_t, axis) < 0; // not where a wall closes above the cavity
  const double x2 = at_apex ? std::min(1.0, dot(up, up) / std::pow(std::sin(angle), 2)) : 1;
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

/// Where fibres are wound to: k of the class comment.
struct LongAxis {
  Direction at_apex{0, 0, 1};
  std::optional<WallGradient> rise; ///< none: the same everywhere

  Direction at(unsigned slot, unsigned q) const { return rise ? rise->at(slot, q) : at_apex; }
};

/// What the wall's normal is, inwards, where psi is least: the mean over points within a tenth of its range from there.
Direction axis_at_apex(const LagrangeSpace &space, const Vector &psi, const WallGradient &outwards) {
  double lowest = 0;
  for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
    lowest = std::min(lowest, psi.local_element(node));
  lowest = dealii::Utilities::MPI::min(lowest, space.communicator());
  double own[3] = {}, all[3];
  for (unsigned slot = 0; slot < space.n_slots(); ++slot)
    for (unsigned q = 0; q < space.n_q() && space.slot_owned(slot); ++q) {
      const double share = value_at_frame(space, psi, slot, q) / lowest;
      const Direction e_t = normalised(outwards.at(slot, q));
      for (unsigned i = 0; i < 3; ++i)
        own[i] -= std::max(0., share - 0.9) * space.JxW(slot / n_lanes)[q][slot % n_lanes] * e_t[i];
    }
  dealii::Utilities::MPI::sum(own, space.communicator(), all);
  return normalised({all[0], all[1], all[2]});
}

LongAxis find_long_axis(const LagrangeSpace &space, const geometry::FibreParameters &parameters,
                        const WallGradient &outwards) {
  LongAxis axis;
  if (parameters.rule == "apicobasal") {
    const Vector psi = rise_to_rings(space, parameters.rings);
    axis.rise.emplace(space, psi);
    axis.at_apex = axis_at_apex(space, psi, outwards);
  }
  return axis;
}

} // namespace

Fibres::Fibres(const LagrangeSpace &space, const geometry::FibreParameters &parameters)
    : n_q_(space.n_q()), frames_(std::size_t(space.n_batches()) * space.n_q()), dispersion_(frames_.size()) {
  if (parameters.rule == "constant")
    lay_constant(parameters);
  else if (parameters.rule == "file")
    lay_from_file(space);
  else if (parameters.rule == "ellipsoid")
    lay_in_ellipsoid(space, parameters);
  else
    lay_through_wall(space, parameters);
  average_at_nodes(space);
}

void Fibres::lay_constant(const geometry::FibreParameters &parameters) {
  const auto &d = parameters.direction, &t = parameters.sheet;
  const Direction f = normalised({d[0], d[1], d[2]}), s = normalised(reject({t[0], t[1], t[2]}, f));
  for (auto &frame : frames_)
    for (unsigned lane = 0; lane < n_lanes; ++lane)
      set_frame(frame, lane, f, s);
}

void Fibres::lay_from_file(const LagrangeSpace &space) {
  for (unsigned slot = 0; slot < space.n_slots(); ++slot) {
    const geometry::Mesh::Fibre *fibre = space.fibre(slot);
    if (!fibre)
      throw Failure(ExitCode::scene,
                    "fibres: the rule `file` needs a mesh that brings fibres along; take another rule");
    const auto &[f, s] = *fibre;
    const Direction fibres = normalised({f[0], f[1], f[2]}), sheets = normalised(reject({s[0], s[1], s[2]}, fibres));
    for (unsigned q = 0; q < n_q_; ++q)
      set_frame(frames_[std::size_t(slot / n_lanes) * n_q_ + q], slot % n_lanes, fibres, sheets);
  }
}

void Fibres::lay_through_wall(const LagrangeSpace &space, const geometry::FibreParameters &parameters) {
  if (!space.has_label("interface") || !space.has_label("epicardium"))
    throw Failure(ExitCode::scene, "fibres: the rule `" + parameters.rule +
                                       "` needs the boundary labels interface and epicardium, which this shape lacks; "
                                       "take `rule: constant`");
  const auto &outflow = parameters.outflow;
  const Vector phi = transmural_coordinate(space),
               near_outflow = outflow.rings.empty() ? Vector() : nearness(space, outflow.rings, outflow.length);
  const WallGradient outwards(space, phi);
  const LongAxis axis = find_long_axis(space, parameters, outwards);
  for (unsigned slot = 0; slot < space.n_slots(); ++slot) {
    for (unsigned q = 0; q < n_q_; ++q) {
      const double depth = value_at_frame(space, phi, slot, q),
                   w = outflow.rings.empty() ? 0 : value_at_frame(space, near_outflow, slot, q);
      const double endo = (1 - w) * parameters.angle_endo + w * outflow.angle_endo,
                   epi = (1 - w) * parameters.angle_epi + w * outflow.angle_epi;
      const Direction e_t = normalised(outwards.at(slot, q));
      lay(slot, q, endo * (1 - depth) + epi * depth, e_t, axis.at(slot, q));
      dispersion_[std::size_t(slot / n_lanes) * n_q_ + q][slot % n_lanes] =
          dispersed_share(e_t, axis.at_apex, parameters.dispersion_angle);
    }
  }
}

void Fibres::lay(unsigned slot, unsigned q, double angle, const Vec3<double> &e_t, const Vec3<double> &axis) {
  const Direction e_n = upwards(e_t, axis), e_l = cross(e_n, e_t);
  set_frame(frames_[std::size_t(slot / n_lanes) * n_q_ + q], slot % n_lanes,
            sum(scaled(std::cos(angle), e_l), scaled(std::sin(angle), e_n)), e_t);
}

void Fibres::lay_in_ellipsoid(const LagrangeSpace &space, const geometry::FibreParameters &parameters) {
  const geometry::VentricleParameters &p = parameters.ventricle;
  for (unsigned slot = 0; slot < space.n_slots(); ++slot)
    for (unsigned q = 0; q < n_q_; ++q) {
      const geometry::Point3 x = space.quadrature_point(slot, q);
      const double r = std::hypot(x[0], x[1]);
      double low = -0.9 * p.endocardium_across / p.wall,
             high = 2; // of t: straight faces lie a little inside the curved
      for (unsigned halving = 0; halving < 60; ++halving) {
        const double t = (low + high) / 2;
        const bool outside =
            std::hypot(r / (p.endocardium_across + t * p.wall), x[2] / (p.endocardium_along + t * p.wall)) > 1;
        (outside ? low : high) = t;
      }
      const double a = p.endocardium_across + low * p.wall, c = p.endocardium_along + low * p.wall;
      const Direction e_t = normalised({x[0] / (a * a), x[1] / (a * a), x[2] / (c * c)}), up{0, 0, 1};
      lay(slot, q, parameters.angle_endo * (1 - low) + parameters.angle_epi * low, e_t, up);
      dispersion_[std::size_t(slot / n_lanes) * n_q_ + q][slot % n_lanes] =
          dispersed_share(e_t, up, parameters.dispersion_angle);
    }
}

void Fibres::average_at_nodes(const LagrangeSpace &space) {
  const unsigned n = space.nodes_per_cell();
  std::vector<Mat3<double>> mean(space.n_local_nodes());
  std::vector<Direction> sense(space.n_local_nodes());
  for (unsigned slot = 0; slot < space.n_slots(); ++slot)
    for (unsigned q = 0; q < n_q_ && space.slot_used(slot); ++q) {
      const unsigned batch = slot / n_lanes, lane = slot % n_lanes;
      const Mat3<VectorizedDouble> &frame = frames(batch)[q];
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
