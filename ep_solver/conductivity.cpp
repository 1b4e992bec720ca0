#include "ep_solver/conductivity.h"

namespace heartbus::ep {

using fem::Mat3;
using fem::VectorizedDouble;

std::vector<Mat3<VectorizedDouble>> conductivity(const fem::LagrangeSpace &space, const fem::Fibres &fibres,
                                                 const ConductivityParameters &parameters) {
  const double sigma[3] = {parameters.fibre, parameters.sheet, parameters.normal};
  std::vector<Mat3<VectorizedDouble>> D(space.n_batches() * space.n_q());
  for (unsigned batch = 0; batch < space.n_batches(); ++batch)
    for (unsigned q = 0; q < space.n_q(); ++q) {
      const Mat3<VectorizedDouble> &frame = fibres.frames(batch)[q]; // columns f, s, n
      for (unsigned i = 0; i < 3; ++i)
        for (unsigned j = 0; j < 3; ++j)
          for (unsigned k = 0; k < 3; ++k)
            D[batch * space.n_q() + q][i][j] += sigma[k] * frame[i][k] * frame[j][k];
    }
  return D;
}

} // namespace heartbus::ep
