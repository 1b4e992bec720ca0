#include "common/config/node.h"

#include "common/bus/failure.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <yaml-cpp/yaml.h>

namespace heartbus::config {

namespace {

std::string place(const std::string &file_name, const YAML::Mark &mark) {
  return file_name + ":" + std::to_string(mark.line + 1);
}

Node converted(const YAML::Node &yaml, const std::string &file_name) {
  Node node;
  node.where = place(file_name, yaml.Mark());
  if (yaml.IsScalar()) {
    node.kind = Node::Kind::scalar;
    node.value = yaml.Scalar();
  } else if (yaml.IsSequence()) {
    node.kind = Node::Kind::list;
    for (const auto &item : yaml)
      node.children.push_back(converted(item, file_name));
  } else if (yaml.IsMap()) {
    node.kind = Node::Kind::block;
    for (const auto &entry : yaml) {
      Node child = converted(entry.second, file_name);
      child.key = entry.first.IsScalar() ? entry.first.Scalar() : "";
      child.where = place(file_name, entry.first.Mark());
      if (child.key.empty())
        throw Failure(ExitCode::scene, child.where + ": a key must be a word");
      if (const Node *first = node.find(child.key))
        throw Failure(ExitCode::scene,
                      child.where + ": key '" + child.key + "' is given twice; first at " + first->where);
      node.children.push_back(std::move(child));
    }
  }
  return node;
}

// Lays `over` onto `under`: blocks are united, everything else is replaced, an empty value takes the key away.
void overlay(Node &under, const Node &over) {
  if (under.kind != Node::Kind::block || over.kind != Node::Kind::block) {
    under = over;
    return;
  }
  under.where = over.where;
  for (const Node &child : over.children) {
    const auto same = std::find_if(under.children.begin(), under.children.end(),
                                   [&](const Node &other) { return other.key == child.key; });
    if (same == under.children.end())
      under.children.push_back(child);
    else if (child.kind == Node::Kind::empty)
      under.children.erase(same);
    else
      overlay(*same, child);
  }
}

Node load_on_base(const std::string &file_name, int depth) {
  std::ifstream file(file_name);
  std::ostringstream text;
  if (!file || std::filesystem::is_directory(file_name) || !(text << file.rdbuf()))
    throw Failure(ExitCode::file, file_name + ": this scene file cannot be read");
  Node node = parse_yaml(text.str(), file_name);
  const auto base =
      std::find_if(node.children.begin(), node.children.end(), [](const Node &child) { return child.key == "base"; });
  if (base == node.children.end())
    return node;
  if (depth > 8)
    throw Failure(ExitCode::scene, base->where + ": 'base' files refer to each other in a circle");
  const auto base_name = std::filesystem::path(file_name).parent_path() / base->value;
  if (!std::filesystem::is_regular_file(base_name))
    throw Failure(ExitCode::file, base->where + ": the base file '" + base_name.string() + "' does not exist");
  Node whole = load_on_base(base_name.string(), depth + 1);
  node.children.erase(base);
  overlay(whole, node);
  return whole;
}

} // namespace

const Node *Node::find(const std::string &name) const {
  for (const Node &child : children)
    if (child.key == name)
      return &child;
  return nullptr;
}

Node parse_yaml(const std::string &text, const std::string &file_name) {
  try {
    Node node = converted(YAML::Load(text), file_name);
    if (node.kind == Node::Kind::empty)
      node.kind = Node::Kind::block;
    if (node.kind != Node::Kind::block)
      throw Failure(ExitCode::scene, file_name + ":1: a scene is a block of 'key: value' lines");
    return node;
  } catch (const YAML::ParserException &error) {
    throw Failure(ExitCode::scene, place(file_name, error.mark) + ": this is not YAML: " + error.msg);
  }
}

Node load_yaml(const std::string &file_name) { return load_on_base(file_name, 0); }

void set_value(Node &root, const std::string &path, const std::string &value, const std::string &where) {
  Node over; // the path as a chain of blocks around the value
  try {
    over = converted(YAML::Load(value), where);
  } catch (const YAML::ParserException &error) {
    throw Failure(ExitCode::scene, where + ": the value is not YAML: " + error.msg);
  }
  std::string rest = path;
  while (!rest.empty()) {
    const std::size_t dot = rest.rfind('.');
    over.key = dot == std::string::npos ? rest : rest.substr(dot + 1);
    over.where = where;
    rest = dot == std::string::npos ? "" : rest.substr(0, dot);
    Node block;
    block.kind = Node::Kind::block;
    block.where = where;
    block.children.push_back(std::move(over));
    over = std::move(block);
  }
  overlay(root, over);
}

} // namespace heartbus::config
