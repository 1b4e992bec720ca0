#pragma once

#include "common/base/failure.h"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

/// What libFuzzer calls with each input; inputs are refused by Failure, anything else that is thrown is a fault.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size);

namespace heartbus {

inline std::string text_of(const std::uint8_t *data, std::size_t size) {
  return {reinterpret_cast<const char *>(data), size};
}

/// A folder of this process, in memory where there is such a thing.
inline std::filesystem::path own_folder() {
  namespace fs = std::filesystem;
  static const fs::path folder = (fs::is_directory("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path()) /
                                 ("heartbus_fuzz_" + std::to_string(getpid()));
  fs::create_directories(folder);
  return folder;
}

inline void write(const std::filesystem::path &file, const std::string &text) {
  std::ofstream(file, std::ios::binary) << text;
}

} // namespace heartbus
