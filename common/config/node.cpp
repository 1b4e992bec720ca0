#include "common/config/node.h"

#include "common/base/failure.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <yaml-cpp/yaml.h>

namespace heartbus::config {

namespace {

std::string place(const std::string &file_name, const YAML::Mark &mark) {
  return file_name + ":" + std::to_string(std::max(mark.line, 0) + 1);
}

constexpr std::size_t longest_text = 1 << 20, deepest = 32, most_entries = 20000;

/// An alias stands for what it names, which may be itself, or grow with each: depth and number are limited.
class Converter {
 public:
  explicit Converter(const std::string &file_name) : file_name_(file_name) {}

  Node convert(const YAML::Node &yaml) {
    Node node;
    node.where = place(file_name_, yaml.Mark());
    if (++depth_ > deepest)
      throw Failure(ExitCode::scene, node.where + ": blocks or lists are nested more than " + std::to_string(deepest) +
                                         " deep; does an alias (*) name a block that holds it?");
    if (++n_entries_ > most_entries)
      throw Failure(ExitCode::scene, node.where + ": more than " + std::to_string(most_entries) +
                                         " entries; do aliases (*) name blocks full of aliases?");
    fill(node, yaml);
    --depth_;
    return node;
  }

 private:
  void fill(Node &node, const YAML::Node &yaml);
  void add_entry(Node &node, const YAML::Node &key, const YAML::Node &value);

  const std::string &file_name_;
  std::size_t depth_ = 0, n_entries_ = 0;
};

void Converter::fill(Node &node, const YAML::Node &yaml) {
  if (yaml.IsScalar()) {
    node.kind = Node::Kind::scalar;
    node.value = yaml.Scalar();
  } else if (yaml.IsSequence()) {
    node.kind = Node::Kind::list;
    for (const auto &item : yaml)
      node.children.push_back(convert(item));
  } else if (yaml.IsMap()) {
    node.kind = Node::Kind::block;
    for (const auto &entry : yaml)
      add_entry(node, entry.first, entry.second);
  }
}

void Converter::add_entry(Node &node, const YAML::Node &key, const YAML::Node &value) {
  Node child = convert(value);
  child.key = key.IsScalar() ? key.Scalar() : "";
  child.where = place(file_name_, key.Mark());
  if (child.key.empty())
    throw Failure(ExitCode::scene, child.where + ": a key must be a word");
  if (const Node *first = node.find(child.key))
    throw Failure(ExitCode::scene, child.where + ": key '" + child.key + "' is given twice; first at " + first->where);
  node.children.push_back(std::move(child));
}

/// `what` is said of text that is no YAML.
Node converted(const std::string &text, const std::string &file_name, const std::string &what) {
  if (text.size() > longest_text)
    throw Failure(ExitCode::scene, file_name + ":1: the text is longer than any scene (1 MiB)");
  try {
    return Converter(file_name).convert(YAML::Load(text));
  } catch (const YAML::Exception &error) {
    throw Failure(ExitCode::scene, place(file_name, error.mark) + ": " + what + " is not YAML: " + error.msg);
  }
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
  std::error_code error; // e.g. a name too long
  std::ifstream file(file_name);
  std::string text(longest_text + 1, '\0'); // one more than is allowed, of a file that may have no end
  if (!file || std::filesystem::is_directory(file_name, error))
    throw Failure(ExitCode::file, file_name + ": this scene file cannot be read");
  file.read(text.data(), text.size());
  if (file.bad())
    throw Failure(ExitCode::file, file_name + ": this scene file cannot be read");
  text.resize(file.gcount());
  Node node = parse_yaml(text, file_name);
  const auto base =
      std::find_if(node.children.begin(), node.children.end(), [](const Node &child) { return child.key == "base"; });
  if (base == node.children.end())
    return node;
  if (depth > 8)
    throw Failure(ExitCode::scene, base->where + ": 'base' files refer to each other in a circle");
  const auto base_name = std::filesystem::path(file_name).parent_path() / base->value;
  if (!std::filesystem::is_regular_file(base_name, error))
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
  Node node = converted(text, file_name, "this");
  if (node.kind == Node::Kind::empty)
    node.kind = Node::Kind::block;
  if (node.kind != Node::Kind::block)
    throw Failure(ExitCode::scene, file_name + ":1: a scene is a block of 'key: value' lines");
  return node;
}

Node load_yaml(const std::string &file_name) { return load_on_base(file_name, 0); }

void set_value(Node &root, const std::string &path, const std::string &value, const std::string &where) {
  if (path.size() > 200)
    throw Failure(ExitCode::scene, where + ": the key is longer than any");
  Node over; // the path as a chain of blocks around the value
  try {
    over = converted(value, where, "the value");
  } catch (const Failure &failure) { // there are no lines on the command line
    std::string what = failure.what();
    if (const std::size_t line = what.find(":1: "); line == where.size())
      what.erase(line, 2);
    throw Failure(failure.code(), what);
  }
  over.where = where;
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
