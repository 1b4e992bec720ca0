#pragma once

#include <memory>
#include <spdlog/logger.h>
#include <string>

namespace heartbus::log {

/// The log of one participant, FOLDER/logs/NAME.log, each line with time and level. Only rank 0 writes; the logger of
/// the other ranks drops everything, so that all ranks may run the same code. `console` also shows the lines on the
/// terminal.
std::shared_ptr<spdlog::logger> open_log(const std::string &folder, const std::string &name, int rank,
                                         bool console = false);

} // namespace heartbus::log
