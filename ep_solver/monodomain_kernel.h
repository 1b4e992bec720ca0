#pragma once

#include "common/simd/small_matrix.h"

#include <vector>

namespace heartbus::ep {

/// Mass and stiffness matrices of a batch of cells: M_ab = int phi_a phi_b, K_ab = int grad phi_a . D grad phi_b, with
/// `shapes` [q][a], `gradients` [q][a][3], `JxW` [q] and `D` [q] of the batch. M and K: [a][b].
void monodomain_matrices(unsigned n_q, unsigned n, const double *shapes, const fem::VectorizedDouble *gradients,
                         const fem::VectorizedDouble *JxW, const fem::Mat3<fem::VectorizedDouble> *D,
                         fem::VectorizedDouble *M, fem::VectorizedDouble *K);

/// M w - K v of rows whose entries stand side by side as M_ab, -K_ab, in single precision: `begin` of each row and the
/// end, `columns`, `entries` [entry][2]. `wv`: w_b, v_b of each node, [node][2].
void subtract_flux(int n_rows, const int *begin, const int *columns, const float *entries, const double *wv, double *r);

} // namespace heartbus::ep
