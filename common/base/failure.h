#pragma once

#include <stdexcept>
#include <string>

namespace heartbus {

/// Exit codes of every program of the project; mpirun ends with the culprit's.
enum class ExitCode {
  ok = 0,
  scene = 2,         ///< the scene file is wrong
  handshake = 3,     ///< participants, versions, fields or units do not fit together
  map = 4,           ///< point sets do not match
  not_converged = 5, ///< an iteration failed
  not_finite = 6,    ///< NaN, infinity or an inverted mesh
  deadline = 7,      ///< somebody waited too long
  file = 8           ///< a file cannot be read or written
};

/// The only exception that programs of the project throw on purpose: what is wrong, where, what would be right.
class Failure : public std::runtime_error {
 public:
  Failure(ExitCode code, const std::string &message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

} // namespace heartbus
