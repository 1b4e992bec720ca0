#pragma once

#include "common/fem/runtime.h"

#include <gtest/gtest.h>
#include <iostream>
#include <mpi.h>

/// Other ranks than 0 print their failures only.
class FailurePrinter : public ::testing::EmptyTestEventListener {
  void OnTestPartResult(const ::testing::TestPartResult &result) override {
    if (result.failed())
      std::cout << result.file_name() << ":" << result.line_number() << ": " << result.message() << std::endl;
  }
};

/// Runs all tests of the file on every rank; fails when any rank fails.
inline int run_mpi_tests(int argc, char **argv) {
  MPI_Init(&argc, &argv);
  ::testing::InitGoogleTest(&argc, argv);
  int rank = 0, failed = 0, any_failed = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank != 0) {
    auto &listeners = ::testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_result_printer());
    listeners.Append(new FailurePrinter);
  }
  {
    heartbus::fem::Runtime runtime(MPI_COMM_WORLD);
    failed = RUN_ALL_TESTS();
  }
  MPI_Allreduce(&failed, &any_failed, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  MPI_Finalize();
  return any_failed;
}
