#pragma once

#include <map>
#include <string>

namespace heartbus::interface {

/// What too large an alpha makes alternate: motions from step to step, where blood and wall are solved once a step, or
/// iterations within a step.
enum class Alternation { steps, iterations };

/// What the blood is told of its interface.
struct BloodSettings {
  enum class Condition {
    merged, ///< none of its own: it is solved together with the wall
    robin,  ///< alpha M u + a_f(u, p; w) = g
    motion  ///< u is the velocity of the fluid's mesh
  };
  Condition condition = Condition::merged;
  double alpha = 0; ///< Robin coefficient [kg/(m^2 s)]; 0 where it is found in the run
  Alternation alternation = Alternation::steps;
};

/// What the wall is told of its interface.
struct WallSettings {
  enum class Load {
    merged,           ///< it is solved together with the blood
    blood_force,      ///< L, which the blood gives
    initial_pressure, ///< as in the inflation
    cavity_pressure   ///< that of a circulation
  };
  Load load = Load::merged;
  Alternation alternation = Alternation::steps;
};

/// As the coupler hands them to a participant with its welcome, by key, quantities with their units.
using Texts = std::map<std::string, std::string>;
Texts to_texts(const BloodSettings &settings);
Texts to_texts(const WallSettings &settings);
/// Failure(handshake) on what `to_texts` does not write. A key that is missing leaves the default.
BloodSettings blood_settings(const Texts &texts);
WallSettings wall_settings(const Texts &texts);

} // namespace heartbus::interface
