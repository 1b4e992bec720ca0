#include "ep_solver/ionic/ionic_model.h"
#include "ep_solver/ionic/ionic_models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace heartbus;

namespace {

/// A cable of tissue whose conductivity is 1 m^2/s, so that its length is in s^1/2: finite differences in space, v
/// and the cells at the middle of the step in time.
class Cable {
 public:
  Cable(const ep::IonicModel &model, double spacing, double dt)
      : model_(model), spacing_(spacing), dt_(dt), n_(std::lround(length / spacing) + 1), v_(n_), activation_(n_, -1) {
    const ep::CellState rest = model.initial_state("limit_cycle");
    states_ = model.uniform_states(n_, rest.states);
    std::fill(v_.begin(), v_.end(), rest.v);
    before_ = v_;
  }

  /// Between 0.4 and 0.8 of the length, where the front has found its speed and does not feel the end.
  double front_speed() {
    const unsigned first = 0.4 * n_, last = 0.8 * n_;
    for (double time = 0; activation_[last] < 0 && time < 0.05; time += dt_)
      step(time);
    return (last - first) * spacing_ / (activation_[last] - activation_[first]);
  }

 private:
  void step(double time) {
    std::vector<double> v(n_), I(n_), error(n_);
    for (unsigned k = 0; k < n_; ++k)
      v[k] = 1.5 * v_[k] - 0.5 * before_[k];
    model_.step(ep::Integrator::exponential_midpoint, n_, v.data(), states_.data(), states_.data(), dt_, I.data(),
                error.data());
    for (unsigned k = 0; k < n_; ++k) {
      const double stimulus = time < 2e-3 && k * spacing_ < 0.1 ? 50 : 0; // [V/s]
      v[k] = v_[k] + 0.5 * dt_ * (stimulus - I[k]);
    }
    diffuse(v);
    before_ = v_;
    for (unsigned k = 0; k < n_; ++k) {
      v_[k] = 2 * v[k] - before_[k];
      if (activation_[k] < 0 && before_[k] < 0 && v_[k] >= 0)
        activation_[k] = time - dt_ * before_[k] / (v_[k] - before_[k]);
    }
  }

  /// (1 - dt/2 d^2/dx^2) v = v, without flux at the ends; elimination.
  void diffuse(std::vector<double> &v) const {
    const double r = 0.5 * dt_ / (spacing_ * spacing_);
    std::vector<double> upper(n_);
    for (unsigned k = 0; k < n_; ++k) {
      const double lower = k > 0 ? -r : 0, diagonal = 1 + (k == 0 || k == n_ - 1 ? r : 2 * r);
      const double pivot = diagonal - (k > 0 ? lower * upper[k - 1] : 0);
      upper[k] = -r / pivot;
      v[k] = (v[k] - (k > 0 ? lower * v[k - 1] : 0)) / pivot;
    }
    for (unsigned k = n_ - 1; k-- > 0;)
      v[k] -= upper[k] * v[k + 1];
  }

  static constexpr double length = 1.1; // [s^1/2], 13 mm along fibres
  const ep::IonicModel &model_;
  double spacing_, dt_;
  unsigned n_;
  std::vector<double> v_, before_, activation_;
  std::vector<fem::VectorizedDouble> states_;
};

} // namespace

/// What the eikonal equation takes as the speed is that of the monodomain equation, extrapolated from two resolutions.
TEST(FrontSpeed, OfEachIonicModelIsThatOfACable) {
  std::vector<std::string> names;
#define HEARTBUS_NAME(name, make) names.emplace_back(name);
  HEARTBUS_IONIC_MODELS(HEARTBUS_NAME)
#undef HEARTBUS_NAME
  for (const std::string &name : names) {
    const auto model = ep::make_ionic_model(name);
    const double coarse = Cable(*model, 8e-3, 2e-5).front_speed(), fine = Cable(*model, 4e-3, 1e-5).front_speed();
    EXPECT_NEAR(model->front_speed(), fine + (fine - coarse) / 3, 0.004 * fine) << name;
  }
}
