#pragma once

#include "scene/settings.h"

namespace heartbus::coupler {

/// The folder of a run's results: the scene, then what was changed of it, "ideal_lv_efs1-mesh=M1-step=0.4ms". How long
/// the run is does not count, so that a longer one goes on from a shorter one. Only letters, digits and "._+-=";
/// where the changes need more than 100 characters a checksum stands for those that there is no room for.
std::string results_name(const std::string &scene, const std::vector<Change> &changes);

} // namespace heartbus::coupler
