#include "common/bus/pipe.h"

#include <algorithm>
#include <cstring>

namespace heartbus::bus {
namespace {

constexpr std::size_t header_size = sizeof(int) + sizeof(std::size_t); ///< tag, bytes of the content

/// In one or two pieces: the stream goes round.
template <class Copy>
void for_each_piece(std::uint32_t position, std::size_t n, const Copy &copy) {
  const std::size_t begin = position % Pipe::capacity, first = std::min<std::size_t>(n, Pipe::capacity - begin);
  copy(begin, 0, first);
  copy(0, first, n - first);
}

} // namespace

std::size_t Pipe::write(const char *bytes, std::size_t n) {
  const std::uint32_t position = n_written_;
  n = std::min<std::size_t>(n, capacity - (position - n_read_));
  for_each_piece(position, n, [&](std::size_t here, std::size_t from, std::size_t size) {
    std::copy_n(bytes + from, size, bytes_ + here);
  });
  n_written_ = position + static_cast<std::uint32_t>(n);
  return n;
}

std::size_t Pipe::read(char *bytes, std::size_t n) {
  const std::uint32_t position = n_read_;
  n = std::min<std::size_t>(n, n_written_ - position);
  for_each_piece(position, n, [&](std::size_t here, std::size_t to, std::size_t size) {
    std::copy_n(bytes_ + here, size, bytes + to);
  });
  n_read_ = position + static_cast<std::uint32_t>(n);
  return n;
}

void PipeWriter::post(int tag, Bytes content) {
  Packer header;
  header << tag << content.size();
  queue_.push_back(header.take());
  if (!content.empty())
    queue_.push_back(std::move(content));
}

bool PipeWriter::push() {
  bool has_written = false, wants_room = false;
  while (!queue_.empty()) {
    const Bytes &bytes = queue_.front();
    const std::size_t n = pipe_.write(bytes.data() + offset_, bytes.size() - offset_);
    has_written |= n > 0;
    offset_ += n;
    if (offset_ < bytes.size()) {
      if (wants_room && n == 0)
        break;
      wants_room = true;
      pipe_.want_room();
      continue; // the reader may have read before it could know
    }
    queue_.pop_front();
    offset_ = 0;
  }
  return has_written;
}

bool PipeReader::fill(Bytes &bytes) {
  n_filled_ += pipe_.read(bytes.data() + n_filled_, bytes.size() - n_filled_);
  return n_filled_ == bytes.size();
}

std::optional<Message> PipeReader::next() {
  if (!in_content_) {
    header_.resize(header_size);
    if (!fill(header_))
      return {};
    std::size_t size;
    std::memcpy(&size, header_.data() + sizeof(int), sizeof size);
    content_.assign(size, 0);
    n_filled_ = 0;
    in_content_ = true;
  }
  if (!fill(content_))
    return {};
  n_filled_ = 0;
  in_content_ = false;
  Message received;
  std::memcpy(&received.tag, header_.data(), sizeof received.tag);
  received.content = std::move(content_);
  return received;
}

} // namespace heartbus::bus
