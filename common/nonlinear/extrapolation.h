#pragma once

namespace heartbus::fem {

/// Weight of x^{n-k} in the value at t^{n+1} of the polynomial through the last `states` states of equal steps, where
/// the backward difference of that order vanishes: (-1)^k binomial(states, k + 1). Line 2, -1; parabola 3, -3, 1;
/// cubic 4, -6, 4, -1.
constexpr double extrapolation_weight(unsigned states, unsigned k) {
  double weight = states;
  for (unsigned i = 1; i <= k; ++i)
    weight = -weight * (states - i) / (i + 1);
  return weight;
}

} // namespace heartbus::fem
