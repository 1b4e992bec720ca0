#pragma once

#include <cstddef>
#include <mpi.h>
#include <new>
#include <vector>

namespace heartbus::bus {

/// Memory that the ranks of a node share: so many bytes of each, from the beginning of a cache line on. Ranks of other
/// nodes cannot be reached.
class NodeMemory {
 public:
  static constexpr std::size_t cache_line = 64;

  NodeMemory(MPI_Comm everybody, std::size_t bytes); ///< collective
  NodeMemory(const NodeMemory &) = delete;
  void free(); ///< collective

  int rank() const { return rank_; }
  int n_ranks() const { return static_cast<int>(parts_.size()); }
  void *of(int rank) const { return parts_[rank]; } ///< null on another node
  void wait_for_all() const { MPI_Barrier(node_); } ///< of the node

 private:
  MPI_Comm node_ = MPI_COMM_NULL;
  MPI_Win window_ = MPI_WIN_NULL;
  std::vector<void *> parts_; ///< by rank of the world
  int rank_ = 0;
};

/// One T for each rank of the node, made by its owner, seen by all.
template <class T>
class NodeArray {
  static_assert(alignof(T) <= NodeMemory::cache_line);

 public:
  explicit NodeArray(MPI_Comm everybody) : memory_(everybody, sizeof(T)) {
    new (memory_.of(memory_.rank())) T;
    memory_.wait_for_all(); // nobody uses what its owner has yet to make
  }
  void free() { memory_.free(); } ///< collective

  int rank() const { return memory_.rank(); }
  int n_ranks() const { return memory_.n_ranks(); }
  T *of(int rank) const { return static_cast<T *>(memory_.of(rank)); } ///< null on another node
  T &mine() const { return *of(rank()); }

 private:
  NodeMemory memory_;
};

} // namespace heartbus::bus
