#include "common/bus/pipe.h"

#include <gtest/gtest.h>
#include <memory>
#include <numeric>
#include <thread>

using namespace heartbus::bus;

namespace {

Bytes numbered(std::size_t n) {
  Bytes bytes(n);
  std::iota(bytes.begin(), bytes.end(), char(n));
  return bytes;
}

} // namespace

TEST(Pipe, TakesNoMoreThanThereIsRoomFor) {
  const auto pipe = std::make_unique<Pipe>();
  const Bytes bytes = numbered(Pipe::capacity + 5);
  EXPECT_EQ(pipe->write(bytes.data(), bytes.size()), Pipe::capacity);
  EXPECT_EQ(pipe->write(bytes.data(), 1), 0);
  Bytes out(7);
  EXPECT_EQ(pipe->read(out.data(), out.size()), out.size());
  EXPECT_EQ(out, Bytes(bytes.begin(), bytes.begin() + 7));
  EXPECT_EQ(pipe->write(bytes.data(), bytes.size()), 7);
}

TEST(Pipe, CarriesLettersOfAnyLengthInOrder) {
  const auto pipe = std::make_unique<Pipe>();
  const std::vector<std::size_t> sizes{0, 1, 100, Pipe::capacity - 12, 3 * Pipe::capacity, 0, 50000, 2};
  std::thread sender([&] {
    PipeWriter writer(*pipe);
    for (std::size_t k = 0; k < 50 * sizes.size(); ++k)
      writer.post(static_cast<int>(k), numbered(sizes[k % sizes.size()]));
    while (!writer.empty())
      if (!writer.push())
        std::this_thread::yield();
  });
  PipeReader reader(*pipe);
  for (std::size_t k = 0; k < 50 * sizes.size(); ++k) {
    std::optional<Message> letter;
    while (!(letter = reader.next()))
      std::this_thread::yield();
    ASSERT_EQ(letter->tag, int(k));
    ASSERT_EQ(letter->content, numbered(sizes[k % sizes.size()]));
  }
  sender.join();
  EXPECT_FALSE(reader.next());
}
