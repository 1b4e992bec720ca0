#pragma once

#include "coupler/history.h"

#include <optional>

namespace heartbus::coupler {

/// The rows of the history that belong to a beat: those of the times from its beginning to its end, both included, so
/// that consecutive beats share a row.
struct Beat {
  int number = 1;
  std::size_t first_row = 0, last_row = 0;
  bool complete = false; ///< false: the run ended first
};
/// All beats of the run, each one `period` [s] long; of a run without steps, one of one row.
std::vector<Beat> beats(const History &history, double period);

/// A stretch of steps in which the state "phase" does not change. The volume at its beginning is the one before its
/// first step, so that consecutive phases share their ends.
struct Phase {
  std::string name;
  std::size_t first_row = 0, last_row = 0; ///< rows of the history at its beginning and end
  bool ended = false;                      ///< false: the run ended first
};
std::vector<Phase> phases(const History &history);

/// A stretch of rows.
struct Rows {
  std::size_t first = 0, last = 0;
};

/// When the valves switch in a beat, as rows of the history (the last one before the switch shows). A valve that
/// switches more than once counts as open from its first opening to its last closing. What is not seen is left out.
struct ValveTimes {
  std::optional<std::size_t> mitral_closes; ///< the last time before ejection, even before the beat begins
  std::optional<std::size_t> aortic_opens, aortic_closes, mitral_opens;
  std::optional<Rows> contraction; ///< both closed before ejection, after filling or the start of the run
  std::optional<Rows> relaxation;  ///< both closed between ejection and filling
};
ValveTimes valve_times(const std::vector<Phase> &all, const Beat &beat);

} // namespace heartbus::coupler
