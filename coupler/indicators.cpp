#include "coupler/indicators.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace heartbus::coupler {

namespace {
constexpr double pascal_per_mmHg = 133.322387415, cubic_metre_per_mL = 1e-6;
constexpr const char *contraction = "isovolumetric contraction", *ejection = "ejection",
                     *relaxation = "isovolumetric relaxation";
} // namespace

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

std::optional<Phase> first_phase(const std::vector<Phase> &all, const std::string &name, const std::string &after) {
  bool open = after.empty();
  for (const Phase &phase : all) {
    if (open && phase.name == name && phase.ended)
      return phase;
    open = open || phase.name == after;
  }
  return {};
}

double isovolumetric_loss(const History &history, const Phase &phase) {
  const auto volume = history.values("volume");
  const double initial = volume[phase.first_row], final = volume[phase.last_row];
  return std::abs(initial - final) / std::max(initial, final);
}

nlohmann::ordered_json indicators(const History &history) {
  nlohmann::ordered_json result;
  const auto all = phases(history);
  const auto volume = history.values("volume"), pressure = history.values("mean_pressure"),
             activation = history.values("activation_time"), time = history.values("time"),
             iterations = history.values("coupling_iterations");
  if (!volume.empty()) {
    const auto [ESV, EDV] = std::minmax_element(volume.begin(), volume.end());
    const bool has_ejected = std::any_of(all.begin(), all.end(), [](const Phase &p) { return p.name == ejection; });
    if (all.empty() || has_ejected)
      result["EF_percent"] = 100 * (*EDV - *ESV) / *EDV;
    result["EDV_mL"] = *EDV / cubic_metre_per_mL;
    result["ESV_mL"] = *ESV / cubic_metre_per_mL;
    if (const auto phase = first_phase(all, contraction))
      result["ILI_C_percent"] = 100 * isovolumetric_loss(history, *phase);
    if (const auto phase = first_phase(all, relaxation, ejection))
      result["ILI_R_percent"] = 100 * isovolumetric_loss(history, *phase);
  }
  if (!pressure.empty())
    result["p_max_mmHg"] = *std::max_element(pressure.begin(), pressure.end()) / pascal_per_mmHg;
  if (!activation.empty() && std::isfinite(activation.back()))
    result["activation_time_ms"] = 1e3 * activation.back();
  if (iterations.size() > 1)
    result["mean_coupling_iterations"] =
        std::accumulate(iterations.begin() + 1, iterations.end(), 0.) / (iterations.size() - 1);
  for (const Phase &phase : all)
    result["phases"].push_back({{"name", phase.name}, {"start", time[phase.first_row]}, {"end", time[phase.last_row]}});
  return result;
}

} // namespace heartbus::coupler
