#pragma once

namespace heartbus::fluid {

/// The arteries behind the aortic valve as a Windkessel (Westerhof, Lankhaar, Westerhof 2009,
/// doi:10.1007/s11517-008-0359-2): their pressure p rises with the blood Q that comes and falls by what leaves to the
/// veins,
///
///     C dp/dt = Q - (p - p_venous) / R_peripheral.
///
/// Its third element, a resistance in front, is that of the valve. Without compliance p stays as it is.
struct Windkessel {
  double compliance = 0;            ///< C [m^3/Pa]; 0: p is constant
  double peripheral_resistance = 0; ///< [Pa s/m^3]
  double venous_pressure = 0;       ///< [Pa]

  /// How p at the end of a step depends on the flow Q in it: p = rest + slope Q.
  struct Answer {
    double rest, slope; ///< [Pa], [Pa s/m^3]
  };
  /// By implicit Euler from p_n over a step dt.
  Answer answer(double p_n, double dt) const {
    if (compliance == 0)
      return {p_n, 0};
    const double slope = 1 / (compliance / dt + 1 / peripheral_resistance);
    return {slope * (compliance / dt * p_n + venous_pressure / peripheral_resistance), slope};
  }
};

} // namespace heartbus::fluid
