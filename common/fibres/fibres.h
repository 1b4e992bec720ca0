#pragma once

#include "common/fem/lagrange_space.h"
#include "common/geometry/parameters.h"
#include "common/simd/small_matrix.h"

#include <vector>

namespace heartbus::fem {

/// Directions of fibres f, sheets s and sheet normals n in the wall, at rest.
///
/// Rules "transmural" (Rossi et al. 2014, doi 10.1016/j.euromechsol.2013.10.009, in the form of Piersanti et al. 2021,
/// doi 10.1016/j.cma.2020.113468) and "apicobasal": the harmonic phi with phi = 0 on `interface` and 1 on `epicardium`
/// gives the transmural direction e_t = grad phi / |grad phi|; with a direction k from the apex to the base,
///
///     e_n = (k - (k.e_t) e_t) / |.|,   e_l = e_n x e_t   (circumferential),
///     f = cos(theta) e_l + sin(theta) e_n,   theta = theta_endo (1 - phi) + theta_epi phi,   s = e_t,   n = f x s.
///
/// "transmural" takes the outward normal of a flat base, k = +z. "apicobasal" serves any number of orifices in any
/// plane: k = grad psi, psi from wall_coordinates.h rising to the boundary parts `rings` (Bayer et al. 2012, doi
/// 10.1007/s10439-012-0593-5, take a harmonic function from the apex; the apex is found here as the minimum of psi).
/// At an outflow tract, fibres take other angles (Doste et al. 2019, doi 10.1002/cnm.3185): with w, which is 1 on the
/// rings of `outflow` and falls as exp(-distance / length), theta_endo becomes (1 - w) theta_endo + w
/// theta_endo,outflow, and so theta_epi.
///
/// So [f s n] is right-handed, and a positive angle winds from the apex to the base like a right-handed screw.
/// Rule "ellipsoid" (Land et al. 2015, doi 10.1098/rspa.2015.0641, section 2d): the same with phi = t and e_t the
/// normal of the ellipsoid with semi-axes a + t w, c + t w through the point, between those of the endocardium (t =
/// 0) and of the epicardium (t = 1).
///
/// Gradients are taken at the quadrature points, where frames are needed, and never interpolated: f has no direction at
/// the apex. A linear tetrahedron has one frame, that of its centroid, at all its points: it strains evenly, so that
/// its stress is one.
///
/// A tension along f alone would crush the apex: around the axis f (x) f depends on the azimuth however small the
/// distance r, so that its divergence, a force per volume, grows as 1/r and strains as log r, without limit as the mesh
/// is refined. Real fibres cannot do that. There they disperse along the wall, and what a tension acts along is
///
///     H = (1 - nu) f (x) f + nu n (x) n,   nu = (1 - x^2 (2 - x^2)) / 2,   x = min(1, |k - (k.e_t) e_t| / sin(gamma)),
///
/// with the dispersion angle gamma and k at the apex (of "apicobasal" the mean of -e_t there); x = 1 where e_t.k > 0.
/// So H = (I - s (x) s) / 2 on the axis, continuous around it, and f (x) f where the wall's normal is further than
/// gamma from the axis (structure tensors for dispersed fibres: Gasser, Ogden, Holzapfel 2006, doi
/// 10.1098/rsif.2005.0073; for active stress: Eriksson et al. 2013, doi 10.1002/cnm.2575).
///
/// Rule "file": f and s of each cell as the mesh file has them, without dispersion.
class Fibres {
 public:
  /// Collective: the rules solve Laplace problems. Failure(scene) when the labels it needs are missing.
  Fibres(const LagrangeSpace &space, const geometry::FibreParameters &parameters);

  /// [q] of a batch: columns f, s, n, orthonormal (in unused slots too).
  const Mat3<VectorizedDouble> *frames(unsigned batch) const { return &frames_[std::size_t(batch) * n_q_]; }
  /// [q] of a batch: nu, the share of the fibres that lie along n, from 0 to 1/2.
  const VectorizedDouble *dispersion(unsigned batch) const { return &dispersion_[std::size_t(batch) * n_q_]; }
  /// [owned node][3] unit vectors, for pictures: the principal direction of the mean of f (x) f around the node.
  const std::vector<double> &nodal_fibres() const { return nodal_fibres_; }

 private:
  void lay_constant(const geometry::FibreParameters &parameters);
  void lay_from_file(const LagrangeSpace &space);
  void lay_through_wall(const LagrangeSpace &space, const geometry::FibreParameters &parameters);
  void lay_in_ellipsoid(const LagrangeSpace &space, const geometry::FibreParameters &parameters);
  void lay(unsigned slot, unsigned q, double angle, const Vec3<double> &e_t, const Vec3<double> &axis);
  void average_at_nodes(const LagrangeSpace &space);

  unsigned n_q_;
  std::vector<Mat3<VectorizedDouble>> frames_; ///< [batch][q]
  std::vector<VectorizedDouble> dispersion_;   ///< [batch][q]
  std::vector<double> nodal_fibres_;
};

} // namespace heartbus::fem
