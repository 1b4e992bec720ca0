#pragma once

namespace heartbus {

/// No quantity of any unit has a larger value; products of a few such numbers are infinite, and then NaN, at whoever
/// reads or receives them.
inline constexpr double largest_plausible = 1e100;

} // namespace heartbus
