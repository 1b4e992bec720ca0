#pragma once

#include "common/geometry/mesh_tools.h"

#include <array>
#include <functional>
#include <vector>

namespace heartbus::geometry {

/// Topology of hexahedra that fill a tube, or a cup when `closed`, without degenerate cells, and of the wall around it.
/// A core block of n x n x m cells (i, j across, k along the axis) is surrounded by shells that grow from its four
/// sides and, when closed, from its end k = 0. Nodes of the core's surface count the columns of nodes through shells
/// and wall, so that cavity and wall conform by construction.
class OGrid {
 public:
  OGrid(unsigned n, unsigned m, bool closed);

  struct Node {
    unsigned i, j, k;
  };
  /// Where the column of a surface node meets the wall at depth s: 0 on the interface, 1 outside.
  using WallPoint = std::function<Point3(const Node &, double s)>;
  /// Where a node of the core's surface lies.
  using CorePoint = std::function<Point3(const Node &)>;

  /// Core and shells; labels `interface` and whatever `label_end(centre)` names of `end_labels` on the flat ends.
  Mesh cavity(unsigned shells, const CorePoint &core, const WallPoint &wall, const std::vector<std::string> &end_labels,
              const std::function<unsigned(const Point3 &)> &label_end) const;
  /// Layers around the cavity; labels `interface`, `outside` and `end`.
  Mesh wall(unsigned layers, const WallPoint &wall, const std::string &outside, const std::string &end) const;

  unsigned n() const { return n_; }
  unsigned m() const { return m_; }

 private:
  unsigned lattice(unsigned i, unsigned j, unsigned k) const { return i + (n_ + 1) * (j + (n_ + 1) * k); }
  bool on_surface(const Node &node) const;
  void add_quad(Node origin, unsigned first, unsigned second);
  std::vector<Point3> core_points(const CorePoint &core) const;

  unsigned n_, m_;
  bool closed_;
  std::vector<Node> surface_nodes_;
  std::vector<unsigned> column_of_;                    ///< [lattice node] number of its column
  std::vector<std::array<unsigned, 4>> surface_quads_; ///< columns; first edge x second edge points outwards
};

} // namespace heartbus::geometry
