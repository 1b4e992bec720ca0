#pragma once

#include "coupler/options.h"

namespace heartbus::coupler {

/// The arguments of mpirun that start the coupler and all participants of a scene, quoted for a shell. Throws
/// Failure(scene) when a program does not exist or asks for more ranks than this machine has cores.
std::string launch_line(const Options &options, const SceneParameters &scene);

/// The name by which a program introduces itself: the file name of its executable.
std::string program_name(const std::string &program);

} // namespace heartbus::coupler
