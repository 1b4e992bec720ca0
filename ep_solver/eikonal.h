#pragma once

#include "common/fem/lagrange_space.h"
#include "common/simd/small_matrix.h"
#include "ep_solver/settings/parameters.h"

namespace heartbus::ep {

/// When a front arrives at each owned node [s], infinite where none does: the eikonal equation
///
///     sqrt(grad T . V grad T) = 1,   T = `start` on the stimuli's sites,
///
/// with the tensor of squared speeds V = c^2 D / m^2/s: a plane front is as fast as `front_speed` c [s^-1/2] times the
/// root of the conductivity in its direction (ionic_model.h). Such a front is the limit of the monodomain equation's
/// for small curvature (Colli Franzone, Guerri, Rovida, J. Math. Biol. 28 (1990) 121, doi:10.1007/BF00163143; Keener,
/// J. Math. Biol. 29 (1991) 629, doi:10.1007/BF00163916).
///
/// Times are piecewise linear on the triangles that bound a cell, D is the mean of a cell (arrival.h): of first order.
/// Each rank lets the front run through its own nodes, the earliest first, as often as its neighbours have found
/// earlier times at the nodes between; what comes out depends on ranks by rounding only. Collective. Failure(scene)
/// when a site reaches no node.
///
/// `D`: conductivity [m^2/s] at the quadrature points, [batch * n_q + q].
std::vector<double> eikonal(const fem::LagrangeSpace &space, const std::vector<fem::Mat3<fem::VectorizedDouble>> &D,
                            double front_speed, const std::vector<StimulusSite> &sites, double start);

} // namespace heartbus::ep
