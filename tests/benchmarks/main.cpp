// Benchmarks of the kernels on one core, each beside what the machine allows:
//   build/release/bin/benchmark_kernels [--benchmark_filter=guccione]
#include "common/fem/runtime.h"

#include <benchmark/benchmark.h>
#include <mpi.h>

int main(int argc, char **argv) {
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
