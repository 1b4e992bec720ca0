#include "common/log/log.h"

#include "common/base/failure.h"

#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/null_sink.h>
#include <spdlog/sinks/stdout_sinks.h>

namespace heartbus::log {

std::shared_ptr<spdlog::logger> open_log(const std::string &folder, const std::string &name, int rank, bool console) {
  if (rank != 0)
    return std::make_shared<spdlog::logger>(name, std::make_shared<spdlog::sinks::null_sink_mt>());
  const std::string file_name = folder + "/logs/" + name + ".log";
  try {
    auto file = std::make_shared<spdlog::sinks::basic_file_sink_mt>(file_name, true);
    file->set_pattern("%Y-%m-%d %H:%M:%S.%e %l  %v");
    auto logger = std::make_shared<spdlog::logger>(name, std::move(file));
    if (console) {
      logger->sinks().push_back(std::make_shared<spdlog::sinks::stdout_sink_mt>());
      logger->sinks().back()->set_pattern("%v");
    }
    logger->flush_on(spdlog::level::info);
    return logger;
  } catch (const spdlog::spdlog_ex &error) {
    throw Failure(ExitCode::file, file_name + ": cannot be written: " + error.what());
  }
}

} // namespace heartbus::log
