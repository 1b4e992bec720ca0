#pragma once

#include "common/config/section.h"

#include <string>
#include <vector>

namespace heartbus::config {

/// A value that the scene gives as a table in time: linear between its entries, constant before the first and after the
/// last. Two entries at the same time make a jump, and a step that ends there still sees the first of them.
struct Table {
  std::vector<double> times{0}, values{0}; ///< [s], and whatever the owner says
  double at(double time) const;
  /// Keys `times` and `values`, or `table`, a CSV file of two columns with their units in the header ("time
  /// [ms],pressure [kPa]"), relative to the scene's folder. Once read, a file's numbers are those of `times` and
  /// `values`, so that the resolved scene needs no file.
  void describe(Section &section, const std::string &unit, Range range, const std::string &meaning);

 private:
  void read(const std::string &file_name, const std::string &unit);
};

} // namespace heartbus::config
