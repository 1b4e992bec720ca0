#include "ep_solver/eikonal.h"

#include "ep_solver/arrival.h"
#include "ep_solver/stimulus.h"

#include <algorithm>
#include <cmath>
#include <queue>

namespace heartbus::ep {

namespace {

using fem::Mat3;
using fem::n_lanes;
using geometry::Point3;
using Triangle = std::array<unsigned, 3>;

/// Of a cell's node: the triangles that a front may come from, straight through the cell.
using Origins = std::vector<std::vector<Triangle>>;

/// Hexahedra: of the three faces opposite to the node, each cut along both diagonals, so that neither is preferred.
Origins origins_in_hexahedron() {
  Origins origins(8);
  for (unsigned node = 0; node < 8; ++node)
    for (unsigned i = 0; i < 3; ++i) {
      const unsigned j = 1u << (i + 1) % 3, k = 1u << (i + 2) % 3, first = ~node & 1u << i;
      for (const Triangle &t : {Triangle{0, j, k}, {j | k, j, k}, {0, j, j | k}, {0, k, j | k}})
        origins[node].push_back({first | t[0], first | t[1], first | t[2]});
    }
  return origins;
}

/// Quadratic tetrahedra: as eight linear ones.
Origins origins_in_tetrahedra(unsigned n_nodes) {
  using Tetrahedron = std::array<unsigned, 4>;
  std::vector<Tetrahedron> tetrahedra{{0, 1, 2, 3}};
  if (n_nodes == 10)
    tetrahedra = {{0, 4, 6, 7}, {1, 4, 5, 8}, {2, 5, 6, 9}, {3, 7, 8, 9},
                  {4, 9, 5, 6}, {4, 9, 6, 7}, {4, 9, 7, 8}, {4, 9, 8, 5}};
  Origins origins(n_nodes);
  for (const Tetrahedron &t : tetrahedra)
    for (unsigned a = 0; a < 4; ++a)
      origins[t[a]].push_back({t[(a + 1) % 4], t[(a + 2) % 4], t[(a + 3) % 4]});
  return origins;
}

class Front {
 public:
  Front(const fem::LagrangeSpace &space, const std::vector<Mat3<fem::VectorizedDouble>> &D, double front_speed);
  void start(const StimulusSite &site, double time);
  void run();
  std::vector<double> times() const { return {times_.begin(), times_.begin() + space_.n_owned_nodes()}; }

 private:
  void march();
  bool take_from_neighbours();
  void pass_through(unsigned slot, unsigned node);
  void offer(unsigned node, double time);
  double arrival_at(unsigned slot, unsigned a, const Triangle &origin) const;

