#include "common/fem/owned_faces.h"

#include <algorithm>
#include <array>

namespace heartbus::fem {
namespace {

using Corners = std::vector<geometry::Point3>;

bool is_clockwise(const Corners &corners, const double *outward) {
  std::array<double, 3> a{}, b{};
  for (int i = 0; i < 3; ++i) {
    a[i] = corners[1][i] - corners[0][i];
    b[i] = corners[2][i] - corners[0][i];
  }
  const double out[] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  return out[0] * outward[0] + out[1] * outward[1] + out[2] * outward[2] < 0;
}

} // namespace

void declare_faces(const LagrangeSpace &space, const std::string &label, bus::Declaration &declaration) {
  const BoundaryFaces faces = space.faces(label);
  const unsigned n_corners = faces.nodes_per_face;
  if (n_corners > 4)
    return;
  std::vector<double> places;
  for (unsigned f = 0; f < faces.n_faces; ++f) {
    if (!faces.owned[f])
      continue;
    Corners corners;
    for (unsigned k = 0; k < n_corners; ++k)
      corners.push_back(space.points()[space.cell_nodes(faces.slots[f])[faces.face_nodes[f * n_corners + k]]]);
    if (n_corners == 4)
      std::swap(corners[2], corners[3]); // nodes are numbered row by row
    if (is_clockwise(corners, &faces.normals[3 * faces.n_q * f]))
      std::reverse(corners.begin(), corners.end());
    for (const auto &corner : corners)
      places.insert(places.end(), corner.begin(), corner.end());
  }
  declaration.faces(label, n_corners, places);
}

} // namespace heartbus::fem
