#pragma once

#include <string>

namespace heartbus::coupler {

/// provenance.json: the command with which the run was made, where, when, on which machine, by which versions.
std::string provenance(const std::string &folder);

} // namespace heartbus::coupler
