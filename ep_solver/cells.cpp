#include "ep_solver/cells.h"

#include <algorithm>

namespace heartbus::ep {

using fem::VectorizedDouble;

Cells::Cells(const IonicModel &model, Integrator integrator, unsigned n_nodes)
    : model_(model), integrator_(integrator), I_ion_(n_nodes), curvature_(n_nodes), error_(n_nodes) {}

void Cells::begin_step(const std::vector<VectorizedDouble> &states_n, const double *v, double step,
                       const std::vector<char> &is_fast) {
  const unsigned n_nodes = curvature_.size();
  std::fill(curvature_.begin(), curvature_.end(), 0);
  fast_.clear();
  for (unsigned node = 0; node < n_nodes; ++node)
    if (is_fast[node])
      fast_.push_back(node);
  fast_v_.resize(fast_.size());
  fast_I_ion_.resize(fast_.size());
  model_.gather(fast_, states_n, fast_states_);
  states_.resize(states_n.size());
  if (fast_.size() == n_nodes)
    return;
  model_.step(integrator_, n_nodes, v, states_n.data(), states_.data(), step, I_ion_.data(), error_.data());
  for (unsigned node = 0; node < n_nodes; ++node)
    if (!is_fast[node])
      curvature_[node] = error_[node] / (step * step);
}

void Cells::substep(const double *v, double dt, double *I_ion) {
  for (std::size_t k = 0; k < fast_.size(); ++k)
    fast_v_[k] = v[fast_[k]];
  model_.step(integrator_, fast_.size(), fast_v_.data(), fast_states_.data(), fast_states_.data(), dt,
              fast_I_ion_.data(), error_.data());
  std::copy(I_ion_.begin(), I_ion_.end(), I_ion);
  for (std::size_t k = 0; k < fast_.size(); ++k) {
    I_ion[fast_[k]] = fast_I_ion_[k];
    curvature_[fast_[k]] = std::max(curvature_[fast_[k]], error_[k] / (dt * dt));
  }
}

void Cells::end_step(std::vector<VectorizedDouble> &states_np1) const {
  states_np1 = states_;
  model_.scatter(fast_, fast_states_, states_np1);
}

} // namespace heartbus::ep
