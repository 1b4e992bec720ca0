#include "mech_solver/cavity_filling.h"

#include <deal.II/base/mpi.h>

namespace heartbus::mech {

CavityFilling::CavityFilling(ElasticityProblem &problem) : problem_(problem), response_(problem) {
  const fem::LagrangeSpace &space = problem.space();
  const auto inside = space.nodes_on("interface");
  std::vector<bool> on_rim(space.n_owned_nodes());
  for (const std::string &label : space.labels())
    if (label != "interface") {
      const auto beside = space.nodes_on(label);
      for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
        on_rim[node] = on_rim[node] || (inside[node] && beside[node]);
    }
  for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
    if (on_rim[node])
      rim_.push_back(node);
  n_rim_ = dealii::Utilities::MPI::sum(double(rim_.size()), space.communicator());
}

void CavityFilling::declare(bus::Declaration &bus) {
  bus.output("cavity_volume", bus::Declaration::global, 1, "m^3", "n+1", volume_);
  bus.output("cavity_compliance", bus::Declaration::global, 1, "m^3/Pa", "n+1", compliance_);
  bus.output("cavity_pressure_guess", bus::Declaration::global, 1, "Pa", "n+1", guess_);
  bus.input("cavity_pressure", bus::Declaration::global, 1, "Pa", pressure_);
}

/// V = -1/3 int (x - o) . n da over the moved interface, whose normals n point out of the wall, with the centre o of
/// the rim: the lid has no part in it.
double CavityFilling::volume(const fem::Vector &d) const {
  const fem::LagrangeSpace &space = problem_.space();
  const auto place = [&](unsigned node, unsigned i) { return space.points()[node][i] + d.local_element(3 * node + i); };
  std::array<double, 3> centre{};
  for (unsigned i = 0; i < 3; ++i) {
    for (const unsigned node : rim_)
      centre[i] += place(node, i);
    centre[i] = n_rim_ > 0 ? dealii::Utilities::MPI::sum(centre[i], space.communicator()) / n_rim_ : 0;
  }
  const fem::Vector area = problem_.interface_area(d);
  double sum = 0;
  for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
    for (unsigned i = 0; i < 3; ++i)
      sum -= (place(node, i) - centre[i]) * area.local_element(3 * node + i);
  return dealii::Utilities::MPI::sum(sum, space.communicator()) / 3;
}

void CavityFilling::begin(double pressure, const fem::Vector &d) {
  pressure_[0] = pressure_n_ = pressure_nm1_ = pressure;
  make_guess();
  volume_[0] = volume(d);
}

void CavityFilling::respond(const fem::Vector &d) {
  fem::Vector b = problem_.interface_area(d);
  b *= -1;
  fem::zero_constrained(b, problem_.constrained());
  const fem::Vector &w = response_.to(b, d);
  volume_[0] = volume(d);
  fem::Vector more(d), less(d);
  more.add(1, w);
  less.add(-1, w);
  compliance_[0] = (volume(more) - volume(less)) / 2;
}

void CavityFilling::press(fem::Vector &d) {
  d.add(pressure_[0] - guess_[0], response_.last());
  volume_[0] = volume(d);
}

void CavityFilling::commit() {
  pressure_nm1_ = pressure_n_;
  pressure_n_ = pressure_[0];
  make_guess();
}

void CavityFilling::visit(io::State &state) {
  state.number("cavity_pressure", pressure_n_);
  state.number("cavity_pressure_nm1", pressure_nm1_);
}

void CavityFilling::load(const fem::Vector &d) {
  pressure_[0] = pressure_n_;
  make_guess();
  volume_[0] = volume(d);
}

} // namespace heartbus::mech
