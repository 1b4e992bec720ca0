#include "coupler/provenance.h"

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <mpi.h>
#include <nlohmann/json.hpp>
#include <sys/utsname.h>
#include <thread>
#include <vector>

namespace heartbus::coupler {

namespace {

/// Of the coupler itself, as the kernel knows them; words of a user need not be UTF-8.
std::vector<std::string> own_words() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> words;
  for (std::string word; std::getline(file, word, '\0');)
    words.push_back(word);
  return words;
}

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.compare(0, 10, "model name") == 0)
      return line.substr(std::min(line.size(), line.find(": ") + 2));
  return "unknown";
}

std::string now() {
  const std::time_t time = std::time(nullptr);
  char text[40];
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S %z", std::localtime(&time));
  return text;
}

std::string mpi_version() {
  char text[MPI_MAX_LIBRARY_VERSION_STRING];
  int length = 0;
  MPI_Get_library_version(text, &length);
  const std::string version(text, length);
  return version.substr(0, version.find(','));
}

} // namespace

std::string provenance(const std::string &folder) {
  utsname system{};
  uname(&system);
  std::error_code error;
  const nlohmann::ordered_json about{{"command", own_words()},
                                     {"in_folder", std::filesystem::current_path(error).string()},
                                     {"results", folder},
                                     {"started", now()},
                                     {"machine", system.nodename},
                                     {"processor", processor()},
                                     {"cores", std::thread::hardware_concurrency()},
                                     {"system", std::string(system.sysname) + " " + system.release},
                                     {"heartbus", HEARTBUS_VERSION},
                                     {"compiler", HEARTBUS_COMPILER},
                                     {"deal.II", HEARTBUS_DEALII},
                                     {"MPI", mpi_version()}};
  return about.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

} // namespace heartbus::coupler
