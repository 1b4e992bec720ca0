#pragma once

#include <string>
#include <vector>

namespace heartbus::stand_in {

/// A field of a role: small values about an offset, whose tone depends on place and time; of a global one on time only.
struct RoleField {
  std::string name, point_set;
  unsigned components;
  std::string unit;
  bool output;
  double offset = 0, amplitude = 0; ///< of outputs
};

/// What others expect of a participant: docs/architecture.md.
struct Role {
  std::vector<RoleField> fields;
  std::vector<std::string> tasks;
};

/// Failure(scene) when no such role is known.
const Role &role(const std::string &name);

} // namespace heartbus::stand_in
