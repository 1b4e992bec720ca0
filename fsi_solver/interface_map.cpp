#include "fsi_solver/interface_map.h"

#include "common/base/failure.h"
#include "common/mapping/conforming_map.h"

#include <numeric>

namespace heartbus::fsi {
namespace {

std::vector<unsigned> owned_nodes(const fem::LagrangeSpace &space) {
  const auto on = space.nodes_on("interface");
  std::vector<unsigned> nodes;
  for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
    if (on[node])
      nodes.push_back(node);
  return nodes;
}

mapping::DistributedPoints all_points(const std::string &name, const fem::LagrangeSpace &space,
                                      const std::vector<unsigned> &nodes) {
  std::vector<double> own;
  for (const unsigned node : nodes)
    own.insert(own.end(), space.points()[node].begin(), space.points()[node].end());
  return {name, dealii::Utilities::MPI::all_gather(space.communicator(), own), space.smallest_cell_size()};
}

std::vector<int> offsets(const std::vector<int> &counts) {
  std::vector<int> offsets(counts.size());
  std::exclusive_scan(counts.begin(), counts.end(), offsets.begin(), 0);
  return offsets;
}

} // namespace

InterfaceMap::InterfaceMap(const fem::LagrangeSpace &fluid, const fem::LagrangeSpace &solid)
    : communicator_(fluid.communicator()), fluid_{owned_nodes(fluid), {}, {}}, solid_{owned_nodes(solid), {}, {}} {
  const auto blood = all_points("the fluid's interface", fluid, fluid_.nodes),
             wall = all_points("the solid's interface", solid, solid_.nodes);
  mapping::match_points(blood, wall); // a wall node without blood would be free
  const int rank = dealii::Utilities::MPI::this_mpi_process(communicator_);
  fluid_.counts.resize(blood.coordinates.size());
  solid_.counts.resize(blood.coordinates.size());
  for (const auto &block : mapping::split_by_ranks(mapping::match_points(wall, blood), wall, blood)) {
    if (block.source_rank == rank) {
      solid_.order.insert(solid_.order.end(), block.source_points.begin(), block.source_points.end());
      solid_.counts[block.target_rank] = block.source_points.size();
    }
    if (block.target_rank == rank) {
      fluid_.order.insert(fluid_.order.end(), block.target_points.begin(), block.target_points.end());
      fluid_.counts[block.source_rank] = block.target_points.size();
    }
  }
}

std::vector<double> InterfaceMap::to_fluid(const std::vector<double> &values, unsigned components) const {
  return carry(solid_, fluid_, values, components);
}

std::vector<double> InterfaceMap::to_solid(const std::vector<double> &values, unsigned components) const {
  return carry(fluid_, solid_, values, components);
}

std::vector<double> InterfaceMap::carry(const Side &from, const Side &to, const std::vector<double> &values,
                                        unsigned components) const {
  std::vector<double> sent, received(to.nodes.size() * components), result(received.size());
  for (const int node : from.order)
    sent.insert(sent.end(), &values[node * components], &values[node * components] + components);
  std::vector<int> send_counts(from.counts), receive_counts(to.counts);
  for (unsigned rank = 0; rank < send_counts.size(); ++rank) {
    send_counts[rank] *= components;
    receive_counts[rank] *= components;
  }
  MPI_Alltoallv(sent.data(), send_counts.data(), offsets(send_counts).data(), MPI_DOUBLE, received.data(),
                receive_counts.data(), offsets(receive_counts).data(), MPI_DOUBLE, communicator_);
  for (std::size_t k = 0; k < to.order.size(); ++k)
    std::copy_n(&received[k * components], components, &result[to.order[k] * components]);
  return result;
}

} // namespace heartbus::fsi
