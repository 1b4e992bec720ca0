#include "ep_solver/ionic/bueno_orovio.h"

#include "ep_solver/ionic/ionic_model.h"

#include <algorithm>

namespace heartbus::ep {

namespace {

using namespace bueno_orovio;
using fem::n_lanes;
using fem::VectorizedDouble;

constexpr double amplitude = 85.7e-3, rest = -84e-3; // V = amplitude u + rest [V]
constexpr double per_ms = 1e3;                       // 1/s

/// v [V], then the states in the order of bueno_orovio::State.
using Row = std::array<double, 1 + n_states>;

/// All nodes, by either step.
template <class Step>
HEARTBUS_INLINE void step_all(std::size_t n_nodes, const double *v, const VectorizedDouble *states_n,
                              VectorizedDouble *states_np1, double *i_ion, double *error, const Step &step) {
  for (std::size_t first = 0; first < n_nodes; first += n_lanes, states_n += n_kept, states_np1 += n_kept) {
    VectorizedDouble u;
    States<VectorizedDouble> y_n, y_np1;
    for (unsigned lane = 0; lane < n_lanes; ++lane)
      u[lane] = (v[std::min(first + lane, n_nodes - 1)] - rest) * (1 / amplitude);
    std::copy_n(states_n, n_kept, y_n.begin());
    const Outcome<VectorizedDouble> outcome = step(u, y_n, y_np1);
    std::copy_n(y_np1.begin(), n_kept, states_np1);
    for (std::size_t node = first; node < std::min(first + n_lanes, n_nodes); ++node) {
      i_ion[node] = amplitude * per_ms * outcome.current[node % n_lanes];
      error[node] = outcome.error[node % n_lanes];
    }
  }
}

HEARTBUS_SIMD void euler(const CellType &cell, std::size_t n_nodes, const double *v, const VectorizedDouble *states_n,
                         VectorizedDouble *states_np1, double dt, double *i_ion, double *error) {
  step_all(
      n_nodes, v, states_n, states_np1, i_ion, error,
      [&](const VectorizedDouble &u, const States<VectorizedDouble> &y_n, States<VectorizedDouble> &y_np1)
          __attribute__((always_inline)) { return step_euler(cell, u, y_n, y_np1, per_ms * dt); });
}

HEARTBUS_SIMD void midpoint(const CellType &cell, std::size_t n_nodes, const double *v,
                            const VectorizedDouble *states_n, VectorizedDouble *states_np1, double dt, double *i_ion,
                            double *error) {
  step_all(
      n_nodes, v, states_n, states_np1, i_ion, error,
      [&](const VectorizedDouble &u, const States<VectorizedDouble> &y_n, States<VectorizedDouble> &y_np1)
          __attribute__((always_inline)) { return step_midpoint(cell, u, y_n, y_np1, per_ms * dt); });
}

class BuenoOrovio : public IonicModel {
 public:
  BuenoOrovio(const CellType &cell, double front_speed, const Row &limit_cycle)
      : cell_(cell), front_speed_(front_speed), limit_cycle_(limit_cycle) {}

  unsigned n_states() const override { return bueno_orovio::n_states; }
  unsigned n_kept() const override { return bueno_orovio::n_kept; }
  unsigned calcium_state() const override { return Ca; }
  double calcium_to_micromolar() const override { return 1; }
  double front_speed() const override { return front_speed_; }

  CellState initial_state(const std::string &kind) const override {
    const Row row = kind == "published" ? Row{rest, 1, 1, 0, 1, cell_.calcium_rest} : limit_cycle_;
    CellState cell{row[0], {row.begin() + 1, row.end()}};
    cell.states.resize(n_kept()); // the rate is zero
    return cell;
  }

  void step(Integrator integrator, std::size_t n_nodes, const double *v, const VectorizedDouble *states_n,
            VectorizedDouble *states_np1, double dt, double *i_ion, double *error) const override {
    (integrator == Integrator::imex_euler ? euler : midpoint)(cell_, n_nodes, v, states_n, states_np1, dt, i_ion,
                                                              error);
  }

  /// No ion carries the applied current: the model has none.
  double step_cell(Integrator integrator, double v, std::vector<double> &states, double dt, double) const override {
    States<double> y_n, y_np1;
    std::copy_n(states.begin(), n_kept(), y_n.begin());
    const double u = (v - rest) * (1 / amplitude);
    const double J = integrator == Integrator::imex_euler ? step_euler(cell_, u, y_n, y_np1, per_ms * dt).current
                                                          : step_midpoint(cell_, u, y_n, y_np1, per_ms * dt).current;
    std::copy_n(y_np1.begin(), n_kept(), states.begin());
    return amplitude * per_ms * J;
  }

 private:
  const CellType &cell_;
  const double front_speed_;
  const Row limit_cycle_; ///< after 800 beats of 800 ms, by `prepace bueno_orovio_...`
};

} // namespace

std::unique_ptr<IonicModel> make_bueno_orovio_epi() {
  return std::make_unique<BuenoOrovio>(
      epi, 73.8, Row{-0.0838577267, 0.999806824, 0.972142577, 0.0217015592, 0.995086007, 0.115520304});
}
std::unique_ptr<IonicModel> make_bueno_orovio_endo() {
  return std::make_unique<BuenoOrovio>(
      endo, 79.2, Row{-0.0838317698, 0.999306272, 0.927084491, 0.0217285808, 0.995587252, 0.113044606});
}
std::unique_ptr<IonicModel> make_bueno_orovio_mid() {
  return std::make_unique<BuenoOrovio>(
      mid, 90.9, Row{-0.0838337698, 0.993952507, 0.766452581, 0.0217266361, 0.983509808, 0.126018864});
}

} // namespace heartbus::ep
