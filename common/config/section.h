#pragma once

#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace heartbus::config {

/// Allowed values of a number, in the unit of its key.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_excluded = false;
  const char *why = ""; ///< what is wrong with others, for whoever wrote one
};
inline constexpr Range any{};
inline constexpr Range positive{0, std::numeric_limits<double>::infinity(), true};
inline constexpr Range non_negative{0};
constexpr Range between(double low, double high, const char *why = "") { return {low, high, false, why}; }

/// Lines of text, some of which have lines of their own: "- solve ep", "- 2 times:" with a list below.
struct Outline {
  std::string text;
  std::string where; ///< "file:line"
  std::vector<Outline> lines;
};

/// A block of the scene, seen by the code that owns its keys. Each parameter is written once, in a `describe` function:
///
///     struct Guccione { double c = 880; void describe(config::Section &s) { s.quantity("c", c, "Pa", positive, "...");
///     } };
///
/// The variable's initial value is the default. The same call reads and checks the value (when the scene is read),
/// prints it (resolved scene, --print-defaults) or documents it. Errors: Failure(ExitCode::scene) naming file:line,
/// key, nearest known key, allowed range or unit.
class Section {
 public:
  virtual ~Section() = default;
  /// `unit` is what the code computes in; the scene may use any unit of the same dimension ("0.2 ms", "10 mmHg").
  virtual void quantity(const std::string &key, double &value, const std::string &unit, Range range,
                        const std::string &meaning) = 0;
  /// The same, or one word in its place: `is_word` tells which.
  virtual void quantity_or(const std::string &key, double &value, const std::string &unit, Range range,
                           const std::string &word, bool &is_word, const std::string &meaning) = 0;
  /// A plain number without a unit.
  virtual void number(const std::string &key, double &value, Range range, const std::string &meaning) = 0;
  virtual void integer(const std::string &key, int &value, Range range, const std::string &meaning) = 0;
  /// The same, or one word in its place: `is_word` tells which.
  virtual void integer_or(const std::string &key, int &value, Range range, const std::string &word, bool &is_word,
                          const std::string &meaning) = 0;
  virtual void boolean(const std::string &key, bool &value, const std::string &meaning) = 0;
  virtual void text(const std::string &key, std::string &value, const std::string &meaning) = 0;
  virtual void choice(const std::string &key, std::string &value, const std::vector<std::string> &allowed,
                      const std::string &meaning) = 0;
  virtual void texts(const std::string &key, std::vector<std::string> &values, const std::string &meaning) = 0;
  virtual void outline(const std::string &key, std::vector<Outline> &lines, const std::string &meaning) = 0;
  /// A list of numbers that share a unit, e.g. a point "[0 mm, 0 mm, 3 mm]"; `size` 0 allows any length.
  virtual void quantities(const std::string &key, std::vector<double> &values, const std::string &unit, unsigned size,
                          const std::string &meaning) = 0;
  /// A nested block; absent in the scene means all defaults.
  virtual Section &section(const std::string &key, const std::string &meaning) = 0;
  /// The keys of a block whose names the scene chooses (e.g. participants); empty while printing defaults.
  virtual std::vector<std::string> free_keys() = 0;
  /// A list of blocks; returns how many there are (or `current` while printing), each then visited by item(key, i).
  virtual std::size_t list(const std::string &key, std::size_t current, const std::string &meaning) = 0;
  virtual Section &item(const std::string &key, std::size_t index) = 0;
  /// The file that a key names, relative to the scene file in which it does.
  virtual std::string file(const std::string &key, const std::string &name) = 0;
  /// A check that spans several keys: fails at this block's line.
  [[noreturn]] virtual void fail(const std::string &key, const std::string &message) = 0;
};

/// Blocks whose names the scene chooses; those that are new begin with the `usual` parameters.
template <class Parameters>
std::map<std::string, Parameters> &named(std::map<std::string, Parameters> &all, Section &s, const Parameters &usual) {
  for (const auto &name : s.free_keys())
    all.emplace(name, usual);
  return all;
}

} // namespace heartbus::config
