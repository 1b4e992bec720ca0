#include "common/config/reader.h"

#include "common/base/failure.h"
#include "common/units/nearest.h"
#include "common/units/units.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

namespace heartbus::config {

namespace {

std::string allowed_range(const Range &range, const std::string &unit) {
  const bool low = std::isfinite(range.low), high = std::isfinite(range.high);
  if (low && high)
    return (range.low_excluded ? "above " : "from ") + shortest(range.low) + " to " + with_unit(range.high, unit);
  if (low)
    return (range.low_excluded ? "above " : "at least ") + with_unit(range.low, unit);
  return "at most " + with_unit(range.high, unit);
}

class Reader final : public Section {
 public:
  /// `node` is null for a block that the scene leaves out.
  Reader(const Node *node, const std::string &path, const std::string &where)
      : node_(node), path_(path), where_(node ? node->where : where) {
    if (node_ && node_->kind == Node::Kind::empty)
      node_ = nullptr;
    if (node_ && node_->kind != Node::Kind::block)
      throw Failure(ExitCode::scene, where_ + ": key '" + path_ + "' must be a block of keys");
  }

  void quantity(const std::string &key, double &value, const std::string &unit, Range range,
                const std::string &) override {
    if (const Node *node = scalar(key))
      value = checked(key, converted(key, [&] { return parse_quantity(node->value, unit); }), range, unit);
  }

  void quantity_or(const std::string &key, double &value, const std::string &unit, Range range, const std::string &word,
                   bool &is_word, const std::string &meaning) override {
    if (!take_word(key, word, is_word))
      quantity(key, value, unit, range, meaning);
  }

  void number(const std::string &key, double &value, Range range, const std::string &) override {
    if (const Node *node = scalar(key))
      value = checked(key, converted(key, [&] { return parse_number(node->value); }), range, "");
  }

  void integer(const std::string &key, int &value, Range range, const std::string &) override {
    if (const Node *node = scalar(key)) {
      const double number = converted(key, [&] { return parse_number(node->value); });
      if (number != std::floor(number) || std::abs(number) > 1e9)
        fail(key, "'" + node->value + "' is not an integer");
      value = static_cast<int>(checked(key, number, range, ""));
    }
  }

  void integer_or(const std::string &key, int &value, Range range, const std::string &word, bool &is_word,
                  const std::string &meaning) override {
    if (!take_word(key, word, is_word))
      integer(key, value, range, meaning);
  }

  void boolean(const std::string &key, bool &value, const std::string &) override {
    if (const Node *node = scalar(key)) {
      if (node->value != "true" && node->value != "false")
        fail(key, "'" + node->value + "' is neither true nor false");
      value = node->value == "true";
    }
  }

  void text(const std::string &key, std::string &value, const std::string &) override {
    if (const Node *node = scalar(key))
      value = plain_text(key, node->value);
  }

  void choice(const std::string &key, std::string &value, const std::vector<std::string> &allowed,
              const std::string &) override {
    const Node *node = scalar(key);
    if (!node)
      return;
    if (std::find(allowed.begin(), allowed.end(), node->value) == allowed.end())
      fail(key, "'" + node->value + "' is not a choice" + did_you_mean(node->value, allowed) +
                    " Allowed: " + joined(allowed));
    value = node->value;
  }

  void texts(const std::string &key, std::vector<std::string> &values, const std::string &) override {
    if (const Node *node = list_node(key)) {
      values.clear();
      for (const Node &item : node->children) {
        if (item.kind != Node::Kind::scalar)
          fail(key, "must be a list of words");
        values.push_back(plain_text(key, item.value));
      }
    }
  }

  void outline(const std::string &key, std::vector<Outline> &lines, const std::string &) override {
    if (const Node *node = list_node(key))
      lines = outline_of(key, *node);
  }

  void quantities(const std::string &key, std::vector<double> &values, const std::string &unit, unsigned size,
                  const std::string &) override {
    if (const Node *node = list_node(key)) {
      if (size > 0 && node->children.size() != size)
        fail(key, "must have " + std::to_string(size) + " entries, not " + std::to_string(node->children.size()));
      values.clear();
      for (const Node &item : node->children)
        values.push_back(checked(key, converted(key, [&] { return parse_quantity(item.value, unit); }), any, unit));
    }
  }

  Section &section(const std::string &key, const std::string &) override {
    blocks_.push_back(std::make_unique<Reader>(take(key), full(key), where_));
    return *blocks_.back();
  }

  std::vector<std::string> free_keys() override {
    std::vector<std::string> keys;
    if (node_)
      for (const Node &child : node_->children)
        keys.push_back(child.key);
    return keys;
  }

  std::size_t list(const std::string &key, std::size_t current, const std::string &) override {
    const Node *node = list_node(key);
    return node ? node->children.size() : current;
  }

