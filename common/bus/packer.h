#pragma once

#include <cstring>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace heartbus::bus {

using Bytes = std::vector<char>;

/// Writes numbers, texts and vectors of them one after another; no names, no alignment, native byte order.
class Packer {
 public:
  template <class T>
  Packer &operator<<(const T &value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.resize(bytes_.size() + sizeof(T));
    std::memcpy(bytes_.data() + bytes_.size() - sizeof(T), &value, sizeof(T));
    return *this;
  }
  Packer &operator<<(const std::string &text) {
    *this << text.size();
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    return *this;
  }
  template <class T>
  Packer &operator<<(const std::vector<T> &values) {
    *this << values.size();
    for (const T &value : values)
      *this << value;
    return *this;
  }
  Bytes take() { return std::move(bytes_); }

 private:
  Bytes bytes_;
};

/// Reads in the order in which the Packer wrote.
class Unpacker {
 public:
  explicit Unpacker(Bytes bytes) : bytes_(std::move(bytes)) {}

  template <class T>
  Unpacker &operator>>(T &value) & {
    static_assert(std::is_trivially_copyable_v<T>);
    std::memcpy(&value, next(sizeof(T)), sizeof(T));
    return *this;
  }
  Unpacker &operator>>(std::string &text) & {
    const auto size = read<std::size_t>();
    const char *begin = next(size);
    text.assign(begin, begin + size);
    return *this;
  }
  template <class T>
  Unpacker &operator>>(std::vector<T> &values) & {
    values.assign(read<std::size_t>(), T());
    for (T &value : values)
      *this >> value;
    return *this;
  }
  template <class T>
  T read() {
    T value;
    *this >> value;
    return value;
  }

 private:
  const char *next(std::size_t size) {
    if (size > bytes_.size() - position_)
      throw std::runtime_error("a message of the bus is shorter than its content");
    position_ += size;
    return bytes_.data() + position_ - size;
  }
  Bytes bytes_;
  std::size_t position_ = 0;
};

/// The message that `bytes` consists of.
template <class T>
T unpack(Bytes bytes) {
  Unpacker unpacker(std::move(bytes));
  T message;
  unpacker >> message;
  return message;
}

} // namespace heartbus::bus
