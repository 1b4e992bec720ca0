#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <string>

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
    Section(Stopwatch &stopwatch, const std::string &part)
        : stopwatch_(stopwatch), outer_(stopwatch.part_), begin_(stopwatch.change_to(part)) {}
    ~Section();
    Section(const Section &) = delete;
    Section &operator=(const Section &) = delete;

   private:
    Stopwatch &stopwatch_;
    const std::string outer_;
    const Time begin_;
  };

  /// What has been counted since the last call, open sections included.
  Seconds take();

  /// Called at the end of each section: its part, begin and end.
  std::function<void(const std::string &, Time, Time)> on_section;

 private:
  Time change_to(const std::string &part); ///< returns now
  std::string part_;                       ///< of the innermost open section; empty: none is open
  Time since_;
  Seconds seconds_;
};

} // namespace heartbus::bus
