// On 2 ranks.
#include "common/fem/time_history.h"

#include "common/geometry/mesh_tools.h"
#include "mpi_test_main.h"

using namespace heartbus;

namespace {

struct Field {
  fem::LagrangeSpace space{MPI_COMM_WORLD, geometry::make_box({0, 0, 0}, {1, 1, 1}, {2, 2, 2})};
  /// (1 + x) t^degree at each node.
  fem::Vector at(double t, int degree) const {
    fem::Vector x = space.make_vector(1);
    for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
      x.local_element(node) = (1 + space.points()[node][0]) * std::pow(t, degree);
    return x;
  }
  double difference(const fem::Vector &x, const fem::Vector &y) const {
    fem::Vector z(x);
    z -= y;
    return z.linfty_norm();
  }
};

} // namespace

TEST(TimeHistory, ThroughStatesOfAPolynomialItExtrapolatesExactly) {
  const Field field;
  for (const unsigned depth : {2u, 3u, 4u}) {
    fem::TimeHistory past(depth, field.at(0, 0));
    for (const int degree : {int(depth) - 1, int(depth)}) {
      for (unsigned n = 0; n < depth; ++n)
        past.push(field.at(n, degree));
      EXPECT_EQ(field.difference(past[0], field.at(depth - 1, degree)), 0);
      EXPECT_EQ(field.difference(past[depth - 1], field.at(0, degree)), 0);
      fem::Vector next = field.at(0, 0);
      past.extrapolate(next);
      const double missed = field.difference(next, field.at(depth, degree));
      if (degree < int(depth))
        EXPECT_LT(missed, 1e-13);
      else // the derivative of this order, once: depth! (1 + x)
        EXPECT_NEAR(missed, 2 * std::tgamma(depth + 1), 1e-11);
    }
  }
}

TEST(TimeHistory, AfterAJumpItStaysAndThenFollowsTheLine) {
  const Field field;
  fem::TimeHistory past(3, field.at(0, 0));
  past.fill(field.at(5, 1));
  past.push(field.at(7, 1));
  past.forget();
  fem::Vector next = field.at(0, 0);
  past.extrapolate(next);
  EXPECT_LT(field.difference(next, field.at(7, 1)), 1e-13);
  past.push(field.at(8, 1));
  past.straighten();
  past.extrapolate(next);
  EXPECT_LT(field.difference(next, field.at(9, 1)), 1e-13);
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
