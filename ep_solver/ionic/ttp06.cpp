#include "ep_solver/ionic/ttp06.h"

#include "ep_solver/ionic/ionic_model.h"

#include <algorithm>

namespace heartbus::ep {

namespace {

using namespace ttp06;
using fem::n_lanes;
using fem::VectorizedDouble;

/// v [mV], then the states in the order of ttp06::State.
using Row = std::array<double, 1 + n_states>;

struct InitialStates {
  Row published;   ///< of the CellML versions of the model
  Row limit_cycle; ///< beat 800 at a cycle length of 800 ms, recomputed by `prepace ttp06_...`
};

const InitialStates epi_states{{-85.23, 0.00621, 0.4712, 0.0095, 0.00172, 0.7444, 0.7045, 3.373e-5, 0.7888, 0.9755,
                                0.9953, 0.999998, 2.42e-8, 1.26e-4, 3.64, 3.6e-4, 0.9073, 8.604, 136.89},
                               {-85.1248391, 0.000260079027, 0.470084054, 0.00357595402, 0.00175414033, 0.741960212,
                                0.739085273, 3.41984092e-05, 0.93916143, 0.998433861, 0.999819289, 0.999997794,
                                2.45972904e-08, 0.000115520872, 3.96989847, 0.000255632624, 0.974708807, 10.6742934,
                                134.209452}};
const InitialStates endo_states{{-86.709, 0.00448, 0.476, 0.0087, 0.00155, 0.7573, 0.7225, 3.164e-5, 0.8009, 0.9778,
                                 0.9953, 0.3212, 2.235e-8, 1.3e-4, 3.715, 3.6e-4, 0.9068, 10.355, 138.4},
                                {-85.784446, 0.000218695436, 0.476935629, 0.00343140807, 0.0015246972, 0.759755108,
                                 0.757548433, 3.13192919e-05, 0.939561256, 0.998479371, 0.999814616, 0.532016878,
                                 2.203641e-08, 0.000113044633, 3.8583592, 0.000250790411, 0.974608811, 10.434665,
                                 137.733289}};
const InitialStates mid_states{{-85.423, 0.0165, 0.473, 0.0174, 0.00165, 0.749, 0.6788, 3.288e-5, 0.7026, 0.9526,
                                0.9942, 0.999998, 2.347e-8, 1.53e-4, 4.272, 4.2e-4, 0.8978, 10.132, 138.52},
                               {-85.6292714, 0.000378321748, 0.475321327, 0.00432845473, 0.00157587754, 0.75561118,
                                0.749789863, 3.19743681e-05, 0.896211141, 0.996227257, 0.999738869, 0.999998005,
                                2.26167641e-08, 0.000126019073, 4.53301642, 0.000280376981, 0.970978292, 10.019444,
                                137.981954}};

constexpr unsigned chunk = 8;     ///< blocks whose states stay in the innermost cache
constexpr double scale_Ca_ss = 1; ///< [mM], half of what a beat reaches

struct Chunk {
  std::array<VectorizedDouble, chunk> v_mV;
  std::array<States<VectorizedDouble>, chunk> y_n, y_middle, y_np1;
  std::array<Outcome<VectorizedDouble>, chunk> outcomes;
};

HEARTBUS_INLINE void fill(Chunk &c, unsigned n_nodes, unsigned n_blocks, const double *v,
                          const VectorizedDouble *states_n) {
  for (unsigned node = 0; node < n_blocks * n_lanes; ++node)
    c.v_mV[node / n_lanes][node % n_lanes] = 1e3 * v[std::min(node, n_nodes - 1)];
  std::copy_n(states_n, n_blocks * n_kept, c.y_n.front().begin());
}

HEARTBUS_INLINE void empty(const Chunk &c, unsigned n_nodes, unsigned n_blocks, VectorizedDouble *states_np1,
                           double *i_ion, double *error) {
  std::copy_n(c.y_np1.front().begin(), n_blocks * n_kept, states_np1);
  for (unsigned node = 0; node < n_nodes; ++node) {
    i_ion[node] = c.outcomes[node / n_lanes].I_ion[node % n_lanes];
    error[node] = c.outcomes[node / n_lanes].error[node % n_lanes] / scale_Ca_ss;
  }
}

/// The two parts of a step in loops of their own: in one, the code is more than a processor keeps of decoded
/// instructions.
HEARTBUS_SIMD void euler_chunk(const CellType &cell, unsigned n_nodes, const double *v,
                               const VectorizedDouble *states_n, VectorizedDouble *states_np1, double dt, double *i_ion,
                               double *error) {
  Chunk c;
  const unsigned n_blocks = (n_nodes + n_lanes - 1) / n_lanes;
  fill(c, n_nodes, n_blocks, v, states_n);
  for (unsigned block = 0; block < n_blocks; ++block)
    step_gates(cell, c.v_mV[block], c.y_n[block], c.y_np1[block], 1e3 * dt);
  for (unsigned block = 0; block < n_blocks; ++block)
    c.outcomes[block] = finish_step(cell, c.v_mV[block], c.y_n[block], c.y_np1[block], 1e3 * dt);
  empty(c, n_nodes, n_blocks, states_np1, i_ion, error);
}

HEARTBUS_SIMD void midpoint_chunk(const CellType &cell, unsigned n_nodes, const double *v,
                                  const VectorizedDouble *states_n, VectorizedDouble *states_np1, double dt,
                                  double *i_ion, double *error) {
  Chunk c;
  const unsigned n_blocks = (n_nodes + n_lanes - 1) / n_lanes;
  fill(c, n_nodes, n_blocks, v, states_n);
  for (unsigned block = 0; block < n_blocks; ++block)
    step_gates_midpoint(cell, c.v_mV[block], c.y_n[block], c.y_middle[block], c.y_np1[block], 1e3 * dt);
  for (unsigned block = 0; block < n_blocks; ++block)
    c.outcomes[block] =
        finish_step_midpoint(cell, c.v_mV[block], c.y_n[block], c.y_middle[block], c.y_np1[block], 1e3 * dt);
  empty(c, n_nodes, n_blocks, states_np1, i_ion, error);
}

class TTP06 : public IonicModel {
 public:
  TTP06(const CellType &cell, const InitialStates &initial, double front_speed)
      : cell_(cell), initial_(initial), front_speed_(front_speed) {}

