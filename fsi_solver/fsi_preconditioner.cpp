#include "fsi_solver/fsi_preconditioner.h"

#include <set>

namespace heartbus::fsi {

namespace {
constexpr unsigned nobody = -1;
} // namespace

InterfaceBlocks::InterfaceBlocks(const MergedSpace &space) : map_(space.interface()) {
  const fem::LagrangeSpace &solid = space.solid(), &fluid = space.fluid();
  const auto on = solid.nodes_on("interface");
  std::vector<std::set<unsigned>> neighbours(solid.n_owned_nodes());
  for (unsigned slot = 0; slot < solid.n_slots(); ++slot)
    for (unsigned a = 0; a < solid.nodes_per_cell(); ++a)
      for (unsigned b = 0; b < solid.nodes_per_cell(); ++b)
        if (const unsigned *nodes = solid.cell_nodes(slot);
            on[nodes[a]] && on[nodes[b]] && nodes[a] < neighbours.size())
          neighbours[nodes[a]].insert(nodes[b]);
  std::size_t widest = 0;
  for (const unsigned node : map_.solid_nodes()) {
    solid_neighbours_.emplace_back(neighbours[node].begin(), neighbours[node].end());
    widest = std::max(widest, neighbours[node].size());
  }
  width_ = dealii::Utilities::MPI::max(unsigned(widest), solid.communicator());

  // Global numbers of the fluid's nodes on all local nodes of the solid, then back to the fluid as lists of neighbours.
  std::vector<double> numbers;
  for (const unsigned node : map_.fluid_nodes())
    numbers.push_back(double(fluid.global_node(node)));
  numbers = map_.to_solid(numbers, 1);
  fem::Vector number = solid.make_vector(1);
  for (std::size_t k = 0; k < numbers.size(); ++k)
    number.local_element(map_.solid_nodes()[k]) = numbers[k];
  number.update_ghost_values();
  std::vector<double> lists;
  for (const auto &list : solid_neighbours_)
    for (unsigned k = 0; k < width_; ++k)
      lists.push_back(k < list.size() ? number.local_element(list[k]) : -1.);
  const auto &partitioner = *fluid.partitioner(1);
  for (const double global : map_.to_fluid(lists, width_)) {
    const bool local = global >= 0 && (partitioner.in_local_range(std::uint64_t(global)) ||
                                       partitioner.is_ghost_entry(std::uint64_t(global)));
    fluid_neighbours_.push_back(local ? partitioner.global_to_local(std::uint64_t(global)) : nobody);
  }
}

void InterfaceBlocks::add(double factor, const fem::BlockMatrix<double> &solid, fem::BlockMatrix<double> &fluid) const {
  std::vector<double> values;
  values.reserve(9 * width_ * solid_neighbours_.size());
  for (std::size_t k = 0; k < solid_neighbours_.size(); ++k) {
    for (const unsigned neighbour : solid_neighbours_[k])
      for (unsigned i = 0; i < 9; ++i)
        values.push_back(factor * solid.entry(3 * map_.solid_nodes()[k] + i / 3, 3 * neighbour + i % 3));
    values.resize(9 * width_ * (k + 1));
  }
  values = map_.to_fluid(values, 9 * width_);
  for (std::size_t k = 0; k < fluid_neighbours_.size(); ++k)
    if (fluid_neighbours_[k] != nobody) {
      double block[16] = {};
      for (unsigned i = 0; i < 9; ++i)
        block[i / 3 * 4 + i % 3] = values[9 * k + i];
      fluid.add_block(map_.fluid_nodes()[k / width_], fluid_neighbours_[k], block);
    }
}

FsiPreconditioner::FsiPreconditioner(const MergedSpace &space, const InterfaceBlocks &interface,
                                     const fluid::NavierStokesProblem &fluid, const mech::ElasticityProblem &solid,
                                     double dt)
    : space_(space), interface_(interface), fluid_problem_(fluid), solid_problem_(solid), dt_(dt),
      on_interface_(3 * space.solid().n_local_nodes()), fluid_matrix_(fluid.matrix().pattern(), 4),
      solid_matrix_(solid.tangent().pattern(), 3), r_f_(space.fluid().make_vector(4)), z_f_(r_f_),
      r_s_(space.solid().make_vector(3)), z_s_(r_s_), coupling_(r_s_) {
  fem::fix_vector(space.solid(), 3, "interface", on_interface_);
}

void FsiPreconditioner::make() {
  fluid_matrix_.set_constraints(fluid_problem_.constraints());
  fluid_matrix_.copy(fluid_problem_.matrix());
  interface_.add(dt_, solid_problem_.tangent(), fluid_matrix_);
  fluid_preconditioner_ = fluid_problem_.make_preconditioner(fluid_matrix_);
  solid_matrix_.copy(solid_problem_.tangent());
  solid_matrix_.decouple(on_interface_);
  const auto &kind = solid_problem_.tangent_solver().preconditioner_kind();
  solid_preconditioner_ = fem::make_preconditioner(kind, solid_matrix_);
}

void FsiPreconditioner::vmult(fem::Vector &y, const fem::Vector &x) const {
  space_.split(x, r_f_, r_s_);
  fluid_preconditioner_->vmult(z_f_, r_f_);
  z_s_ = 0;
  space_.move_wall(z_f_, dt_, z_s_);
  solid_problem_.apply_tangent(coupling_, z_s_);
  fem::zero_constrained(coupling_, solid_problem_.constrained());
  space_.clear_wall(coupling_);
  r_s_ -= coupling_;
  solid_preconditioner_->vmult(z_s_, r_s_);
  space_.merge(z_f_, z_s_, y);
}

} // namespace heartbus::fsi
