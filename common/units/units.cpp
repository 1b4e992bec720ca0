#include "common/units/units.h"

#include "common/units/nearest.h"

#include <charconv>
#include <cmath>
#include <map>
#include <stdexcept>
#include <vector>

namespace heartbus::config {

namespace {

struct Symbol {
  Unit unit;
  bool takes_prefix;
};

const std::map<std::string, Symbol> &symbols() {
  //                                               m  kg  s  A  V  M  K rad
  static const std::map<std::string, Symbol> table{
      {"1", {{1, 0, {}}, false}},
      {"%", {{1, -2, {}}, false}},
      {"m", {{1, 0, {1, 0, 0, 0, 0, 0, 0, 0}}, true}},
      {"g", {{1, -3, {0, 1, 0, 0, 0, 0, 0, 0}}, true}},
      {"s", {{1, 0, {0, 0, 1, 0, 0, 0, 0, 0}}, true}},
      {"A", {{1, 0, {0, 0, 0, 1, 0, 0, 0, 0}}, true}},
      {"V", {{1, 0, {0, 0, 0, 0, 1, 0, 0, 0}}, true}},
      {"M", {{1, 0, {0, 0, 0, 0, 0, 1, 0, 0}}, true}},
      {"K", {{1, 0, {0, 0, 0, 0, 0, 0, 1, 0}}, false}},
      {"rad", {{1, 0, {0, 0, 0, 0, 0, 0, 0, 1}}, false}},
      {"deg", {{3.14159265358979323846 / 180, 0, {0, 0, 0, 0, 0, 0, 0, 1}}, false}},
      {"Hz", {{1, 0, {0, 0, -1, 0, 0, 0, 0, 0}}, true}},
      {"N", {{1, 0, {1, 1, -2, 0, 0, 0, 0, 0}}, true}},
      {"Pa", {{1, 0, {-1, 1, -2, 0, 0, 0, 0, 0}}, true}},
      {"bar", {{1, 5, {-1, 1, -2, 0, 0, 0, 0, 0}}, true}},
      {"mmHg", {{133.322387415, 0, {-1, 1, -2, 0, 0, 0, 0, 0}}, false}},
      {"J", {{1, 0, {2, 1, -2, 0, 0, 0, 0, 0}}, true}},
      {"W", {{1, 0, {2, 1, -3, 0, 0, 0, 0, 0}}, true}},
      {"L", {{1, -3, {3, 0, 0, 0, 0, 0, 0, 0}}, true}},
      {"S", {{1, 0, {0, 0, 0, 1, -1, 0, 0, 0}}, true}},
      {"F", {{1, 0, {0, 0, 1, 1, -1, 0, 0, 0}}, true}},
      {"C", {{1, 0, {0, 0, 1, 1, 0, 0, 0, 0}}, true}}};
  return table;
}

const std::map<std::string, int> &prefixes() {
  static const std::map<std::string, int> table{{"G", 9},  {"M", 6},  {"k", 3},  {"d", -1}, {"c", -2},
                                                {"m", -3}, {"u", -6}, {"n", -9}, {"p", -12}};
  return table;
}

Unit symbol(const std::string &name) {
  const auto exact = symbols().find(name);
  if (exact != symbols().end())
    return exact->second.unit;
  const auto prefix = prefixes().find(name.substr(0, 1));
  const auto stem = symbols().find(name.substr(std::min<std::size_t>(1, name.size())));
  if (prefix != prefixes().end() && stem != symbols().end() && stem->second.takes_prefix) {
    Unit unit = stem->second.unit;
    unit.decade += prefix->second;
    return unit;
  }
  std::vector<std::string> known;
  for (const auto &[text, entry] : symbols()) {
    known.push_back(text);
    for (const auto &[letter, decade] : prefixes())
      if (entry.takes_prefix)
        known.push_back(letter + text);
  }
  throw std::invalid_argument("unit '" + name + "' is unknown" + did_you_mean(name, known));
}

Unit power(const Unit &unit, int exponent) {
  if (std::abs(exponent) > 9)
    throw std::invalid_argument("a unit to the power of " + std::to_string(exponent) + " measures nothing");
  Unit result{std::pow(unit.factor, exponent), unit.decade * exponent, unit.powers};
  for (int &p : result.powers)
    p *= exponent;
  return result;
}

Unit product(const Unit &a, const Unit &b) {
  Unit result{a.factor * b.factor, a.decade + b.decade, a.powers};
  for (std::size_t i = 0; i < result.powers.size(); ++i)
    result.powers[i] += b.powers[i];
  return result;
}

// Recursive descent: product := factor { [* | /] factor },  factor := symbol [^ integer] | ( product ).
class Parser {
 public:
  explicit Parser(const std::string &text) : text_(text) {}

  Unit whole() {
    const Unit unit = product_of_factors();
    if (at_ < text_.size())
      throw std::invalid_argument("unit '" + text_ + "' has an unexpected '" + text_.substr(at_, 1) + "'");
    return unit;
  }

