#pragma once

#include "common/fem/lagrange_space.h"

#include <array>
#include <functional>
#include <vector>

namespace heartbus {

using fem::Mat3;
using fem::VectorizedDouble;

using Tensor = std::array<std::array<double, 3>, 3>;

using Conductivity = std::function<std::vector<Mat3<VectorizedDouble>>(const fem::LagrangeSpace &)>;

/// The same everywhere.
inline Conductivity constant(const Tensor &D) {
  Mat3<VectorizedDouble> lanes;
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      lanes[i][j] = fem::lanes(D[i][j]);
  return [=](const fem::LagrangeSpace &space) {
    return std::vector<Mat3<VectorizedDouble>>(space.n_batches() * space.n_q(), lanes);
  };
}

} // namespace heartbus
