/* The participants of benchmark_bus through the C interface:
 *   p=build/release/bin/benchmark_echo; mpirun -n 1 build/release/bin/benchmark_bus : -n 2 $p a : -n 2 $p b */
#include "api/heartbus.h"

#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void declare(heartbus_bus *bus, int is_a, int rank, int size) {
  int split = is_a ? size / 2 : size / 3, first = rank == 0 ? 0 : split, n = (rank == 0 ? split : size) - first;
  double *points = malloc(3 * sizeof(double) * n);
  for (int i = 0; i < n; ++i) {
    int p = is_a ? first + i : size - 1 - first - i;
    points[3 * i] = 1e-3 * (p % 50);
    points[3 * i + 1] = 1e-3 * (p / 50 % 50);
    points[3 * i + 2] = 1e-3 * (p / 2500);
  }
  char set[32], field[32];
  snprintf(set, sizeof set, "points_%d", size);
  snprintf(field, sizeof field, "field_%d", size);
  heartbus_points(bus, set, n, points, 1e-3);
  double *sent = heartbus_output(bus, field, set, 3, "m");
  if (sent)
    memcpy(sent, points, 3 * sizeof(double) * n);
  heartbus_input(bus, field, set, 3, "m");
  free(points);
}

int main(int argc, char **argv) {
  const int is_a = argc > 1 && argv[1][0] == 'a';
  heartbus_bus *bus;
  int code = heartbus_join(&bus, is_a ? "a" : "b", "benchmark_bus"), rank;
  if (code)
    return code;
  MPI_Comm_rank(MPI_Comm_f2c(heartbus_communicator(bus)), &rank);
  for (int size = 1000; size <= 100000; size *= 10)
    declare(bus, is_a, rank, size);
  heartbus_task(bus, "start");
  heartbus_task(bus, "stop");
  double *seconds = heartbus_scalar(bus, "seconds", "s", HEARTBUS_FIRST), start = 0;
  heartbus_order order;
  while (heartbus_next(bus, &order))
    if (order.what == HEARTBUS_TASK && strcmp(order.text, "start") == 0)
      start = MPI_Wtime();
    else if (order.what == HEARTBUS_TASK)
      *seconds = MPI_Wtime() - start;
  return heartbus_leave(bus);
}