  const fem::LagrangeSpace &space_;
  Origins origins_;
  std::vector<Metric> metrics_;              ///< [slot]
  std::vector<arrival::Vector> places_;      ///< [slot][node of the cell], stretched
  std::vector<std::vector<unsigned>> slots_; ///< [node]
  std::vector<double> times_;                ///< [node], ghosts too
  using Entry = std::pair<double, unsigned>; ///< time, node
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

Front::Front(const fem::LagrangeSpace &space, const std::vector<Mat3<fem::VectorizedDouble>> &D, double front_speed)
    : space_(space),
      origins_(space.nodes_per_cell() == 8 ? origins_in_hexahedron() : origins_in_tetrahedra(space.nodes_per_cell())),
      slots_(space.n_local_nodes()), times_(space.n_local_nodes(), arrival::never) {
  const unsigned n_q = space.n_q();
  for (unsigned slot = 0; slot < space.n_slots(); ++slot) {
    Mat3<double> V{};
    for (unsigned q = 0; q < n_q; ++q)
      for (unsigned i = 0; i < 3; ++i)
        for (unsigned j = 0; j < 3; ++j)
          V[i][j] += front_speed * front_speed / n_q * D[slot / n_lanes * n_q + q][i][j][slot % n_lanes];
    metrics_.emplace_back(V);
    for (unsigned a = 0; a < space.nodes_per_cell(); ++a) {
      const unsigned node = space.cell_nodes(slot)[a];
      places_.push_back(metrics_[slot](space.points()[node]));
      if (space.slot_used(slot))
        slots_[node].push_back(slot);
    }
  }
}

void Front::offer(unsigned node, double time) {
  constexpr double too_little = 1e-10; // [s], to let a front pass through all that lies behind once more
  if (node >= space_.n_owned_nodes() || !(time < times_[node] - too_little))
    return;
  times_[node] = time;
  queue_.push({time, node});
}

/// On the site, and by straight ways from its surface through cells that it reaches into.
void Front::start(const StimulusSite &site, double time) {
  const unsigned n = space_.nodes_per_cell();
  for (unsigned slot = 0; slot < space_.n_slots(); ++slot) {
    const unsigned *nodes = space_.cell_nodes(slot);
    const bool reached = space_.slot_used(slot) && std::any_of(nodes, nodes + n, [&](unsigned node) {
                           return is_in(site, space_.points()[node]);
                         });
    for (unsigned a = 0; a < n && reached; ++a) {
      const Point3 &x = space_.points()[nodes[a]], from = nearest_in(site, x);
      const arrival::Vector way{x[0] - from[0], x[1] - from[1], x[2] - from[2]};
      offer(nodes[a], arrival::from_corner(metrics_[slot](way), time));
    }
  }
}

/// At a cell's node; infinite where the front comes there before the triangle.
double Front::arrival_at(unsigned slot, unsigned a, const Triangle &origin) const {
  const unsigned n = space_.nodes_per_cell(), *nodes = space_.cell_nodes(slot);
  const std::array<double, 3> times{times_[nodes[origin[0]]], times_[nodes[origin[1]]], times_[nodes[origin[2]]]};
  if (std::min({times[0], times[1], times[2]}) >= times_[nodes[a]])
    return arrival::never;
  const arrival::Vector *places = &places_[slot * n];
  std::array<arrival::Vector, 3> from;
  for (unsigned k = 0; k < 3; ++k)
    for (unsigned i = 0; i < 3; ++i)
      from[k][i] = places[a][i] - places[origin[k]][i];
  return arrival::from_triangle(from, times);
}

/// From `node`, whose time has changed, to the others of the cell.
void Front::pass_through(unsigned slot, unsigned node) {
  const unsigned n = space_.nodes_per_cell(), *nodes = space_.cell_nodes(slot);
  const unsigned here = std::find(nodes, nodes + n, node) - nodes;
  for (unsigned a = 0; a < n; ++a)
    if (nodes[a] < space_.n_owned_nodes())
      for (const Triangle &origin : origins_[a])
        if (origin[0] == here || origin[1] == here || origin[2] == here)
          offer(nodes[a], arrival_at(slot, a, origin));
}

void Front::march() {
  while (!queue_.empty()) {
    const auto [time, node] = queue_.top();
    queue_.pop();
    if (time == times_[node])
      for (const unsigned slot : slots_[node])
        pass_through(slot, node);
  }
}

/// Whether any rank has got earlier times from others.
bool Front::take_from_neighbours() {
  fem::Vector shared = space_.make_vector(1);
  std::copy_n(times_.begin(), space_.n_owned_nodes(), shared.begin());
  const fem::GhostValues ghosts(shared);
  int changed = 0;
  for (unsigned node = space_.n_owned_nodes(); node < space_.n_local_nodes(); ++node)
    if (const double time = shared.begin()[node]; time < times_[node]) {
      times_[node] = time;
      queue_.push({time, node});
      changed = 1;
    }
  return dealii::Utilities::MPI::max(changed, space_.communicator()) > 0;
}

void Front::run() {
  do
    march();
  while (take_from_neighbours());
}

} // namespace

std::vector<double> eikonal(const fem::LagrangeSpace &space, const std::vector<Mat3<fem::VectorizedDouble>> &D,
                            double front_speed, const std::vector<StimulusSite> &sites, double start) {
  check_reach(sites, {space.points().begin(), space.points().begin() + space.n_owned_nodes()}, space.communicator(),
              is_in);
  Front front(space, D, front_speed);
  for (const StimulusSite &site : sites)
    front.start(site, start);
  front.run();
  return front.times();
}

} // namespace heartbus::ep