  Section &item(const std::string &key, std::size_t index) override {
    const Node *node = node_ ? node_->find(key) : nullptr;
    const Node *entry = node && index < node->children.size() ? &node->children[index] : nullptr;
    blocks_.push_back(std::make_unique<Reader>(entry, full(key) + "[" + std::to_string(index) + "]", where_));
    return *blocks_.back();
  }

  std::string file(const std::string &key, const std::string &name) override {
    const Node *node = node_ ? node_->find(key) : nullptr;
    const std::string &where = node ? node->where : where_;
    const bool of_command_line = where.compare(0, 2, "--") == 0;
    const auto folder = std::filesystem::path(of_command_line ? "" : where.substr(0, where.rfind(':'))).parent_path();
    return std::filesystem::absolute(folder / name).lexically_normal().string();
  }

  [[noreturn]] void fail(const std::string &key, const std::string &message) override {
    const Node *node = node_ ? node_->find(key) : nullptr;
    const std::string name = key.empty() ? "block '" + path_ + "'" : "key '" + full(key) + "'";
    throw Failure(ExitCode::scene, (node ? node->where : where_) + ": " + name + ": " + message);
  }

  void refuse_unknown_keys() const {
    if (node_)
      for (const Node &child : node_->children)
        if (std::find(known_.begin(), known_.end(), child.key) == known_.end())
          throw Failure(ExitCode::scene, child.where + ": key '" + full(child.key) + "' is unknown" +
                                             did_you_mean(child.key, known_) + " Allowed here: " + joined(known_));
    for (const auto &block : blocks_)
      block->refuse_unknown_keys();
  }

 private:
  std::string full(const std::string &key) const { return path_.empty() ? key : path_ + "." + key; }

  const Node *take(const std::string &key) {
    known_.push_back(key);
    return node_ ? node_->find(key) : nullptr;
  }

  const Node *scalar(const std::string &key) {
    const Node *node = take(key);
    if (node && node->kind != Node::Kind::scalar)
      fail(key, node->kind == Node::Kind::empty ? "has no value" : "must be a single value");
    return node;
  }

  const Node *list_node(const std::string &key) {
    const Node *node = take(key);
    if (node && node->kind != Node::Kind::list)
      fail(key, "must be a list, e.g. [a, b]");
    return node;
  }

  std::vector<Outline> outline_of(const std::string &key, const Node &list) {
    std::vector<Outline> lines;
    for (const Node &item : list.children)
      if (item.kind == Node::Kind::scalar)
        lines.push_back({plain_text(key, item.value), item.where, {}});
      else if (item.children.size() == 1 && item.children[0].kind == Node::Kind::list)
        lines.push_back({plain_text(key, item.children[0].key), item.where, outline_of(key, item.children[0])});
      else
        throw Failure(ExitCode::scene, item.where + ": key '" + full(key) +
                                           "': an entry is a line, or one with a list of its own: '- 2 times: [a, b]'");
    return lines;
  }

  template <class Conversion>
  double converted(const std::string &key, const Conversion &conversion) {
    std::string complaint;
    try {
      return conversion();
    } catch (const std::invalid_argument &error) {
      complaint = error.what();
    }
    fail(key, complaint);
  }

  /// Whether the scene has this word for the key. `is_word` stays when it has nothing.
  bool take_word(const std::string &key, const std::string &word, bool &is_word) {
    const Node *node = node_ ? node_->find(key) : nullptr;
    if (node)
      is_word = node->kind == Node::Kind::scalar && node->value == word;
    if (node && is_word)
      take(key);
    return node && is_word;
  }

  const std::string &plain_text(const std::string &key, const std::string &text) {
    if (printable(text) != text)
      fail(key, "'" + printable(text) + "' has control characters, or is longer than any name");
    return text;
  }

  double checked(const std::string &key, double value, const Range &range, const std::string &unit) {
    const auto is_within = [&](double x) {
      return x >= range.low && x <= range.high && !(range.low_excluded && x == range.low);
    };
    if (!is_within(value)) {
      const bool is_thousandfold = unit == "m" && std::isfinite(range.high) && is_within(1e-3 * value);
      fail(key, shortest(value) + (unit.empty() ? "" : " " + unit) +
                    " is out of range; allowed: " + allowed_range(range, unit) + (*range.why ? ": " : "") + range.why +
                    (is_thousandfold ? "; metres for millimetres?" : ""));
    }
    constexpr double largest = 1e15;
    if (value != 0 && !(std::abs(value) <= largest && std::abs(value) >= 1 / largest))
      fail(key, shortest(value) + (unit.empty() ? "" : " " + unit) +
                    " is out of range; no quantity here is larger than 1e15 or smaller than 1e-15");
    return value;
  }

  const Node *node_;
  std::string path_, where_;
  std::vector<std::string> known_;
  std::vector<std::unique_ptr<Reader>> blocks_;
};

} // namespace

void read(const Node &root, const Describe &describe) {
  Reader reader(&root, "", root.where);
  describe(reader);
  reader.refuse_unknown_keys();
}

} // namespace heartbus::config
