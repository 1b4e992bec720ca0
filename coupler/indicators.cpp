#include "coupler/indicators.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace heartbus::coupler {

namespace {

using Json = nlohmann::ordered_json;
constexpr double pascal_per_mmHg = 133.322387415, cubic_metre_per_mL = 1e-6;

double smallest(const std::vector<double> &values, const Rows &rows) {
  return *std::min_element(values.begin() + rows.first, values.begin() + rows.last + 1);
}

double largest(const std::vector<double> &values, const Rows &rows) {
  return *std::max_element(values.begin() + rows.first, values.begin() + rows.last + 1);
}

void add_volumes(const std::vector<double> &volume, const Rows &rows, const ValveTimes &valves, Json &result) {
  const std::size_t begin = valves.aortic_opens.value_or(rows.last); // of ejection
  const double EDV = largest(volume, {rows.first, begin});
  result["EDV_mL"] = EDV / cubic_metre_per_mL;
  if (!valves.aortic_closes)
    return;
  const double ESV = smallest(volume, {begin, rows.last});
  result["ESV_mL"] = ESV / cubic_metre_per_mL;
  result["EF_percent"] = 100 * (EDV - ESV) / EDV;
}

/// Without valves nothing is ejected.
void add_extreme_volumes(const std::vector<double> &volume, const Rows &rows, Json &result) {
  result["V_max_mL"] = largest(volume, rows) / cubic_metre_per_mL;
  result["V_min_mL"] = smallest(volume, rows) / cubic_metre_per_mL;
}

void add_losses(const std::vector<double> &volume, const ValveTimes &valves, Json &result) {
  if (valves.contraction)
    result["ILI_C_percent"] = 100 * isovolumetric_loss(volume, *valves.contraction);
  if (valves.relaxation)
    result["ILI_R_percent"] = 100 * isovolumetric_loss(volume, *valves.relaxation);
}

/// Activation starts anew with each beat.
void add_activation(const History &history, const Rows &rows, Json &result) {
  if (const int column = history.find("activation_time"); column >= 0)
    if (const double time = history.rows[rows.last][column]; std::isfinite(time))
      result["activation_time_ms"] = 1e3 * time;
  if (const int column = history.find("activated_share"); column >= 0 && !result.contains("activation_time_ms"))
    result["activated_percent"] = 100 * history.rows[rows.last][column];
}

void add_wall(const History &history, const Rows &rows, Json &result) {
  if (const auto J = history.values("min_J"); !J.empty())
    result["J_min"] = smallest(J, rows);
  if (const auto volume = history.values("wall_volume"); !volume.empty())
    result["wall_volume_min_percent"] = 100 * smallest(volume, rows);
  if (const auto share = history.values("clamped_share"); !share.empty())
    result["clamped_share_max_percent"] = 100 * largest(share, rows);
}

void add_valve_times(const std::vector<double> &time, double begin, const ValveTimes &valves, Json &result) {
  const std::pair<const char *, std::optional<std::size_t>> all[] = {{"mitral_closes_ms", valves.mitral_closes},
                                                                     {"aortic_opens_ms", valves.aortic_opens},
                                                                     {"aortic_closes_ms", valves.aortic_closes},
                                                                     {"mitral_opens_ms", valves.mitral_opens}};
  for (const auto &[name, row] : all)
    if (row)
      result[name] = 1e3 * (time[*row] - begin);
}

void add_phases(const std::vector<double> &time, const std::vector<Phase> &all, const Rows &rows, Json &result) {
  for (const Phase &phase : all) {
    const std::size_t first = std::max(phase.first_row, rows.first), last = std::min(phase.last_row, rows.last);
    if (first < last || (first == last && rows.first == rows.last))
      result["phases"].push_back({{"name", phase.name}, {"start", time[first]}, {"end", time[last]}});
  }
}

/// A wall that is only loaded has no beats.
bool has_beats(const History &history) {
  return history.find("volume") >= 0 || history.find("phase") >= 0 || history.find("activated_share") >= 0;
}

Json of_run(const History &history) {
  const Rows rows{0, history.rows.size() - 1};
  const auto time = history.values("time");
  Json result{{"start", time.front()}, {"end", time.back()}, {"complete", true}};
  add_wall(history, rows, result);
  return result;
}

Json of_beat(const History &history, const std::vector<Phase> &all, const Beat &beat, double period) {
  const auto time = history.values("time"), volume = history.values("volume"),
             pressure = history.values("mean_pressure");
  const Rows rows{beat.first_row, beat.last_row};
  const ValveTimes valves = valve_times(all, beat);
  const double begin = (beat.number - 1) * period;
  Json result{{"beat", beat.number}, {"start", begin}, {"end", time[rows.last]}, {"complete", beat.complete}};
  if (!volume.empty() && all.empty()) {
    add_extreme_volumes(volume, rows, result);
  } else if (!volume.empty()) {
    add_volumes(volume, rows, valves, result);
    add_losses(volume, valves, result);
  }
  if (!pressure.empty())
    result["p_max_mmHg"] = largest(pressure, rows) / pascal_per_mmHg;
  add_activation(history, rows, result);
  add_wall(history, rows, result);
  add_valve_times(time, begin, valves, result);
  add_phases(time, all, rows, result);
  return result;
}

void add_changes(const Json &before, Json &beat) {
  for (const auto &[name, key] : {std::pair{"EDV", "EDV_mL"}, {"ESV", "ESV_mL"}, {"p_max", "p_max_mmHg"}})
    if (before.contains(key) && beat.contains(key))
      beat["change_percent"][name] = 100 * std::abs(beat[key].get<double>() / before[key].get<double>() - 1);
}

Json all_beats(const History &history, double period) {
  if (!has_beats(history))
    return Json::array({of_run(history)});
  Json result = Json::array();
  const auto all = phases(history);
  for (const Beat &beat : beats(history, period)) {
    result.push_back(of_beat(history, all, beat, period));
    if (beat.complete && result.size() > 1)
      add_changes(result[result.size() - 2], result.back());
  }
  return result;
}

/// The last complete beat, or the last of all.
const Json &best_of(const Json &beats) {
  for (auto beat = beats.rbegin(); beat != beats.rend(); ++beat)
    if (beat->at("complete"))
      return *beat;
  return beats.back();
}

} // namespace

double isovolumetric_loss(const std::vector<double> &volume, const Rows &rows) {
  const double initial = volume[rows.first], final = volume[rows.last];
  return std::abs(initial - final) / std::max(initial, final);
}

Json indicators(const History &history, double period) {
  Json result;
  if (history.rows.empty())
    return result;
  const Json beats = all_beats(history, period);
  for (const auto &[key, value] : best_of(beats).items())
    if (key != "start" && key != "end" && key != "complete")
      result[key] = value;
  if (const auto iterations = history.values("coupling_iterations"); iterations.size() > 1)
    result["mean_coupling_iterations"] =
        std::accumulate(iterations.begin() + 1, iterations.end(), 0.) / (iterations.size() - 1);
  result["beats"] = beats;
  return result;
}

Json last_changes(const History &history, double period) {
  const Json beats = all_beats(history, period);
  return beats.empty() ? Json() : best_of(beats).value("change_percent", Json());
}

bool are_below(const Json &changes, double share) {
  return changes.size() == 3 &&
         std::all_of(changes.begin(), changes.end(), [&](const Json &percent) { return percent < 100 * share; });
}

} // namespace heartbus::coupler
