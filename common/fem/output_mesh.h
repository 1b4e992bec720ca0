#pragma once

#include "common/fem/lagrange_space.h"
#include "common/io/field_writer.h"

namespace heartbus::fem {

/// The mesh of a space as the field writer wants it.
io::OutputMesh output_mesh(const LagrangeSpace &space);

} // namespace heartbus::fem
