#pragma once

#include "common/simd/vectorized_double.h"

namespace heartbus::ale {

/// Smallest J = det(I + grad d) at the quadrature points of each cell of a batch, n nodes and n_q points a cell:
/// `gradients` of the shape functions [q][a][3], motion d [a][3]. NaN where d is.
void smallest_jacobian(unsigned n, unsigned n_q, const fem::VectorizedDouble *gradients,
                       const fem::VectorizedDouble *ale_displacement, fem::VectorizedDouble &smallest);

} // namespace heartbus::ale
