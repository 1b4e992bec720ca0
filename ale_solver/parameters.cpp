#include "ale_solver/parameters.h"

namespace heartbus::ale {

void Parameters::describe(config::Section &) {}

} // namespace heartbus::ale
