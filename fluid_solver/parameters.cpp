#include "fluid_solver/parameters.h"

namespace heartbus::fluid {

void Parameters::describe(config::Section &) {}

} // namespace heartbus::fluid
