#pragma once

#include "common/fem/lagrange_space.h"

#include <cstdint>
#include <string>
#include <vector>

namespace heartbus::fem {

/// Flags of constrained degrees of freedom, one for each local one (node*components + c), for fields whose first three
/// components are a vector. See BlockMatrix::set_constraints.
using Constraints = std::vector<std::uint8_t>;

/// Constrains the vector at every node of the label.
void fix_vector(const LagrangeSpace &space, unsigned components, const std::string &label, Constraints &constrained);

/// Constrains the normal component at every node of the label, which must be flat and normal to a coordinate axis:
/// Failure(scene) otherwise. Collective.
void fix_normal(const LagrangeSpace &space, unsigned components, const std::string &label, Constraints &constrained);

/// Zeroes the constrained owned entries of a vector.
void zero_constrained(Vector &v, const Constraints &constrained);

/// Throws Failure(not_finite) on every rank, naming the centre of the worst cell, when `smallest_J` (this rank's
/// smallest det F, found in `slot`) is not positive on some rank. Collective.
void refuse_inverted_cells(const LagrangeSpace &space, double smallest_J, unsigned slot, const std::string &what);

} // namespace heartbus::fem
