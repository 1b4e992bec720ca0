#include "mech_solver/prescribed_wall.h"

#include "common/base/failure.h"
#include "common/units/units.h"

#include <deal.II/base/mpi.h>

#include <cmath>

namespace heartbus::mech {

namespace {

constexpr double widest = -0.5, narrowest = 0.8; // lambda

double distance(const geometry::Point3 &a, const geometry::Point3 &b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// Of all ranks.
std::vector<geometry::Point3> all_points(const fem::LagrangeSpace &space, const std::vector<unsigned> &nodes) {
  std::vector<geometry::Point3> points;
  for (const auto &of_rank : dealii::Utilities::MPI::all_gather(space.communicator(), fem::owned_points(space, nodes)))
    for (std::size_t i = 0; i < of_rank.size(); i += 3)
      points.push_back({of_rank[i], of_rank[i + 1], of_rank[i + 2]});
  return points;
}

geometry::Point3 mean(const std::vector<geometry::Point3> &points) {
  geometry::Point3 sum{};
  for (const auto &point : points)
    for (unsigned i = 0; i < 3; ++i)
      sum[i] += point[i] / points.size();
  return sum;
}

double distance_from(const std::vector<geometry::Point3> &rim, const geometry::Point3 &point) {
  double smallest = INFINITY;
  for (const auto &other : rim)
    smallest = std::min(smallest, distance(point, other));
  return smallest;
}

std::string millilitres(double volume) { return config::shortest(std::round(1e7 * volume) / 10) + " mL"; }

/// Without the corners of a table that is linear in time: the cubic between entries whose slope there is the harmonic
/// mean of the slopes beside, and zero at extremes and ends; it lies between the entries (Fritsch and Butland, SIAM J.
/// Sci. Stat. Comput. 5 (1984) 300, doi:10.1137/0905021).
double monotone_cubic(const config::Table &table, double time) {
  const std::vector<double> &times = table.times, &values = table.values;
  const auto step = [&](std::size_t k) { return times[k + 1] - times[k]; };
  const auto secant = [&](std::size_t k) { return (values[k + 1] - values[k]) / step(k); };
  const auto slope = [&](std::size_t k) {
    if (k == 0 || k + 1 == times.size() || secant(k - 1) * secant(k) <= 0)
      return 0.;
    const double before = step(k) + 2 * step(k - 1), after = 2 * step(k) + step(k - 1);
    return (before + after) / (after / secant(k - 1) + before / secant(k));
  };
  const std::size_t next = std::upper_bound(times.begin(), times.end(), time) - times.begin();
  if (next == 0 || next == times.size())
    return next == 0 ? values.front() : values.back();
  const std::size_t k = next - 1;
  const double x = (time - times[k]) / step(k), y = 1 - x;
  return y * y * (1 + 2 * x) * values[k] + x * x * (1 + 2 * y) * values[k + 1] +
         step(k) * x * y * (y * slope(k) - x * slope(k + 1));
}

} // namespace

PrescribedWall::PrescribedWall(const fem::LagrangeSpace &space, const config::Table &volume)
    : space_(space), table_(volume), cavity_(space), interface_(space, 3), direction_(space.make_vector(3)),
      displacement_(interface_.values()) {
  find_direction();
  find_polynomial();
  check_table();
}

void PrescribedWall::find_direction() {
  const std::vector<geometry::Point3> rim = all_points(space_, cavity_.rim());
  if (rim.empty())
    throw Failure(ExitCode::scene, "mechanics: 'model: prescribed' needs an interface with a rim, which rests");
  geometry::Point3 centre = mean(rim), farthest = centre;
  double largest = 0;
  for (const auto &point : all_points(space_, interface_.nodes()))
    if (const double from_rim = distance_from(rim, point); from_rim > largest) {
      largest = from_rim;
      farthest = point;
    }
  for (const unsigned node : interface_.nodes()) {
    const geometry::Point3 &x = space_.points()[node];
    const double s = distance_from(rim, x) / largest;
    for (unsigned i = 0; i < 3; ++i)
      direction_.local_element(3 * node + i) = s * (2 - s) * ((centre[i] + farthest[i]) / 2 - x[i]);
  }
}

/// V = a_0 + a_1 lambda + a_2 lambda^2 + a_3 lambda^3 through the volumes at -h, 0, h and 2h.
void PrescribedWall::find_polynomial() {
  constexpr double h = 0.5;
  const auto at = [this](double lambda) {
    fem::Vector d(direction_);
    d *= lambda;
    return cavity_.volume(d);
  };
  const double middle = at(0), odd = (at(h) - at(-h)) / 2, even = (at(h) + at(-h)) / 2 - middle,
               cubic = ((at(2 * h) - middle - 4 * even) / 2 - odd) / 3;
  polynomial_ = {middle, (odd - cubic) / h, even / (h * h), cubic / (h * h * h)};
}

void PrescribedWall::check_table() const {
  constexpr int n = 100;
  for (int i = 0; i < n; ++i)
    if (volume_of(widest + (i + 1) * (narrowest - widest) / n) >= volume_of(widest + i * (narrowest - widest) / n))
      throw Failure(ExitCode::scene,
                    "mechanics: 'model: prescribed' does not suit the shape of this cavity: its volume "
                    "does not shrink while its wall moves inwards");
  for (const double value : table_.values)
    if (value >= volume_of(widest) || value <= volume_of(narrowest))
      throw Failure(ExitCode::scene, "key 'mechanics.cavity_volume': " + millilitres(value) +
                                         " cannot be reached; at rest the cavity has " + millilitres(polynomial_[0]) +
                                         ", and it goes from " + millilitres(volume_of(narrowest)) + " to " +
                                         millilitres(volume_of(widest)));
}

double PrescribedWall::volume_of(double lambda) const {
  return polynomial_[0] + lambda * (polynomial_[1] + lambda * (polynomial_[2] + lambda * polynomial_[3]));
}

/// By halving until nothing lies between.
double PrescribedWall::lambda_of(double volume) const {
  double wide = widest, narrow = narrowest;
  for (double middle; middle = (wide + narrow) / 2, middle != wide && middle != narrow;)
    (volume_of(middle) > volume ? wide : narrow) = middle;
  return narrow;
}

void PrescribedWall::declare(bus::Declaration &bus) {
  bus.point_set("interface", interface_.points(), space_.smallest_cell_size());
  bus.output("displacement", "interface", 3, "m", "n+1", displacement_);
  bus.task("inflate", [this](const bus::Step &step) { move(step.time); }); // in place of the wall's start
  bus.scalar("cavity_volume", "m^3", [this] { return volume_; });
}

void PrescribedWall::move(double time) {
  fem::Vector d(direction_);
  d *= lambda_of(monotone_cubic(table_, time));
  interface_.get(d, displacement_);
  volume_ = cavity_.volume(d);
}

} // namespace heartbus::mech
