#pragma once

#include "common/fibres/fibres.h"
#include "ep_solver/ionic/ionic_model.h"
#include "ep_solver/settings/parameters.h"

namespace heartbus::ep {

/// When each owned node is activated, since the beginning of a beat [s]; NaN: never. By the eikonal equation
/// (eikonal.h), from a file, or all at the beginning. Collective. Failure(scene), Failure(file), Failure(map).
std::vector<double> activation_times(const fem::LagrangeSpace &space, const fem::Fibres &fibres,
                                     const IonicModel &model, const Parameters &parameters);

/// From `mesh/points` and `000000/activation_time` of an HDF5 file, as a run leaves them in fields/activation.h5: of
/// the same mesh, or of one that holds all its nodes. Only the first rank reads. Failure(file), Failure(map).
std::vector<double> activation_times_of_file(const fem::LagrangeSpace &space, const std::string &file_name);

} // namespace heartbus::ep
