#pragma once

#include "common/config/section.h"

#include <map>
#include <string>

namespace heartbus {

/// Who takes part, by which program and with how many processes.
struct ParticipantParameters {
  std::string program; ///< name of an executable, beside the coupler or on the PATH, or its path; or
  std::string command; ///< a program of any kind with its words, as a shell takes them
  int ranks = 1;
  std::map<std::string, std::string> settings; ///< free keys for it, the values as written
  void describe(config::Section &section);
};

} // namespace heartbus
