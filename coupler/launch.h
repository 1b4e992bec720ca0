#pragma once

#include "coupler/options.h"

#include <string>
#include <vector>

namespace heartbus::coupler {

/// One program of the launch: how often and with which words.
struct AppContext {
  std::string participant;
  int ranks = 1;
  std::vector<std::string> words;
};

/// The coupler and all participants of a scene. Throws Failure(scene) when a program does not exist.
std::vector<AppContext> launch(const Options &options, const SceneParameters &scene);

/// The same as arguments of mpirun, quoted for a shell.
std::string launch_line(const std::vector<AppContext> &contexts);

/// The same for a launcher, which needs no quotes: keys and values, each ended by a zero byte, into an open file.
/// folder, deadline [s], memory (an estimate for all ranks [byte]), then for each program participant, ranks and its
/// words.
void hand_over(int file, const std::vector<AppContext> &contexts, const Options &options, const SceneParameters &scene);

/// The name by which a program introduces itself: the file name of its executable.
std::string program_name(const std::string &program);

} // namespace heartbus::coupler
