#include "ep_solver/conductivity.h"

#include <array>

namespace heartbus::ep {

using fem::Mat3;
using fem::VectorizedDouble;

namespace {

/// Along fibre, sheet and normal in the four cells of a batch.
std::array<VectorizedDouble, 3> of_batch(const fem::LagrangeSpace &space, unsigned batch,
                                         const ConductivityParameters &parameters) {
  std::array<VectorizedDouble, 3> sigma;
  for (unsigned lane = 0; lane < fem::n_lanes; ++lane) {
    const unsigned slot = batch * fem::n_lanes + lane;
    const Conductivity *here = &parameters;
    if (!parameters.regions.empty() && space.slot_used(slot))
      if (const auto found = parameters.regions.find(space.material_names()[space.material(slot)]);
          found != parameters.regions.end())
        here = &found->second;
    sigma[0][lane] = here->fibre;
    sigma[1][lane] = here->sheet;
    sigma[2][lane] = here->normal;
  }
  return sigma;
}

} // namespace

std::vector<Mat3<VectorizedDouble>> conductivity(const fem::LagrangeSpace &space, const fem::Fibres &fibres,
                                                 const ConductivityParameters &parameters) {
  std::vector<Mat3<VectorizedDouble>> D(space.n_batches() * space.n_q());
  for (unsigned batch = 0; batch < space.n_batches(); ++batch) {
    const std::array<VectorizedDouble, 3> sigma = of_batch(space, batch, parameters);
    for (unsigned q = 0; q < space.n_q(); ++q) {
      const Mat3<VectorizedDouble> &frame = fibres.frames(batch)[q]; // columns f, s, n
      for (unsigned i = 0; i < 3; ++i)
        for (unsigned j = 0; j < 3; ++j)
          for (unsigned k = 0; k < 3; ++k)
            D[batch * space.n_q() + q][i][j] += sigma[k] * frame[i][k] * frame[j][k];
    }
  }
  return D;
}

} // namespace heartbus::ep
