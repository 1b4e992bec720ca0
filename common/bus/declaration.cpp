#include "common/bus/declaration.h"

#include "common/base/failure.h"

#include <cmath>

namespace heartbus::bus {

void LocalDeclaration::point_set(const std::string &name, const std::vector<double> &coordinates, double spacing) {
  if (coordinates.size() % 3 != 0)
    throw Failure(ExitCode::handshake, "point set '" + name + "' needs three coordinates a point");
  info_.point_sets.push_back({name, spacing, {coordinates}, 0, {}});
}

void LocalDeclaration::faces(const std::string &point_set, unsigned n_corners, const std::vector<double> &corners) {
  coordinates(point_set);
  for (PointSetInfo &set : info_.point_sets)
    if (set.name == point_set) {
      set.n_corners = n_corners;
      set.faces = corners;
    }
}

void LocalDeclaration::output(const std::string &name, const std::string &point_set, unsigned components,
                              const std::string &unit, const std::string &level, const std::vector<double> &values) {
  const FieldInfo field{name, point_set, unit, level, components, true};
  info_.fields.push_back(field);
  fields_.push_back({field, &values, nullptr, n_values(point_set, components)});
}

void LocalDeclaration::input(const std::string &name, const std::string &point_set, unsigned components,
                             const std::string &unit, std::vector<double> &values, const std::string &task) {
  const FieldInfo field{name, point_set, unit, task, components, false};
  info_.fields.push_back(field);
  fields_.push_back({field, nullptr, &values, n_values(point_set, components)});
}

void LocalDeclaration::task(const std::string &name, std::function<void(const Step &)> action) {
  info_.tasks.push_back(name);
  tasks_[name] = std::move(action);
}

void LocalDeclaration::scalar(const std::string &name, const std::string &unit, std::function<double()> value,
                              Combine combine) {
  info_.scalars.push_back({name, unit, {}});
  scalars_.push_back({std::move(value), combine});
}

void LocalDeclaration::state(const std::string &name, const std::vector<std::string> &names,
                             std::function<int()> value) {
  info_.scalars.push_back({name, "", names});
  scalars_.push_back({[value = std::move(value)] { return static_cast<double>(value()); }, Combine::first});
}

const LocalDeclaration::Field &LocalDeclaration::field(const std::string &name, bool output) const {
  for (const Field &field : fields_)
    if (field.info.name == name && field.info.output == output)
      return field;
  throw Failure(ExitCode::handshake, "field '" + name + "' has not been declared");
}

const std::vector<double> &LocalDeclaration::coordinates(const std::string &point_set) const {
  for (const PointSetInfo &set : info_.point_sets)
    if (set.name == point_set)
      return set.coordinates.front();
  throw Failure(ExitCode::handshake, "point set '" + point_set + "' must be declared before its fields");
}

std::size_t LocalDeclaration::n_values(const std::string &point_set, unsigned components) const {
  return point_set == global ? components : coordinates(point_set).size() / 3 * components;
}

std::vector<double> LocalDeclaration::scalars() const {
  std::vector<double> values;
  for (const Scalar &scalar : scalars_)
    values.push_back(scalar.value());
  return values;
}

void LocalDeclaration::combine(const std::vector<double> &more, std::vector<double> &scalars) const {
  for (std::size_t k = 0; k < scalars_.size(); ++k) {
    const Combine how = scalars_[k].combine;
    if (how == Combine::sum) {
      scalars[k] += more[k];
      continue;
    }
    const bool is_beaten = how == Combine::min ? more[k] < scalars[k] : more[k] > scalars[k];
    if (how != Combine::first && (is_beaten || std::isnan(more[k])))
      scalars[k] = more[k];
  }
}

} // namespace heartbus::bus