 private:
  Unit product_of_factors() {
    Unit unit = factor();
    while (skip_spaces(), at_ < text_.size() && text_[at_] != ')') {
      const bool divide = accept('/');
      if (!divide)
        accept('*');
      unit = product(unit, power(factor(), divide ? -1 : 1));
    }
    return unit;
  }

  Unit factor() {
    skip_spaces();
    if (accept('(')) {
      if (++depth_ > 10)
        throw std::invalid_argument("unit '" + text_ + "' has brackets in brackets, more than ten deep");
      const Unit unit = product_of_factors();
      --depth_;
      if (!accept(')'))
        throw std::invalid_argument("unit '" + text_ + "' lacks a ')'");
      return unit;
    }
    const std::size_t end = std::min(text_.find_first_of(" */()^", at_), text_.size());
    if (end == at_)
      throw std::invalid_argument("unit '" + text_ + "' is incomplete");
    const Unit unit = symbol(text_.substr(at_, end - at_));
    at_ = end;
    return accept('^') ? power(unit, exponent()) : unit;
  }

  int exponent() {
    int value = 0;
    const auto result = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (result.ec != std::errc())
      throw std::invalid_argument("unit '" + text_ + "' needs an integer after '^'");
    at_ = result.ptr - text_.data();
    return value;
  }

  bool accept(char c) {
    skip_spaces();
    if (at_ >= text_.size() || text_[at_] != c)
      return false;
    ++at_;
    return true;
  }

  void skip_spaces() {
    while (at_ < text_.size() && text_[at_] == ' ')
      ++at_;
  }

  std::string text_;
  std::size_t at_ = 0;
  int depth_ = 0; ///< of brackets
};

std::string trimmed(const std::string &text) {
  const std::size_t first = text.find_first_not_of(" \t");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::string dimension_name(const Unit &unit) {
  static const std::vector<std::pair<std::string, std::string>> names{
      {"length", "m"},       {"area", "m^2"},      {"volume", "m^3"},        {"time", "s"},
      {"rate", "1/s"},       {"velocity", "m/s"},  {"flow", "m^3/s"},        {"mass", "kg"},
      {"density", "kg/m^3"}, {"force", "N"},       {"pressure", "Pa"},       {"viscosity", "Pa s"},
      {"energy", "J"},       {"power", "W"},       {"voltage", "V"},         {"concentration", "M"},
      {"angle", "rad"},      {"temperature", "K"}, {"diffusivity", "m^2/s"}, {"current", "A"}};
  for (const auto &[name, example] : names)
    if (parse_unit(example).same_dimension(unit))
      return name;
  return "";
}

double scaled(double value, int decade) {
  return decade < 0 ? value / std::pow(10.0, -decade) : value * std::pow(10.0, decade);
}

} // namespace

Unit parse_unit(const std::string &text) {
  if (text.size() > 100)
    throw std::invalid_argument("'" + text + "' is longer than any unit");
  // The micro sign and the Greek letter mu, as users type them.
  std::string plain = trimmed(text);
  for (const char *mu : {"\xC2\xB5", "\xCE\xBC"})
    for (std::size_t at; (at = plain.find(mu)) != std::string::npos;)
      plain.replace(at, 2, "u");
  return Parser(plain).whole();
}

double parse_number(const std::string &text) {
  const std::string plain = trimmed(text);
  double value = 0;
  const auto result = std::from_chars(plain.data(), plain.data() + plain.size(), value);
  if (result.ec != std::errc() || result.ptr != plain.data() + plain.size() || !std::isfinite(value))
    throw std::invalid_argument("'" + plain + "' is not a number");
  return value;
}

double parse_quantity(const std::string &text, const std::string &unit) {
  const std::string plain = trimmed(text);
  double value = 0;
  const auto result = std::from_chars(plain.data(), plain.data() + plain.size(), value);
  if (result.ec != std::errc() || !std::isfinite(value))
    throw std::invalid_argument("'" + plain + "' is not a number with a unit, e.g. '1 " + unit + "'");
  const std::string given_text = trimmed(plain.substr(result.ptr - plain.data()));
  if (given_text.empty() && unit == "1")
    return value;
  if (given_text.empty())
    throw std::invalid_argument("'" + plain + "' has no unit; write e.g. '" + plain + " " + unit + "'");
  const Unit given = parse_unit(given_text), wanted = parse_unit(unit);
  if (!given.same_dimension(wanted)) {
    const std::string name = dimension_name(wanted);
    throw std::invalid_argument("expected a " + (name.empty() ? "unit" : name + "-like unit") + ", e.g. " + unit +
                                "; got " + given_text);
  }
  const double converted = scaled(value, given.decade - wanted.decade) * (given.factor / wanted.factor);
  if (!std::isfinite(converted) || (converted == 0 && value != 0))
    throw std::invalid_argument("'" + plain + "' is too " + (converted == 0 ? "small" : "large") + " for a number in " +
                                unit);
  return converted;
}

std::string with_unit(double value, const std::string &unit) {
  return unit.empty() || unit == "1" ? shortest(value) : shortest(value) + " " + unit;
}

std::string shortest(double value) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

} // namespace heartbus::config
