#pragma once

#include "common/fem/lagrange_space.h"
#include "common/fem/small_matrix.h"
#include "common/geometry/parameters.h"

#include <vector>

namespace heartbus::fem {

/// Directions of fibres f, sheets s and sheet normals n in the wall, at rest.
///
/// Rule "transmural" (Rossi et al. 2014, doi 10.1016/j.euromechsol.2013.10.009, in the form of Piersanti et al. 2021,
/// doi 10.1016/j.cma.2020.113468): the harmonic phi with phi = 0 on `interface` and 1 on `epicardium` gives the
/// transmural direction e_t = grad phi / |grad phi|; with k, the outward normal of the base (+z),
///
///     e_n = (k - (k.e_t) e_t) / |.|,   e_l = e_n x e_t   (circumferential),
///     f = cos(theta) e_l + sin(theta) e_n,   theta = theta_endo (1 - phi) + theta_epi phi,   s = e_t,   n = f x s.
///
/// So [f s n] is right-handed, and a positive angle winds from the apex to the base like a right-handed screw.
/// Rule "ellipsoid" (Land et al. 2015, doi 10.1098/rspa.2015.0641, section 2d): the same with phi = t and e_t the normal of
/// the ellipsoid with semi-axes a + t w, c + t w through the point, between those of the endocardium (t = 0) and of the
/// epicardium (t = 1).
///
/// Gradients are taken at the quadrature points, where frames are needed, and never interpolated: f has no direction at
/// the apex.
///
/// A tension along f alone would crush the apex: around the axis f (x) f depends on the azimuth however small the
/// distance r, so that its divergence, a force per volume, grows as 1/r and strains as log r, without limit as the mesh
/// is refined. Real fibres cannot do that. There they disperse along the wall, and what a tension acts along is
///
///     H = (1 - nu) f (x) f + nu n (x) n,   nu = (1 - x^2 (2 - x^2)) / 2,   x = min(1, |k - (k.e_t) e_t| / sin(gamma)),
///
/// with the dispersion angle gamma: H = (I - s (x) s) / 2 on the axis, continuous around it, and f (x) f where the wall's
/// normal is further than gamma from the axis (structure tensors for dispersed fibres: Gasser, Ogden, Holzapfel 2006,
/// doi 10.1098/rsif.2005.0073; for active stress: Eriksson et al. 2013, doi 10.1002/cnm.2575).
class Fibres {
 public:
  /// Collective: the transmural rule solves a Laplace problem. Failure(scene) when the labels it needs are missing.
  Fibres(const LagrangeSpace &space, const geometry::FibreParameters &parameters);

  /// [q] of a batch: columns f, s, n, orthonormal (in unused slots too).
  const Mat3<Lanes> *frames(unsigned batch) const { return &frames_[std::size_t(batch) * n_q_]; }
  /// [q] of a batch: nu, the share of the fibres that lie along n, from 0 to 1/2.
  const Lanes *dispersion(unsigned batch) const { return &dispersion_[std::size_t(batch) * n_q_]; }
  /// [owned node][3] unit vectors, for pictures: the principal direction of the mean of f (x) f around the node.
  const std::vector<double> &nodal_fibres() const { return nodal_fibres_; }

 private:
  void lay_constant(const geometry::FibreParameters &parameters);
  void lay_transmural(const LagrangeSpace &space, const geometry::FibreParameters &parameters);
  void lay_in_ellipsoid(const LagrangeSpace &space, const geometry::FibreParameters &parameters);
  void lay(unsigned slot, unsigned q, double depth, const Vec3<double> &transmural,
           const geometry::FibreParameters &parameters);
  void average_at_nodes(const LagrangeSpace &space);

  unsigned n_q_;
  std::vector<Mat3<Lanes>> frames_; ///< [batch][q]
  std::vector<Lanes> dispersion_;   ///< [batch][q]
  std::vector<double> nodal_fibres_;
};

} // namespace heartbus::fem
