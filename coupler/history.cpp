#include "coupler/history.h"

#include "common/base/failure.h"
#include "common/units/units.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <sstream>

namespace heartbus::coupler {

int History::find(const std::string &name) const {
  for (std::size_t c = 0; c < columns.size(); ++c)
    if (columns[c].name == name)
      return static_cast<int>(c);
  return -1;
}

std::vector<double> History::values(const std::string &name) const {
  std::vector<double> column;
  if (const int c = find(name); c >= 0)
    for (const auto &row : rows)
      column.push_back(row[c]);
  return column;
}

std::string shown(const History::Column &column, double value) {
  if (!column.states.empty() && value >= 0 && value < column.states.size())
    return column.states[static_cast<std::size_t>(value)];
  return config::shortest(value);
}

HistoryFile::HistoryFile(const std::string &file_name, const History &history)
    : file_name_(file_name), file_(file_name) {
  for (const auto &column : history.columns) {
    const bool has_unit = !column.unit.empty() && column.unit != "1";
    file_ << (&column == &history.columns.front() ? "" : ",") << column.name
          << (has_unit ? " [" + column.unit + "]" : "");
  }
  file_ << '\n';
  for (const auto &row : history.rows)
    write(history, row);
}

void HistoryFile::append(const History &history) { write(history, history.rows.back()); }

void HistoryFile::write(const History &history, const std::vector<double> &row) {
  for (std::size_t c = 0; c < row.size(); ++c)
    file_ << (c == 0 ? "" : ",") << shown(history.columns[c], row[c]);
  file_ << std::endl;
  if (!file_)
    throw Failure(ExitCode::file, file_name_ + ": cannot be written (disk full?)");
}

namespace {

std::vector<std::string> cells(const std::string &line) {
  std::vector<std::string> words;
  std::stringstream stream(line);
  for (std::string word; std::getline(stream, word, ',');)
    words.push_back(word);
  return words;
}

double read_value(const History::Column &column, const std::string &text) {
  const auto state = std::find(column.states.begin(), column.states.end(), text);
  return state != column.states.end() ? state - column.states.begin() : std::strtod(text.c_str(), nullptr);
}

} // namespace

void read_history(const std::string &file_name, History &history) {
  std::ifstream file(file_name);
  std::string line;
  if (!std::getline(file, line))
    throw Failure(ExitCode::file, file_name + ": cannot be read");
  std::vector<int> columns; // of the history
  for (const auto &title : cells(line))
    columns.push_back(history.find(title.substr(0, title.find(" ["))));
  while (std::getline(file, line)) {
    auto &row = history.rows.emplace_back(history.columns.size(), std::numeric_limits<double>::quiet_NaN());
    const auto values = cells(line);
    for (std::size_t c = 0; c < std::min(values.size(), columns.size()); ++c)
      if (columns[c] >= 0)
        row[columns[c]] = read_value(history.columns[columns[c]], values[c]);
  }
}

} // namespace heartbus::coupler
