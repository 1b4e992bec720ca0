#include "ep_solver/parameters.h"

namespace heartbus::ep {

void Parameters::describe(config::Section &) {}

} // namespace heartbus::ep
