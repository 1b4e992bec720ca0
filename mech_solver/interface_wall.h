#pragma once

#include "common/interface/nodal/alpha_limit.h"
#include "mech_solver/elasticity_problem.h"

namespace heartbus::mech {

/// The wall about its present state, as whoever asks at the interface sees it.
class InterfaceWall : public interface::LinearWall {
 public:
  explicit InterfaceWall(ElasticityProblem &problem) : problem_(problem), surface_(problem.space(), "interface") {}
  const fem::LagrangeSpace &space() const override { return problem_.space(); }
  const fem::Constraints &constrained() const override { return problem_.constrained(); }
  void linearise(double tau, double time) override;
  fem::Vector answer(const fem::Vector &force) override;
  fem::Vector interface_mass(const fem::Vector &x) const override;

 private:
  ElasticityProblem &problem_;
  LoadedSurface surface_;
};

/// w = A^{-1} b for the force b of a unit pressure on the interface, with the tangent A of the last solve: kept as
/// long as that is.
class PressureResponse {
 public:
  explicit PressureResponse(ElasticityProblem &problem) : problem_(problem) {}
  /// `d`: where a tangent is made if there is none. Collective.
  const fem::Vector &to(const fem::Vector &b, const fem::Vector &d);
  const fem::Vector &last() const { return response_; }

 private:
  ElasticityProblem &problem_;
  fem::Vector response_;
  unsigned tangent_ = 0; ///< its number
};

} // namespace heartbus::mech
