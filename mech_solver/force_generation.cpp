#include "mech_solver/force_generation.h"

namespace heartbus::mech {

ForceGeneration::ForceGeneration(const ActiveParameters &parameters, unsigned n_nodes)
    : parameters_(parameters), n_nodes_(n_nodes) {
  if (parameters.model == "none" || parameters.model == "prescribed")
    return;
  model_ = make_active_model(parameters.model);
  n_states_ = model_->n_states();
  const std::vector<double> rest = model_->initial_state();
  for (unsigned node = 0; node < n_nodes; ++node)
    s_n_.insert(s_n_.end(), rest.begin(), rest.end());
  s_ = s_n_;
}

void ForceGeneration::advance(double dt, const double *calcium, const double *stretch) {
  s_ = s_n_;
  n_clamped_ = 0;
  for (unsigned node = 0; node < n_nodes_ && model_; ++node)
    if (calcium[node] >= 0) {
      const double sarcomere_length = parameters_.sarcomere_length * stretch[node];
      n_clamped_ += model_->clamps(sarcomere_length);
      model_->advance(dt, calcium[node], sarcomere_length, s_.data() + node * n_states_);
    }
}

void ForceGeneration::visit(io::State &state) {
  if (model_)
    state.field("active_states", n_states_, s_n_.data());
  s_ = s_n_;
}

void ForceGeneration::tension(const std::vector<double> &states, double time, double *values) const {
  const double uniform = parameters_.model == "prescribed" ? parameters_.tension.at(time) : 0;
  for (unsigned node = 0; node < n_nodes_; ++node)
    values[node] = model_ ? parameters_.tension_max * model_->permissivity(states.data() + node * n_states_) : uniform;
}

} // namespace heartbus::mech
