#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace heartbus::bus {

/// Seconds by name.
using Seconds = std::map<std::string, double>;
void add(const Seconds &more, Seconds &sums);
double total(const Seconds &seconds);

/// Wall time by part of the work. Sections may nest; time counts for the innermost one only, so that the parts of one
/// stopwatch add up to the time within its sections.
class Stopwatch {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// `const bus::Stopwatch::Section section(stopwatch, "assembly");` counts for "assembly" until the end of the scope.
  class Section {
   public:
    Section(Stopwatch &stopwatch, std::string_view part)
        : stopwatch_(stopwatch), outer_(stopwatch.open_), begin_(stopwatch.change_to(stopwatch.number_of(part))) {}
    ~Section();
    Section(const Section &) = delete;
    Section &operator=(const Section &) = delete;

   private:
    Stopwatch &stopwatch_;
    const int outer_;
    const Time begin_;
  };

  /// What has been counted since the last call, open sections included.
  Seconds take();

  /// Called at the end of each section: its part, begin and end.
  std::function<void(const std::string &, Time, Time)> on_section;

 private:
  static constexpr int none = -1;
  struct Part {
    std::string name;
    double seconds = 0;
    bool counted = false; ///< since the last take
  };
  int number_of(std::string_view part);
  Time change_to(int part); ///< returns now
  std::vector<Part> parts_; ///< few: found by looking through, side by side in memory
  int open_ = none;         ///< the innermost section's part
  Time since_;
};

} // namespace heartbus::bus
