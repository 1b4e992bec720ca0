#pragma once

#include "coupler/history.h"

#include <nlohmann/json.hpp>
#include <optional>

namespace heartbus::coupler {

/// A stretch of steps in which the state "phase" does not change. The volume at its beginning is the one before its
/// first step, so that consecutive phases share their ends.
struct Phase {
  std::string name;
  std::size_t first_row = 0, last_row = 0; ///< rows of the history at its beginning and end
  bool ended = false;                      ///< false: the run ended first
};
std::vector<Phase> phases(const History &history);

/// The first phase of this name (after the first phase `after`, unless empty) that has ended.
std::optional<Phase> first_phase(const std::vector<Phase> &all, const std::string &name, const std::string &after = "");

/// Isovolumetric loss index of the paper, |V_i - V_f| / max(V_i, V_f), of a phase.
double isovolumetric_loss(const History &history, const Phase &phase);

/// The solution indicators of the paper (section "Solution indicators"), with units in their names: EF_percent,
/// p_max_mmHg, ILI_C_percent, ILI_R_percent, EDV_mL, ESV_mL, activation_time_ms, mean_coupling_iterations, phases. What the run does not have is
/// left out.
nlohmann::ordered_json indicators(const History &history);

} // namespace heartbus::coupler
