#include "stand_in/stand_in.h"

#include "common/base/failure.h"
#include "common/geometry/shapes.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <set>
#include <thread>

namespace heartbus::stand_in {
namespace {

constexpr double period = 0.1, wave_length = 0.05; // s, m

/// Indices of the vertices that carry the point set, of the mesh that it belongs to.
std::vector<unsigned> vertices_of(const std::string &set, const geometry::Mesh &mesh) {
  std::set<unsigned> found;
  if (set != "interface")
    for (unsigned v = 0; v < mesh.points.size(); ++v)
      found.insert(v);
  else
    for (const auto &face : mesh.faces)
      if (mesh.labels[face.label] == set)
        found.insert(face.vertices.begin(), face.vertices.begin() + mesh.vertices_per_face());
  return {found.begin(), found.end()};
}

double shortest_edge(const geometry::Mesh &mesh) {
  double shortest = std::numeric_limits<double>::infinity();
  const unsigned n = mesh.vertices_per_cell();
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell)
    for (unsigned a = 0; a < n; ++a)
      for (unsigned b = a + 1; b < n; ++b) {
        const auto &p = mesh.points[mesh.cells[n * cell + a]], &q = mesh.points[mesh.cells[n * cell + b]];
        shortest = std::min(shortest, std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]));
      }
  return shortest;
}

} // namespace

StandIn::StandIn(const std::string &role_name, const SceneParameters &scene, const Conduct &conduct)
    : role_(role(role_name)), scene_(scene), conduct_(conduct) {}

const std::vector<double> &StandIn::points(const std::string &name, bus::Declaration &declaration) {
  for (const PointSet &set : sets_)
    if (set.name == name)
      return set.points;
  const bool in_fluid = name == "cavity";
  const geometry::Mesh mesh = in_fluid ? geometry::make_fluid(scene_.geometry) : geometry::make_solid(scene_.geometry);
  PointSet &set = sets_.emplace_back(PointSet{name, {}});
  for (const unsigned v : vertices_of(name, mesh))
    set.points.insert(set.points.end(), mesh.points[v].begin(), mesh.points[v].end());
  declaration.point_set(name, set.points, shortest_edge(mesh));
  return set.points;
}

void StandIn::declare(bus::Declaration &declaration) {
  for (const RoleField &field : role_.fields) {
    static const std::vector<double> nowhere(3);
    const std::vector<double> &at =
        field.point_set == bus::Declaration::global ? nowhere : points(field.point_set, declaration);
    const std::size_t n = at.size() / 3 * field.components;
    if (field.output) {
      Values &output = outputs_.emplace_back(Values{&field, &at, std::vector<double>(n)});
      declaration.output(field.name, field.point_set, field.components, field.unit, "n+1", output.values);
    } else
      declaration.input(field.name, field.point_set, field.components, field.unit, inputs_.emplace_back(n));
  }
  fill({});
  for (const std::string &task : role_.tasks)
    declaration.task(task, [](const bus::Step &) {});
}

void StandIn::fill(const bus::Step &step) {
  for (Values &output : outputs_)
    for (std::size_t i = 0; i < output.values.size(); ++i) {
      const double *point = output.points->data() + i / output.field->components * 3;
      const double phase = step.time / period + (point[0] + point[1] + point[2]) / wave_length;
      output.values[i] = output.field->offset + output.field->amplitude * std::sin(2 * M_PI * phase);
    }
}

void StandIn::solve_step(const bus::Step &step) {
  std::this_thread::sleep_for(std::chrono::duration<double>(conduct_.delay));
  if (step.number != conduct_.step)
    return;
  if (conduct_.mischief == "fail")
    throw Failure(ExitCode::not_converged, "the stand-in fails, as it has been told to");
  if (conduct_.mischief == "silence")
    std::this_thread::sleep_for(std::chrono::duration<double>(10 * scene_.coupling.deadline));
  if (conduct_.mischief == "nan")
    for (Values &output : outputs_)
      std::fill(output.values.begin(), output.values.end(), std::numeric_limits<double>::quiet_NaN());
}

} // namespace heartbus::stand_in