  unsigned n_states() const override { return ttp06::n_states; }
  unsigned n_kept() const override { return ttp06::n_kept; }
  unsigned calcium_state() const override { return Ca_i; }
  double calcium_to_micromolar() const override { return 1e3; }
  double front_speed() const override { return front_speed_; }

  CellState initial_state(const std::string &kind) const override {
    const Row &row = kind == "published" ? initial_.published : initial_.limit_cycle;
    CellState cell{1e-3 * row[0], {row.begin() + 1, row.end()}};
    cell.states.resize(n_kept()); // the rates are zero
    return cell;
  }

  void step(Integrator integrator, std::size_t n_nodes, const double *v, const VectorizedDouble *states_n,
            VectorizedDouble *states_np1, double dt, double *i_ion, double *error) const override {
    const auto step_chunk = integrator == Integrator::imex_euler ? euler_chunk : midpoint_chunk;
    for (std::size_t first = 0; first < n_nodes; first += chunk * n_lanes) {
      const std::size_t states = first / n_lanes * n_kept();
      const unsigned n = std::min<std::size_t>(chunk * n_lanes, n_nodes - first);
      step_chunk(cell_, n, v + first, states_n + states, states_np1 + states, dt, i_ion + first, error + first);
    }
  }

  double step_cell(Integrator integrator, double v, std::vector<double> &states, double dt,
                   double i_app) const override {
    States<double> y_n, y_middle, y_np1;
    std::copy_n(states.begin(), n_kept(), y_n.begin());
    double I;
    if (integrator == Integrator::imex_euler) {
      step_gates(cell_, 1e3 * v, y_n, y_np1, 1e3 * dt);
      I = finish_step(cell_, 1e3 * v, y_n, y_np1, 1e3 * dt, i_app).I_ion;
    } else {
      step_gates_midpoint(cell_, 1e3 * v, y_n, y_middle, y_np1, 1e3 * dt);
      I = finish_step_midpoint(cell_, 1e3 * v, y_n, y_middle, y_np1, 1e3 * dt, i_app).I_ion;
    }
    std::copy_n(y_np1.begin(), n_kept(), states.begin());
    return I;
  }

 private:
  const CellType &cell_;
  const InitialStates &initial_;
  const double front_speed_;
};

} // namespace

std::unique_ptr<IonicModel> make_ttp06_epi() { return std::make_unique<TTP06>(epi, epi_states, 62.2); }
std::unique_ptr<IonicModel> make_ttp06_endo() { return std::make_unique<TTP06>(endo, endo_states, 62.8); }
std::unique_ptr<IonicModel> make_ttp06_mid() { return std::make_unique<TTP06>(mid, mid_states, 62.9); }

} // namespace heartbus::ep
