#pragma once

#include <fstream>
#include <string>
#include <vector>

namespace heartbus::coupler {

/// What the participants reported, one row a step; the first row is the state before the first step.
struct History {
  struct Column {
    std::string name, unit;
    std::vector<std::string> states; ///< names of the values; empty for a number
  };
  std::vector<Column> columns; ///< the first two are "step" and "time" [s]
  std::vector<std::vector<double>> rows;

  /// Index of a column, or -1.
  int find(const std::string &name) const;
  /// All values of a column; empty when there is none.
  std::vector<double> values(const std::string &name) const;
};

/// history.csv: names with units in the header, numbers that read back to the same bits, states by name.
class HistoryFile {
 public:
  /// Begins with the rows that there are.
  HistoryFile(const std::string &file_name, const History &history);
  /// Appends the last row; it is on disk when this returns.
  void append(const History &history);

 private:
  void write(const History &history, const std::vector<double> &row);
  std::string file_name_;
  std::ofstream file_;
};

/// Appends the rows of a history.csv, whose columns may be others: those missing there get NaN. Throws Failure(file).
void read_history(const std::string &file_name, History &history);

/// One value as history.csv shows it.
std::string shown(const History::Column &column, double value);

} // namespace heartbus::coupler
