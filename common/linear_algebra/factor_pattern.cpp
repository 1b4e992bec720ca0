#include "common/linear_algebra/factor_pattern.h"

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cstdint>
#include <mpi.h>

namespace heartbus::fem {

FactorPattern::FactorPattern(const BlockPattern &pattern)
    : n_ghosts(int(pattern.space().n_local_nodes() - pattern.space().n_owned_nodes())),
      communicator_(pattern.space().communicator()), n_owned_(pattern.n_rows()) {
  add_ghost_rows(pattern);
  add_owned_rows(pattern);
  order_factors();
}

int FactorPattern::row_of(unsigned local_node) const {
  const int node = int(local_node);
  return node < n_owned_ ? n_ghosts + node : node - n_owned_;
}

void FactorPattern::add_owned_rows(const BlockPattern &pattern) {
  std::vector<std::pair<int, int>> row;
  for (int node = 0; node < n_owned_; ++node) {
    for (int block = pattern.begin()[node]; block < pattern.begin()[node + 1]; ++block)
      row.emplace_back(row_of(pattern.columns()[block]), block);
    finish_row(row);
  }
}

/// Three rounds: which rows are wanted, what their columns are, and which of their blocks are to be sent.
void FactorPattern::add_ghost_rows(const BlockPattern &pattern) {
  using Numbers = std::vector<std::uint64_t>;
  using Messages = std::map<unsigned, Numbers>;
  const LagrangeSpace &space = pattern.space();
  const auto partitioner = space.partitioner(1);
  const auto exchange = [&](const Messages &messages) {
    return dealii::Utilities::MPI::some_to_some(space.communicator(), messages);
  };
  Messages wanted;
  unsigned ghost = space.n_owned_nodes();
  for (const auto &[owner, count] : partitioner->ghost_targets())
    for (unsigned k = 0; k < count; ++k)
      wanted[owner].push_back(space.global_node(ghost++));

  Messages rows; // of each: its first block, the number of its columns, their nodes
  for (const auto &[rank, nodes] : exchange(wanted))
    for (const auto global : nodes) {
      const unsigned node = partitioner->global_to_local(global);
      const int first = pattern.begin()[node], last = pattern.begin()[node + 1];
      rows[rank].insert(rows[rank].end(), {std::uint64_t(first), std::uint64_t(last - first)});
      for (int block = first; block < last; ++block)
        rows[rank].push_back(space.global_node(pattern.columns()[block]));
    }

  Messages blocks;
  std::vector<std::pair<int, int>> row;
  int n_received = 0;
  for (const auto &[owner, numbers] : exchange(rows)) {
    Numbers &here = blocks[owner];
    for (std::size_t k = 0; k < numbers.size(); k += 2 + numbers[k + 1]) {
      for (std::size_t j = 0; j < numbers[k + 1]; ++j)
        if (const auto global = numbers[k + 2 + j];
            partitioner->in_local_range(global) || partitioner->is_ghost_entry(global)) {
          row.emplace_back(row_of(partitioner->global_to_local(global)), n_received++);
          here.push_back(numbers[k] + j);
        }
      finish_row(row);
    }
    received_[owner] = here.size();
  }
  for (const auto &[rank, numbers] : exchange(blocks))
    sent_[rank].assign(numbers.begin(), numbers.end());
}

void FactorPattern::finish_row(std::vector<std::pair<int, int>> &row) {
  std::sort(row.begin(), row.end());
  for (const auto &[column, source] : row) {
    columns.push_back(column);
    sources.push_back(source);
  }
  begin.push_back(int(columns.size()));
  row.clear();
}

void FactorPattern::order_factors() {
  const auto append = [&](auto first, auto last) { factor_columns.insert(factor_columns.end(), first, last); };
  const auto row = [&](int i) { return std::make_pair(columns.begin() + begin[i], columns.begin() + begin[i + 1]); };
  factor_columns.reserve(columns.size());
  for (int i = 0; i < n_rows(); ++i) {
    const auto [first, last] = row(i);
    append(first, std::lower_bound(first, last, i));
    end.push_back(int(factor_columns.size()));
  }
  for (int i = n_rows() - 1; i >= 0; --i) {
    const auto [first, last] = row(i);
    append(std::upper_bound(first, last, i), last);
    factor_columns.push_back(i);
    end.push_back(int(factor_columns.size()));
  }
}

std::vector<float> FactorPattern::ghost_blocks(const float *values, unsigned components) const {
  const std::size_t size = components * components;
  std::size_t n_received = 0;
  for (const auto &[owner, count] : received_)
    n_received += count;
  std::vector<float> received(size * n_received + 1);
  std::vector<std::vector<float>> messages;
  messages.reserve(sent_.size());
  std::vector<MPI_Request> requests;
  float *next = received.data();
  for (const auto &[owner, count] : received_) {
    MPI_Irecv(next, int(size * count), MPI_FLOAT, int(owner), 0, communicator_, &requests.emplace_back());
    next += size * count;
  }
  for (const auto &[rank, blocks] : sent_) {
    auto &message = messages.emplace_back();
    message.reserve(size * blocks.size());
    for (const int block : blocks)
      message.insert(message.end(), values + size * block, values + size * (block + 1));
    MPI_Isend(message.data(), int(message.size()), MPI_FLOAT, int(rank), 0, communicator_, &requests.emplace_back());
  }
  MPI_Waitall(int(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  return received;
}

} // namespace heartbus::fem
