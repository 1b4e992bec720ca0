#pragma once

#include <array>
#include <string>

namespace heartbus::config {

/// A unit of measurement: factor * 10^decade times powers of the base units m, kg, s, A, V, M, K, rad. Volt and molar
/// stand for themselves: the models compute in mV and uM, and nobody wants to see a membrane potential in kg m^2/(s^3
/// A). The decade is kept apart so that "0.2 ms" becomes exactly the double 0.0002.
struct Unit {
  double factor = 1;
  int decade = 0;
  std::array<int, 8> powers{};
  bool same_dimension(const Unit &other) const { return powers == other.powers; }
};

/// Parses e.g. "kg/(m^2 s)", "mmHg", "1/ms", "kPa s/m" (products by a space or "*", evaluated from left to right).
/// Throws std::invalid_argument saying what is not understood, with the nearest known symbol.
Unit parse_unit(const std::string &text);

/// Converts "10 mmHg" into the number in `unit`, e.g. "Pa". Throws std::invalid_argument: not a number, unit missing,
/// unknown or of another dimension. The unit "1" is not written.
double parse_quantity(const std::string &text, const std::string &unit);

/// A finite number and nothing else; throws std::invalid_argument.
double parse_number(const std::string &text);

/// The inverse: "1333 Pa".
std::string with_unit(double value, const std::string &unit);

/// The shortest text that reads back as the same double.
std::string shortest(double value);

} // namespace heartbus::config
