#pragma once

#include "common/fibres/fibres.h"
#include "ep_solver/settings/parameters.h"

namespace heartbus::ep {

/// The tensor of the paper (section 2.2), D = sigma_f f (x) f + sigma_s s (x) s + sigma_n n (x) n, at all quadrature
/// points of the space: [batch * n_q + q] [m^2/s]. Cells of a region of the mesh that the parameters name have its own.
std::vector<fem::Mat3<fem::VectorizedDouble>> conductivity(const fem::LagrangeSpace &space, const fem::Fibres &fibres,
                                                           const ConductivityParameters &parameters);

} // namespace heartbus::ep
