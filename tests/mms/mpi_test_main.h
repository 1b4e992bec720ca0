#pragma once

#include "common/fem/runtime.h"

#include <gtest/gtest.h>
#include <mpi.h>

/// Runs all tests of the file on every rank; only rank 0 prints unless another rank fails.
inline int run_mpi_tests(int argc, char **argv) {
  MPI_Init(&argc, &argv);
  ::testing::InitGoogleTest(&argc, argv);
  int rank = 0, failed = 0, any_failed = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank != 0)
    ::testing::GTEST_FLAG(brief) = true;
  {
    heartbus::fem::Runtime runtime(MPI_COMM_WORLD);
    failed = RUN_ALL_TESTS();
  }
  MPI_Allreduce(&failed, &any_failed, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  MPI_Finalize();
  return any_failed;
}
