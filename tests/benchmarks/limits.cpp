#include "tests/benchmarks/limits.h"

#include "common/simd/vectorized_double.h"

#include <algorithm>
#include <ctime>
#include <vector>

namespace heartbus::benchmarks {

namespace {

using fem::VectorizedDouble;

/// CPU time: the machine may be shared.
double now() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return time.tv_sec + 1e-9 * time.tv_nsec;
}

/// The shortest of several runs [s].
template <class Action>
double shortest(unsigned runs, const Action &action) {
  double best = 1e300;
  for (unsigned run = 0; run < runs; ++run) {
    const double start = now();
    action();
    best = std::min(best, now() - start);
  }
  return best;
}

HEARTBUS_SIMD void triad(std::size_t n, double *__restrict a, const double *__restrict b, const double *__restrict c) {
  for (std::size_t i = 0; i < n; ++i)
    a[i] = b[i] + 3 * c[i];
}

/// Twelve chains of multiply-adds: enough to hide their latency, few enough for the registers.
HEARTBUS_SIMD void multiply_add(unsigned n, const VectorizedDouble &factor, VectorizedDouble &total) {
  VectorizedDouble sums[12];
  for (unsigned k = 0; k < 12; ++k)
    sums[k] = fem::lanes(1e-3 * k);
  for (unsigned i = 0; i < n; ++i)
    for (unsigned k = 0; k < 12; ++k)
      sums[k] = sums[k] * factor + factor;
  for (const VectorizedDouble &sum : sums)
    total += sum;
}

} // namespace

double bandwidth() {
  static const double value = [] {
    constexpr std::size_t n = 1 << 23;
    std::vector<double> a(n), b(n, 1.), c(n, 2.);
    return 4 * sizeof(double) * n / shortest(10, [&] {
             triad(n, a.data(), b.data(), c.data());
             benchmark::ClobberMemory();
           });
  }();
  return value;
}

double peak_rate() {
  static const double value = [] {
    constexpr unsigned n = 1000000;
    return 2. * 12 * fem::n_lanes * n / shortest(10, [] {
             VectorizedDouble result{};
             multiply_add(n, fem::lanes(0.999), result);
             benchmark::DoNotOptimize(result);
           });
  }();
  return value;
}

void compare_with_limit(benchmark::State &state, const Work &work) {
  using benchmark::Counter;
  const double limit = std::max(work.bytes / bandwidth(), work.flops / peak_rate());
  const auto time_over = Counter::kIsIterationInvariantRate | Counter::kInvert;
  state.counters["us_per_item"] = Counter(1e-6 * work.items, time_over);
  state.counters["limit_us"] = Counter(1e6 * limit / work.items);
  state.counters["times_limit"] = Counter(limit, time_over);
}

namespace {

void machine(benchmark::State &state) {
  for (auto _ : state)
    benchmark::DoNotOptimize(bandwidth() + peak_rate());
  state.counters["GB_per_s"] = 1e-9 * bandwidth();
  state.counters["Gflop_per_s"] = 1e-9 * peak_rate();
}
BENCHMARK(machine)->Iterations(1);

} // namespace

} // namespace heartbus::benchmarks
