#include "ale_solver/settings/parameters.h"

namespace heartbus::ale {

void Parameters::describe(config::Section &s) {
  s.texts("fixed", fixed, "boundary labels of the fluid whose mesh does not move");
  s.texts("slip", slip, "flat boundary labels, each normal to a coordinate axis, in which the mesh may slide");
  s.number("tolerance", tolerance, config::between(1e-14, 1e-2), "of the linear solver");
}

} // namespace heartbus::ale
