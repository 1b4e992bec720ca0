#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

namespace heartbus::io {

/// 64-bit FNV-1a (Fowler, Noll, Vo): finds every damage but an intended one.
class Checksum {
 public:
  void add(const char *bytes, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i)
      sum_ = (sum_ ^ static_cast<unsigned char>(bytes[i])) * 0x100000001b3u;
  }
  std::string text() const {
    std::array<char, 17> text{};
    std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(sum_));
    return text.data();
  }

 private:
  std::uint64_t sum_ = 0xcbf29ce484222325u;
};

inline std::string checksum_of_file(const std::string &name) {
  std::ifstream in(name, std::ios::binary);
  std::vector<char> block(1 << 20);
  Checksum sum;
  do {
    in.read(block.data(), block.size());
    sum.add(block.data(), in.gcount());
  } while (in);
  return sum.text();
}

} // namespace heartbus::io
