// Benchmarks of the kernels on one core, each beside what the machine allows:
//   build/release/bin/benchmark_kernels [--benchmark_filter=guccione]
// or those limits alone, bandwidth [B/s] and peak rate [1/s]:
//   build/release/bin/benchmark_kernels --limits
#include "common/fem/runtime.h"

#include "tests/benchmarks/limits.h"

#include <benchmark/benchmark.h>
#include <cstdio>
#include <cstring>
#include <mpi.h>

int main(int argc, char **argv) {
  if (argc == 2 && std::strcmp(argv[1], "--limits") == 0) {
    std::printf("%g %g\n", heartbus::benchmarks::bandwidth(), heartbus::benchmarks::peak_rate());
    return 0;
  }
  MPI_Init(&argc, &argv);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv))
    return 1;
  {
    heartbus::fem::Runtime runtime(MPI_COMM_WORLD);
    benchmark::RunSpecifiedBenchmarks();
  }
  MPI_Finalize();
}
