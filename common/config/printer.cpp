#include "common/config/printer.h"

#include "common/base/failure.h"
#include "common/units/nearest.h"
#include "common/units/units.h"

#include <algorithm>

namespace heartbus::config {

namespace {

std::string quoted_if_needed(const std::string &text) {
  const bool plain = !text.empty() && text.find_first_of(":#{}[],&*!|'\"%@`\\\n") == std::string::npos &&
                     text.find_first_of(" -?>") != 0 && text.back() != ' ' && text != "~" && text != "null";
  if (plain)
    return text;
  std::string quoted = "\"";
  for (const char c : text)
    quoted += c == '"' || c == '\\' ? std::string("\\") + c : c == '\n' ? "\\n" : std::string(1, c);
  return quoted + "\"";
}

std::string to_text(const std::vector<Outline> &lines, const std::string &indent) {
  std::string text;
  for (const Outline &line : lines)
    text += "\n" + indent + "- " + quoted_if_needed(line.text) +
            (line.lines.empty() ? "" : ":" + to_text(line.lines, indent + "    "));
  return text;
}

class Printer : public Section {
 public:
  void quantity(const std::string &key, double &value, const std::string &unit, Range,
                const std::string &meaning) override {
    entries_.push_back({key, with_unit(value, unit), meaning, {}});
  }
  void quantity_or(const std::string &key, double &value, const std::string &unit, Range, const std::string &word,
                   bool &is_word, const std::string &meaning) override {
    entries_.push_back({key, is_word ? word : with_unit(value, unit), meaning + ", or '" + word + "'", {}});
  }
  void number(const std::string &key, double &value, Range, const std::string &meaning) override {
    entries_.push_back({key, shortest(value), meaning, {}});
  }
  void integer(const std::string &key, int &value, Range, const std::string &meaning) override {
    entries_.push_back({key, std::to_string(value), meaning, {}});
  }
  void integer_or(const std::string &key, int &value, Range, const std::string &word, bool &is_word,
                  const std::string &meaning) override {
    entries_.push_back({key, is_word ? word : std::to_string(value), meaning + ", or '" + word + "'", {}});
  }
  void boolean(const std::string &key, bool &value, const std::string &meaning) override {
    entries_.push_back({key, value ? "true" : "false", meaning, {}});
  }
  void text(const std::string &key, std::string &value, const std::string &meaning) override {
    entries_.push_back({key, quoted_if_needed(value), meaning, {}});
  }
  void choice(const std::string &key, std::string &value, const std::vector<std::string> &allowed,
              const std::string &meaning) override {
    entries_.push_back({key, quoted_if_needed(value), meaning + " (" + joined(allowed) + ")", {}});
  }
  void texts(const std::string &key, std::vector<std::string> &values, const std::string &meaning) override {
    std::vector<std::string> words;
    for (const auto &value : values)
      words.push_back(quoted_if_needed(value));
    entries_.push_back({key, "[" + joined(words) + "]", meaning, {}});
  }
  void outline(const std::string &key, std::vector<Outline> &lines, const std::string &meaning) override {
    entries_.push_back({key, lines.empty() ? "[]" : "", meaning, {}, false, lines});
  }
  void quantities(const std::string &key, std::vector<double> &values, const std::string &unit, unsigned,
                  const std::string &meaning) override {
    std::vector<std::string> words;
    for (const double value : values)
      words.push_back(with_unit(value, unit));
    entries_.push_back({key, "[" + joined(words) + "]", meaning, {}});
  }
  Section &section(const std::string &key, const std::string &meaning) override {
    entries_.push_back({key, "", meaning, {}});
    entries_.back().blocks.push_back(std::make_unique<Printer>());
    return *entries_.back().blocks.back();
  }
  std::vector<std::string> free_keys() override { return {}; }
  std::size_t list(const std::string &key, std::size_t current, const std::string &meaning) override {
    entries_.push_back({key, "[]", meaning, {}});
    return current;
  }
  Section &item(const std::string &key, std::size_t) override {
    const auto entry = std::find_if(entries_.begin(), entries_.end(), [&](const Entry &e) { return e.key == key; });
    entry->is_list = true;
    entry->value.clear();
    entry->blocks.push_back(std::make_unique<Printer>());
    return *entry->blocks.back();
  }
  std::string file(const std::string &, const std::string &name) override { return name; }
  [[noreturn]] void fail(const std::string &key, const std::string &message) override {
    throw Failure(ExitCode::scene, "key '" + key + "': " + message);
  }

  std::string lines(const std::string &indent) const {
    std::string text;
    for (const Entry &entry : entries_) {
      const bool nothing_inside = !entry.blocks.empty() && !entry.is_list && entry.blocks[0]->entries_.empty();
      std::string line = indent + entry.key + ":";
      if (const std::string value = nothing_inside ? "{}" : entry.value; !value.empty())
        line += " " + value;
      if (!entry.meaning.empty())
        line += std::string(std::max<int>(2, 44 - static_cast<int>(line.size())), ' ') + "# " + entry.meaning;
      text += line + to_text(entry.outline, indent + "  ") + "\n";
      for (const auto &block : entry.blocks) {
        std::string inner = block->lines(indent + (entry.is_list ? "    " : "  "));
        if (entry.is_list && !inner.empty())
          inner[indent.size() + 2] = '-';
        text += inner;
      }
    }
    return text;
  }

  void collect_values(const std::string &prefix, std::vector<std::pair<std::string, std::string>> &values) const {
    for (const Entry &entry : entries_) {
      if (entry.blocks.empty())
        values.emplace_back(prefix + entry.key, entry.value);
      for (const auto &block : entry.blocks)
        if (!entry.is_list)
          block->collect_values(prefix + entry.key + ".", values);
    }
  }

  void collect_paths(const std::string &prefix, std::vector<std::string> &paths) const {
    for (const Entry &entry : entries_) {
      paths.push_back(prefix + entry.key);
      for (const auto &block : entry.blocks)
        if (!entry.is_list)
          block->collect_paths(prefix + entry.key + ".", paths);
    }
  }

 private:
  struct Entry {
    std::string key, value, meaning;
    std::vector<std::unique_ptr<Printer>> blocks; ///< one for a block, any number for a list
    bool is_list = false;
    std::vector<Outline> outline{};
  };
  std::vector<Entry> entries_;
};

} // namespace

std::string print(const Describe &describe) {
  Printer printer;
  describe(printer);
  return printer.lines("");
}

std::vector<std::pair<std::string, std::string>> values(const Describe &describe) {
  Printer printer;
  describe(printer);
  std::vector<std::pair<std::string, std::string>> all;
  printer.collect_values("", all);
  return all;
}

std::vector<std::string> key_paths(const Describe &describe) {
  Printer printer;
  describe(printer);
  std::vector<std::string> paths;
  printer.collect_paths("", paths);
  return paths;
}

} // namespace heartbus::config
