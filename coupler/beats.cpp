#include "coupler/beats.h"

#include <cmath>

namespace heartbus::coupler {

namespace {

constexpr const char *ejection = "ejection", *filling = "filling";

bool is_closed(const Phase &phase) { return phase.name != ejection && phase.name != filling; }

/// Where the valves have been closed since, before the ejection all[e]: the first of the phases in between.
std::size_t first_closed_before(const std::vector<Phase> &all, std::size_t e) {
  while (e > 0 && is_closed(all[e - 1]))
    --e;
  return e;
}

} // namespace

std::vector<Beat> beats(const History &history, double period) {
  std::vector<Beat> all;
  const auto time = history.values("time");
  const double rounding = 1e-9 * period;
  for (std::size_t row = 0; row < time.size(); ++row) {
    const int number = std::max(1, static_cast<int>(std::ceil((time[row] - rounding) / period)));
    if (all.empty() || all.back().number != number)
      all.push_back({number, row == 0 ? 0 : row - 1, row, false});
    all.back().last_row = row;
  }
  for (Beat &beat : all)
    beat.complete = time.back() >= beat.number * period - rounding;
  return all;
}

std::vector<Phase> phases(const History &history) {
  std::vector<Phase> all;
  const int column = history.find("phase");
  if (column < 0)
    return all;
  const auto &states = history.columns[column].states;
  for (std::size_t row = 0; row < history.rows.size(); ++row) {
    const std::string &name = states.at(static_cast<std::size_t>(history.rows[row][column]));
    if (all.empty() || all.back().name != name) {
      if (!all.empty())
        all.back().ended = true;
      all.push_back({name, row == 0 ? 0 : row - 1, row, false});
    }
    all.back().last_row = row;
  }
  return all;
}

ValveTimes valve_times(const std::vector<Phase> &all, const Beat &beat) {
  ValveTimes times;
  std::optional<std::size_t> first, last; // ejection that begins in this beat
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].name == ejection && all[i].first_row >= beat.first_row && all[i].first_row < beat.last_row) {
      first = first.value_or(i);
      last = i;
    }
  if (!first)
    return times;

  times.aortic_opens = all[*first].first_row;
  if (const std::size_t closed = first_closed_before(all, *first); closed < *first) {
    const bool after_filling = closed > 0 && all[closed - 1].name == filling;
    if (after_filling)
      times.mitral_closes = all[closed].first_row;
    if (after_filling || closed == 0)
      times.contraction = Rows{all[closed].first_row, *times.aortic_opens};
  }
  const Phase &end = all[*last];
  if (!end.ended || end.last_row > beat.last_row)
    return times;
  times.aortic_closes = end.last_row;
  for (std::size_t i = *last + 1; i < all.size() && all[i].first_row < beat.last_row && !times.mitral_opens; ++i)
    if (all[i].name == filling)
      times.mitral_opens = all[i].first_row;
  if (times.mitral_opens)
    times.relaxation = Rows{*times.aortic_closes, *times.mitral_opens};
  return times;
}

} // namespace heartbus::coupler
