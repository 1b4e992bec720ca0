#pragma once

#include "common/bus/solver.h"
#include "common/fem/lagrange_space.h"

#include <string>

namespace heartbus::fem {

/// Tells the bus the faces of a label between the points of the set of the same name, each by the cell that this rank
/// owns, counter-clockwise seen from outside. Faces with nodes between their corners are left out.
void declare_faces(const LagrangeSpace &space, const std::string &label, bus::Declaration &declaration);

} // namespace heartbus::fem
