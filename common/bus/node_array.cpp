#include "common/bus/node_array.h"

#include <cstdlib>
#include <memory>

namespace heartbus::bus {
namespace {

/// A test may pretend that one machine is several nodes.
int pretended_node() {
  const char *node = std::getenv("HEARTBUS_NODE");
  return node ? std::abs(std::atoi(node)) : 0;
}

/// MPI aligns to 8 bytes. What it shares begins at a page in every process, so that all find the same place.
void *next_cache_line(void *memory, std::size_t bytes) {
  std::size_t space = bytes + NodeMemory::cache_line;
  return std::align(NodeMemory::cache_line, bytes, memory, space);
}

} // namespace

NodeMemory::NodeMemory(MPI_Comm everybody, std::size_t bytes) {
  int size;
  MPI_Comm_rank(everybody, &rank_);
  MPI_Comm_size(everybody, &size);
  MPI_Comm machine;
  MPI_Comm_split_type(everybody, MPI_COMM_TYPE_SHARED, rank_, MPI_INFO_NULL, &machine);
  MPI_Comm_split(machine, pretended_node(), rank_, &node_);
  MPI_Comm_free(&machine);
  void *memory;
  MPI_Win_allocate_shared(static_cast<MPI_Aint>(bytes + cache_line), 1, MPI_INFO_NULL, node_, &memory, &window_);

  MPI_Group all, near;
  MPI_Comm_group(everybody, &all);
  MPI_Comm_group(node_, &near);
  parts_.resize(size);
  for (int r = 0; r < size; ++r) {
    int neighbour, unit;
    MPI_Aint length;
    MPI_Group_translate_ranks(all, 1, &r, near, &neighbour);
    if (neighbour == MPI_UNDEFINED)
      continue;
    MPI_Win_shared_query(window_, neighbour, &length, &unit, &parts_[r]);
    parts_[r] = next_cache_line(parts_[r], bytes);
  }
  MPI_Group_free(&near);
  MPI_Group_free(&all);
}

void NodeMemory::free() {
  MPI_Win_free(&window_);
  MPI_Comm_free(&node_);
}

} // namespace heartbus::bus
