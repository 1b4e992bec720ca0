#include "mech_solver/parameters.h"

namespace heartbus::mech {

void Parameters::describe(config::Section &) {}

} // namespace heartbus::mech
