#pragma once

#include "coupler/beats.h"

#include <nlohmann/json.hpp>

namespace heartbus::coupler {

/// Isovolumetric loss index of the paper, |V_i - V_f| / max(V_i, V_f), between two rows.
double isovolumetric_loss(const std::vector<double> &volume, const Rows &rows);

/// The solution indicators of the paper (section "Solution indicators") for each beat of `period` [s], with units in
/// their names, as the list "beats"; at the top those of the last complete beat, or of the only one that there is:
///
///     EDV_mL                    largest volume from the beat's beginning to the beginning of ejection
///     ESV_mL                    smallest volume from there on; once ejection has ended
///     EF_percent                (EDV - ESV) / EDV of this very beat
///     V_max_mL, V_min_mL        extreme volumes, of a run without valves in place of the three above
///     ILI_C_percent             loss from the closing of the mitral valve (at first: from the start) to the opening of
///                               the aortic
///     ILI_R_percent             loss from the closing of the aortic valve to the opening of the mitral
///     p_max_mmHg                largest mean pressure
///     activation_time_ms        of the last point, since the beat's beginning; activated_percent when some are missing
///     J_min, wall_volume_min_percent, clamped_share_max_percent       of the wall, see mech_solver
///     mitral_closes_ms, aortic_opens_ms, aortic_closes_ms, mitral_opens_ms     since the beat's beginning
///     phases                    names, start and end [s] since the start of the run
///     change_percent            of EDV, ESV and p_max against the beat before
///
/// mean_coupling_iterations is of the whole run. What the run does not have is left out. A wall that is only loaded has
/// no beats: the one entry of the list is of the whole run and has no number "beat".
nlohmann::ordered_json indicators(const History &history, double period);

/// "change_percent" of the last complete beat; empty while there is none with one before it.
nlohmann::ordered_json last_changes(const History &history, double period);

/// Whether these are of EDV, ESV and p_max, and all below a share.
bool are_below(const nlohmann::ordered_json &changes, double share);

} // namespace heartbus::coupler
