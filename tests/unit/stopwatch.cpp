#include "common/bus/trace.h"

#include <gtest/gtest.h>
#include <thread>

using namespace heartbus::bus;

namespace {

void work(int milliseconds) { std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds)); }

} // namespace

TEST(Stopwatch, CountsForTheInnermostSectionOnly) {
  Stopwatch stopwatch;
  {
    const Stopwatch::Section outer(stopwatch, "outer");
    work(10);
    const Stopwatch::Section inner(stopwatch, "inner");
    work(40);
  }
  work(10); // outside
  const Seconds seconds = stopwatch.take();
  EXPECT_GE(seconds.at("outer"), 0.01);
  EXPECT_GE(seconds.at("inner"), 0.04);
  EXPECT_EQ(seconds.size(), 2u);
  EXPECT_TRUE(stopwatch.take().empty());
}

TEST(Stopwatch, WhatIsTakenWithinASectionIsNotCountedAgain) {
  Stopwatch stopwatch;
  const auto begin = std::chrono::steady_clock::now();
  Seconds sum;
  {
    const Stopwatch::Section section(stopwatch, "work");
    work(10);
    add(stopwatch.take(), sum);
    EXPECT_GE(total(sum), 0.01);
    work(10);
  }
  add(stopwatch.take(), sum);
  EXPECT_GE(total(sum), 0.02);
  EXPECT_LE(total(sum), std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
}

TEST(Stopwatch, TellsWhenSectionsEndInsideOut) {
  Stopwatch stopwatch;
  std::string parts;
  stopwatch.on_section = [&](const std::string &part, Stopwatch::Time begin, Stopwatch::Time end) {
    EXPECT_LE(begin, end);
    parts += part + " ";
  };
  {
    const Stopwatch::Section outer(stopwatch, "outer");
    { const Stopwatch::Section first(stopwatch, "first"); }
    const Stopwatch::Section second(stopwatch, "second");
  }
  EXPECT_EQ(parts, "first second outer ");
}

TEST(Trace, KeepsABoundedNumberOfSlices) {
  Trace trace;
  for (std::size_t i = 0; i < Trace::most_slices + 7; ++i)
    trace.add("solve", {}, {}, {3, 1, 0, 0});
  EXPECT_EQ(trace.slices.size(), Trace::most_slices);
  EXPECT_EQ(trace.n_dropped, 7u);
  EXPECT_EQ(trace.slices.back().step, 3);
}
