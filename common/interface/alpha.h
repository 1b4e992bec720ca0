#pragma once

namespace heartbus::interface {

// The policy of alpha, the Robin coefficient: how its limit is found (alpha_limit.h), how often, and how much of it is
// taken by an alpha that follows it.

/// Forces by which the limit is found: it is known to a percent then.
constexpr int n_probes = 12;

/// Steps of size `dt` [s] from estimate to estimate: 20 ms of the beat, in which the limit changes by up to 15 %,
/// whatever the step; in 80 ms of filling it falls by half. A fixed alpha only compares itself with it.
constexpr int steps_between_estimates(bool alpha_follows, double dt) {
  const double steps = (alpha_follows ? 20e-3 : 200e-3) / dt;
  return steps < 1 ? 1 : static_cast<int>(steps + 0.5);
}

/// Eight tenths of the limit, which falls by up to 15 % until the next estimate when the ventricle begins to contract,
/// and lies up to 12 % above the border where iterations are repeated (docs/schemes.md).
constexpr double share_of_limit = 0.8;

} // namespace heartbus::interface
