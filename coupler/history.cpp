#include "coupler/history.h"

#include "common/bus/failure.h"
#include "common/config/units.h"

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
}

void HistoryFile::append(const History &history) {
  const auto &row = history.rows.back();
  for (std::size_t c = 0; c < row.size(); ++c)
    file_ << (c == 0 ? "" : ",") << shown(history.columns[c], row[c]);
  file_ << std::endl;
  if (!file_)
    throw Failure(ExitCode::file, file_name_ + ": cannot be written");
}

} // namespace heartbus::coupler
