#include "mech_solver/cavity_filling.h"

namespace heartbus::mech {

CavityFilling::CavityFilling(ElasticityProblem &problem)
    : problem_(problem), cavity_(problem.space()), response_(problem) {}

void CavityFilling::declare(bus::Declaration &bus) {
  bus.output("cavity_volume", bus::Declaration::global, 1, "m^3", "n+1", volume_);
  bus.output("cavity_compliance", bus::Declaration::global, 1, "m^3/Pa", "n+1", compliance_);
  bus.output("cavity_pressure_guess", bus::Declaration::global, 1, "Pa", "n+1", guess_);
  bus.input("cavity_pressure", bus::Declaration::global, 1, "Pa", pressure_);
}

void CavityFilling::begin(double pressure, const fem::Vector &d) {
  pressure_[0] = pressure_n_ = pressure_nm1_ = pressure;
  make_guess();
  volume_[0] = cavity_.volume(d);
}

void CavityFilling::respond(const fem::Vector &d) {
  fem::Vector b = problem_.interface_area(d);
  b *= -1;
  fem::zero_constrained(b, problem_.constrained());
  const fem::Vector &w = response_.to(b, d);
  volume_[0] = cavity_.volume(d);
  fem::Vector more(d), less(d);
  more.add(1, w);
  less.add(-1, w);
  compliance_[0] = (cavity_.volume(more) - cavity_.volume(less)) / 2;
}

void CavityFilling::press(fem::Vector &d) {
  d.add(pressure_[0] - guess_[0], response_.last());
  volume_[0] = cavity_.volume(d);
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
  volume_[0] = cavity_.volume(d);
}

} // namespace heartbus::mech
