#pragma once

namespace heartbus::interface {

// The policy of alpha, the Robin coefficient: how its limit is found (alpha_limit.h), how often, and how much of it is
// taken by an alpha that follows it.

/// Forces by which the limit is found: it is known to a percent then.
constexpr int n_probes = 12;

/// Steps from estimate to estimate. The limit changes by some percent in a hundred steps; a fixed alpha only compares
/// itself with it.
constexpr int steps_between_estimates(bool alpha_follows) { return alpha_follows ? 100 : 1000; }

/// Eight tenths of the limit, which falls by up to 15 % until the next estimate when the ventricle begins to contract,
/// and lies up to 12 % above the border where iterations are repeated (docs/schemes.md).
constexpr double share_of_limit = 0.8;

} // namespace heartbus::interface
