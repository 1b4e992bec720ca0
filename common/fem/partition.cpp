#include "common/fem/partition.h"

#include <deal.II/grid/grid_tools.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>
#include <vector>

namespace heartbus::fem {
namespace {

/// Cells that each rank will visit: its own, and those of others that touch a node of its own. Ranks that share a
/// vertex leave it to the first of them, so that equal numbers of own cells are not equal work.
std::vector<unsigned> work_of_ranks(const dealii::Triangulation<3> &mesh, unsigned n_ranks) {
  std::vector<unsigned> owner(mesh.n_vertices(), n_ranks), work(n_ranks);
  for (const auto &cell : mesh.active_cell_iterators())
    for (const unsigned v : cell->vertex_indices())
      owner[cell->vertex_index(v)] = std::min(owner[cell->vertex_index(v)], cell->subdomain_id());
  for (const auto &cell : mesh.active_cell_iterators()) {
    std::set<unsigned> visitors{cell->subdomain_id()};
    for (const unsigned v : cell->vertex_indices())
      visitors.insert(owner[cell->vertex_index(v)]);
    for (const unsigned rank : visitors)
      ++work[rank];
  }
  return work;
}

/// Numbers the parts in the order of their first cells: METIS may call nearly the same parts differently in each
/// attempt.
void renumber(dealii::Triangulation<3> &mesh, unsigned n_ranks) {
  std::vector<unsigned> number(n_ranks, n_ranks);
  unsigned next = 0;
  for (const auto &cell : mesh.active_cell_iterators()) {
    unsigned &rank = number[cell->subdomain_id()];
    if (rank == n_ranks)
      rank = next++;
    cell->set_subdomain_id(rank);
  }
}

} // namespace

void partition(dealii::Triangulation<3> &mesh, unsigned n_ranks) {
  std::vector<unsigned> weights(mesh.n_active_cells(), 1000), best;
  unsigned least = std::numeric_limits<unsigned>::max(); ///< work of the busiest rank
  for (unsigned attempt = 0; attempt < 6; ++attempt) {
    dealii::GridTools::partition_triangulation(n_ranks, weights, mesh);
    renumber(mesh, n_ranks);
    const std::vector<unsigned> work = work_of_ranks(mesh, n_ranks);
    const double mean = double(std::accumulate(work.begin(), work.end(), 0u)) / n_ranks;
    const unsigned largest = *std::max_element(work.begin(), work.end());
    if (largest < least) {
      least = largest;
      best.clear();
      for (const auto &cell : mesh.active_cell_iterators())
        best.push_back(cell->subdomain_id());
    }
    if (largest < 1.01 * mean)
      break;
    for (const auto &cell : mesh.active_cell_iterators())
      weights[cell->active_cell_index()] *= work[cell->subdomain_id()] / mean;
  }
  for (const auto &cell : mesh.active_cell_iterators())
    cell->set_subdomain_id(best[cell->active_cell_index()]);
}

} // namespace heartbus::fem
