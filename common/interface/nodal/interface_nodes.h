#pragma once

#include "common/fem/owned_points.h"

namespace heartbus::interface {

/// The owned nodes of the label `interface`, of which a mesh may have none, and the vectors at them: nodal fields of
/// so many components, of which the first three are the vector, and the bus's values, three a node.
class InterfaceNodes {
 public:
  InterfaceNodes(const fem::LagrangeSpace &space, unsigned components) : space_(&space), components_(components) {
    if (!space.has_label("interface"))
      return;
    const auto on = space.nodes_on("interface");
    for (unsigned node = 0; node < space.n_owned_nodes(); ++node)
      if (on[node])
        nodes_.push_back(node);
  }

  const fem::LagrangeSpace &space() const { return *space_; }
  std::size_t size() const { return nodes_.size(); }
  const std::vector<unsigned> &nodes() const { return nodes_; }
  std::vector<double> points() const { return fem::owned_points(*space_, nodes_); } ///< three coordinates each [m]
  /// Three values a node.
  std::vector<double> values(double value = 0) const { return std::vector<double>(3 * nodes_.size(), value); }

  void get(const fem::Vector &v, std::vector<double> &values, double factor = 1) const {
    for (std::size_t k = 0; k < values.size(); ++k)
      values[k] = factor * v.local_element(index(k));
  }
  void set(const std::vector<double> &values, fem::Vector &v) const {
    for (std::size_t k = 0; k < values.size(); ++k)
      v.local_element(index(k)) = values[k];
  }
  /// Zero elsewhere.
  fem::Vector vector(const std::vector<double> &values) const {
    fem::Vector v = space_->make_vector(components_);
    set(values, v);
    return v;
  }

 private:
  unsigned index(std::size_t k) const { return components_ * nodes_[k / 3] + k % 3; }
  const fem::LagrangeSpace *space_;
  unsigned components_;
  std::vector<unsigned> nodes_;
};

} // namespace heartbus::interface
