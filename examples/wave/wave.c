/* A wave of calcium through the wall, in place of electrophysiology. */
#include <heartbus/heartbus.h>
#include <math.h>
#include <mpi.h>
#include <stdlib.h>

int main(void) {
  const double rest = 0.13, rise = 0.025, decay = 0.15; /* uM, s, s */
  double velocity = 0.6, peak = 0.8;                    /* m/s, uM */
  heartbus_bus *bus;
  int code = heartbus_join(&bus, "ep", "wave");
  if (code)
    return code;
  heartbus_setting(bus, "velocity", "m/s", &velocity);
  heartbus_setting(bus, "peak", "uM", &peak);

  heartbus_partner_points wall;
  heartbus_partner(bus, "mech", "tissue", &wall);
  MPI_Comm ranks = MPI_Comm_f2c(heartbus_communicator(bus));
  int rank, size;
  MPI_Comm_rank(ranks, &rank);
  MPI_Comm_size(ranks, &size);
  int first = (long)wall.n_points * rank / size, n = (long)wall.n_points * (rank + 1) / size - first;
  heartbus_points(bus, "tissue", n, wall.points + 3 * first, wall.spacing);
  double *calcium = heartbus_output(bus, "calcium", "tissue", 1, "uM");
  double *highest = heartbus_scalar(bus, "highest_calcium", "uM", HEARTBUS_MAX);

  double apex = INFINITY;
  for (int i = 0; i < wall.n_points; ++i)
    apex = fmin(apex, wall.points[3 * i + 2]);
  heartbus_order order;
  while (heartbus_next(bus, &order)) {
    if (order.what != HEARTBUS_SOLVE && order.what != HEARTBUS_LOAD)
      continue;
    *highest = 0;
    for (int i = 0; i < n; ++i) {
      double activation = (wall.points[3 * (first + i) + 2] - apex) / velocity; /* from the apex upwards */
      double t = fmax(order.time - activation, 0);
      calcium[i] = rest + (peak - rest) * (1 - exp(-t / rise)) * exp(-t / decay);
      *highest = fmax(*highest, calcium[i]);
    }
  }
  return heartbus_leave(bus);
}
