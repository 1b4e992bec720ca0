#pragma once

#include <deal.II/grid/tria.h>

namespace heartbus::fem {

/// Gives each cell of a serial mesh its rank (METIS), so that all ranks have about equal numbers of cells to visit.
/// METIS balances weights: cells of those who had too much to do weigh more in the next attempt, and the best attempt
/// is taken.
void partition(dealii::Triangulation<3> &mesh, unsigned n_ranks);

} // namespace heartbus::fem
