#include "ep_solver/ionic/ionic_model.h"

#include "common/base/failure.h"
#include "ep_solver/ionic/ionic_models.h"

#include <algorithm>

namespace heartbus::ep {

#define HEARTBUS_DECLARE(name, make) std::unique_ptr<IonicModel> make();
HEARTBUS_IONIC_MODELS(HEARTBUS_DECLARE)
#undef HEARTBUS_DECLARE

std::unique_ptr<IonicModel> make_ionic_model(const std::string &name) {
  std::string known;
#define HEARTBUS_MAKE(known_name, make)                                                                                \
  if (name == known_name)                                                                                              \
    return make();                                                                                                     \
  known += std::string(known.empty() ? "" : ", ") + known_name;
  HEARTBUS_IONIC_MODELS(HEARTBUS_MAKE)
#undef HEARTBUS_MAKE
  throw Failure(ExitCode::scene, "there is no ionic model \"" + name + "\"; known are " + known);
}

Integrator integrator(const std::string &name) {
  return name == "imex_euler" ? Integrator::imex_euler : Integrator::exponential_midpoint;
}

std::vector<fem::VectorizedDouble> IonicModel::uniform_states(std::size_t n_nodes,
                                                              const std::vector<double> &states) const {
  std::vector<fem::VectorizedDouble> blocks;
  blocks.reserve(n_blocks(n_nodes) * n_kept());
  for (std::size_t block = 0; block < n_blocks(n_nodes); ++block)
    for (const double state : states)
      blocks.push_back(fem::lanes(state));
  return blocks;
}

void IonicModel::get_calcium(std::size_t n_nodes, const std::vector<fem::VectorizedDouble> &states,
                             double *calcium) const {
  const unsigned n = n_kept();
  const double factor = calcium_to_micromolar();
  const fem::VectorizedDouble *values = states.data() + calcium_state();
  for (std::size_t node = 0; node < n_nodes; ++node)
    calcium[node] = factor * values[node / fem::n_lanes * n][node % fem::n_lanes];
}

void IonicModel::gather(const std::vector<unsigned> &nodes, const std::vector<fem::VectorizedDouble> &all,
                        std::vector<fem::VectorizedDouble> &some) const {
  const unsigned n = n_kept();
  some.resize(n_blocks(nodes.size()) * n);
  for (std::size_t k = 0; k < n_blocks(nodes.size()) * fem::n_lanes; ++k) {
    const unsigned node = nodes[std::min(k, nodes.size() - 1)]; // the last block is filled up with copies
    const fem::VectorizedDouble *from = &all[node / fem::n_lanes * n];
    fem::VectorizedDouble *to = &some[k / fem::n_lanes * n];
    for (unsigned s = 0; s < n; ++s)
      to[s][k % fem::n_lanes] = from[s][node % fem::n_lanes];
  }
}

void IonicModel::scatter(const std::vector<unsigned> &nodes, const std::vector<fem::VectorizedDouble> &some,
                         std::vector<fem::VectorizedDouble> &all) const {
  const unsigned n = n_kept();
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const fem::VectorizedDouble *from = &some[k / fem::n_lanes * n];
    fem::VectorizedDouble *to = &all[nodes[k] / fem::n_lanes * n];
    for (unsigned s = 0; s < n; ++s)
      to[s][nodes[k] % fem::n_lanes] = from[s][k % fem::n_lanes];
  }
}

} // namespace heartbus::ep
