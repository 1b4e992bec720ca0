#include "common/bus/shared_memory.h"

#include <gtest/gtest.h>
#include <memory>
#include <sys/wait.h>
#include <unistd.h>

using heartbus::bus::SharedMemory;

namespace {

constexpr std::size_t size = 10000; // bytes: three pages

/// What another process does with the memory, as its exit code.
template <class Work>
int of_another_process(const Work &work) {
  const pid_t child = fork();
  if (child == 0)
    _exit(work());
  int status = -1;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

} // namespace

TEST(SharedMemory, AnotherProcessReachesItByItsTicket) {
  const SharedMemory mine(size);
  EXPECT_EQ(mine.begin()[size - 1], 0);
  mine.begin()[0] = 17;
  const auto ticket = mine.ticket();
  EXPECT_EQ(of_another_process([&] {
              const SharedMemory reached(ticket);
              if (!reached.begin())
                return -1;
              reached.begin()[size - 1] = 23;
              return int(reached.begin()[0]);
            }),
            17);
  EXPECT_EQ(mine.begin()[size - 1], 23);
}

TEST(SharedMemory, IsNotReachedByTheTicketOfSomethingElse) {
  const SharedMemory mine(size);
  auto ticket = mine.ticket();
  ++ticket.stamp;
  EXPECT_EQ(SharedMemory(ticket).begin(), nullptr) << "another memory of the same number";
  ticket = mine.ticket();
  ticket.file = 1;
  EXPECT_EQ(SharedMemory(ticket).begin(), nullptr) << "standard output";
  ticket = mine.ticket();
  ticket.process = -5;
  EXPECT_EQ(SharedMemory(ticket).begin(), nullptr) << "no such process";
  EXPECT_EQ(SharedMemory(SharedMemory::Ticket{}).begin(), nullptr);
}

TEST(SharedMemory, OutlivesItsMaker) {
  auto mine = std::make_unique<SharedMemory>(size);
  const SharedMemory reached(mine->ticket());
  mine->begin()[5] = 42;
  mine.reset();
  EXPECT_EQ(reached.begin()[5], 42);
}
