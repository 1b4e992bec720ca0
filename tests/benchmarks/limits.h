#pragma once

#include <benchmark/benchmark.h>

/// What this machine can do on one core, measured when first asked for: no part of the program can be faster than the
/// time its data need to move or its arithmetic needs at these rates.
namespace heartbus::benchmarks {

/// Bytes a second of a = b + s c over arrays that no private cache holds (McCalpin's STREAM triad, writes counted
/// twice: a line is read before it is written).
double bandwidth();

/// Floating-point operations a second of independent fused multiply-adds, in the widest vectors there are.
double peak_rate();

/// What one iteration of a benchmark deals with. Bytes: what must at least come from or go to memory; flops:
/// additions and multiplications.
struct Work {
  double items = 1, bytes = 0, flops = 0;
};

/// Adds the counters: CPU time an item [us], the limit for it, and how many times the limit the time is.
void compare_with_limit(benchmark::State &state, const Work &work);

} // namespace heartbus::benchmarks
