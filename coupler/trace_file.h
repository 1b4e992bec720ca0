#pragma once

#include "common/bus/coordinator.h"

#include <string>
#include <vector>

namespace heartbus::coupler {

/// Writes trace.json in Chrome's trace format (for chrome://tracing or ui.perfetto.dev): a process for each
/// participant, a row for each of its ranks, times from the first slice on. Throws Failure(file).
void write_trace(const std::string &file_name, const std::vector<bus::Coordinator::RankTrace> &traces);

} // namespace heartbus::coupler
