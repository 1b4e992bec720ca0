#pragma once

#include "common/config/section.h"

#include <string>

namespace heartbus {

/// A scheme that the scene says itself, in the notation of coupler/sequence/notation.h.
struct WrittenScheme {
  std::vector<config::Outline> once, start, step;
  /// Whether a step sends this field.
  bool sends(const std::string &field) const;
  /// Whether a step repeats something.
  bool repeats() const;
};

/// The schemes are explained in docs/schemes.md.
struct CouplingParameters {
  std::string scheme = "EFS1";       ///< EFS1, EFS1-corrected, E1FS, adaptive, by_phase, E1FSinf, one_way,
                                     ///< circulation, custom
  WrittenScheme sequence;            ///< of custom
  int iterations = 1;                ///< k of E1FSk; of adaptive the most, of by_phase while isovolumetric
  double tolerance = 0;              ///< of E1FS: iterates until the Robin datum changes less than this; 0: always k
  std::string acceleration = "none"; ///< of the iterations: none, anderson
  double epsilon = 1e-5;             ///< of adaptive: share of the cavity's volume that a step may lose
  double alpha = 5000;               ///< Robin coefficient of the fluid at the interface [kg/(m^2 s)]
  bool automatic_alpha = false;      ///< in place of `alpha`: a share of the limit that wall and blood set
  int lookahead = 0;                 ///< steps by which those who receive nothing may run ahead
  double deadline = 300;             ///< longest wait for anybody [s]
  /// Whether blood and wall may be solved more than once in a step.
  bool iterates() const {
    return scheme == "E1FS" || scheme == "adaptive" || scheme == "by_phase" || (is_written() && sequence.repeats());
  }
  /// Whether they are: then it is iterations that too large an alpha makes diverge, else motions that alternate from
  /// step to step.
  bool repeats() const { return iterates() && (iterations > 1 || is_written()); }
  bool is_written() const { return scheme == "custom"; }
  /// Whether the blood gets velocity and force of the wall, mixed by alpha.
  bool has_robin_condition() const;
  void describe(config::Section &section);
};

} // namespace heartbus
