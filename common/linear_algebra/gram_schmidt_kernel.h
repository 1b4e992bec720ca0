#pragma once

#include <vector>

namespace heartbus::fem {

/// products[j] = basis[j] . w for each of the basis and, last, w . w; vectors of n numbers. One pass over each.
void multiply_by_basis(long n, const std::vector<const double *> &basis, const double *w,
                       std::vector<double> &products);

/// w -= sum_j factors[j] basis[j].
void subtract_basis(long n, const std::vector<const double *> &basis, const double *factors, double *w);

} // namespace heartbus::fem
