#include "common/config/table.h"

#include "common/base/failure.h"
#include "common/units/units.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace heartbus::config {

namespace {

constexpr std::size_t most_entries = 5000; // a resolved scene has them all

[[noreturn]] void refuse(const std::string &file, std::size_t line, const std::string &what) {
  throw Failure(ExitCode::scene, file + ":" + std::to_string(line) + ": " + what);
}

std::vector<std::string> columns(std::string line) {
  if (!line.empty() && line.back() == '\r')
    line.pop_back();
  std::vector<std::string> words;
  std::stringstream stream(line);
  for (std::string word; std::getline(stream, word, ',');)
    words.push_back(word);
  return words;
}

/// What is between the brackets of "pressure [kPa]".
std::string unit_of(const std::string &title) {
  const std::size_t open = title.find('['), close = title.find(']');
  return open == std::string::npos || close == std::string::npos || close < open
             ? ""
             : title.substr(open + 1, close - open - 1);
}

} // namespace

double Table::at(double time) const {
  const double slack = 1e-9 * std::abs(time); // round-off of a step that ends at an entry
  const auto next = std::lower_bound(times.begin(), times.end(), time - slack);
  const std::size_t k = next - times.begin();
  if (k == times.size())
    return values.back();
  if (k == 0 || times[k] <= time)
    return values[k];
  const double share = (time - times[k - 1]) / (times[k] - times[k - 1]);
  return (1 - share) * values[k - 1] + share * values[k];
}

void Table::describe(Section &s, const std::string &unit, Range range, const std::string &meaning) {
  std::string file;
  s.text("table", file, "in place of the two: CSV file, two columns with their units in the header");
  if (!file.empty()) {
    const std::string path = s.file("table", file);
    std::string line;
    if (std::ifstream first(path); !std::getline(first, line))
      s.fail("table", path + ": this table cannot be read");
    read(path, unit);
  }
  const auto before = values;
  s.quantities("times", times, "s", 0, "ascending; twice the same: a jump");
  s.quantities("values", values, unit, 0, meaning + ", at these times");
  if (!file.empty() && values != before)
    s.fail("table", "is given beside 'values'; write one of the two");
  if (values.empty() || times.size() != values.size())
    s.fail("values",
           "has " + std::to_string(values.size()) + " entries for " + std::to_string(times.size()) + " of 'times'");
  if (values.size() > most_entries)
    s.fail("values", "has more than " + std::to_string(most_entries) + " entries");
  if (!std::is_sorted(times.begin(), times.end()))
    s.fail("times", "must ascend");
  for (const double value : values)
    if (!(value >= range.low && value <= range.high))
      s.fail("values", with_unit(value, unit) + " is out of range; allowed: from " + shortest(range.low) + " to " +
                           with_unit(range.high, unit) + (*range.why ? ": " : "") + range.why);
}

void Table::read(const std::string &file_name, const std::string &unit) {
  std::ifstream file(file_name);
  std::string line;
  std::getline(file, line);
  const auto titles = columns(line);
  if (titles.size() != 2)
    refuse(file_name, 1, "a table has two columns, 'time [s],value [" + unit + "]'");
  times.clear();
  values.clear();
  for (std::size_t number = 2; std::getline(file, line); ++number) {
    const auto words = columns(line);
    if (words.empty())
      continue;
    if (words.size() != 2 || number > most_entries)
      refuse(file_name, number,
             words.size() != 2 ? "this line has not two columns"
                               : "a table has " + std::to_string(most_entries) + " lines at most");
    try {
      times.push_back(parse_quantity(words[0] + " " + unit_of(titles[0]), "s"));
      values.push_back(parse_quantity(words[1] + " " + unit_of(titles[1]), unit));
    } catch (const std::invalid_argument &error) {
      refuse(file_name, number, error.what());
    }
    if (!std::isfinite(times.back()) || !std::isfinite(values.back()))
      refuse(file_name, number, "this is no finite number");
  }
}

} // namespace heartbus::config
