#pragma once

#include <string>
#include <vector>

namespace heartbus::config {

/// A scene as written: blocks, lists and scalars, each knowing the file and line it came from, so that files can be
/// laid over each other without errors losing their place.
struct Node {
  enum class Kind { empty, scalar, list, block };
  Kind kind = Kind::empty;
  std::string key;   ///< of an entry of a block
  std::string where; ///< "file:line", or "--set path=value"
  std::string value; ///< of a scalar
  std::vector<Node> children;

  const Node *find(const std::string &name) const; ///< null when there is none
};

/// Parses YAML; duplicate keys are refused. Throws Failure(scene).
Node parse_yaml(const std::string &text, const std::string &file_name);

/// Reads a file. A top-level key `base: other.yaml` (relative to this file) lays this file over that one; keys with an
/// empty value are taken away.
Node load_yaml(const std::string &file_name);

/// Sets `path` ("a.b.c") to the YAML text `value`, creating blocks as needed.
void set_value(Node &root, const std::string &path, const std::string &value, const std::string &where);

} // namespace heartbus::config
