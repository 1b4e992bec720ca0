#include "coupler/launch.h"

#include "common/bus/failure.h"
#include "common/config/nearest.h"

#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <thread>
#include <unistd.h>

namespace heartbus::coupler {

namespace fs = std::filesystem;

namespace {

bool is_executable(const fs::path &file) { return fs::is_regular_file(file) && access(file.c_str(), X_OK) == 0; }

fs::path own_program() { return fs::read_symlink("/proc/self/exe"); }

std::vector<std::string> programs_beside_the_coupler() {
  std::vector<std::string> names;
  for (const auto &entry : fs::directory_iterator(own_program().parent_path()))
    if (is_executable(entry.path()))
      names.push_back(entry.path().filename());
  return names;
}

// Beside the coupler, on the PATH, or as given when it is a path.
std::string find_program(const std::string &participant, const std::string &program) {
  if (program.find('/') != std::string::npos) {
    if (is_executable(program))
      return program;
  } else {
    const char *path = std::getenv("PATH");
    std::stringstream folders(own_program().parent_path().string() + ":" + (path ? path : ""));
    for (std::string folder; std::getline(folders, folder, ':');)
      if (is_executable(fs::path(folder) / program))
        return fs::path(folder) / program;
  }
  throw Failure(ExitCode::scene, "key 'participants." + participant + ".program': there is no executable '" + program +
                                     "'" + config::did_you_mean(program, programs_beside_the_coupler()) +
                                     " Looked beside the coupler and on the PATH");
}

std::string quoted(const std::string &word) {
  if (word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./=:,") ==
      std::string::npos)
    return word;
  std::string text = "'";
  for (const char c : word)
    text += c == '\'' ? "'\\''" : std::string(1, c);
  return text + "'";
}

} // namespace

std::string program_name(const std::string &program) { return fs::path(program).filename(); }

std::string launch_line(const Options &options, const SceneParameters &scene) {
  std::string line = "-n 1 " + quoted(own_program()) + " " + quoted(options.scene_file);
  for (const auto &setting : options.settings)
    line += " --set " + quoted(setting);
  if (options.ranks > 0)
    line += " --ranks " + std::to_string(options.ranks);
  for (const auto &[field, file] : records_of(options))
    line += " --record " + quoted(field + "=" + file);
  if (!options.restart.empty())
    line += " --restart " + quoted(options.restart);
  line += " --out " + quoted(folder_of(options, scene));

  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  for (const auto &[name, participant] : scene.participants) {
    if (cores > 0 && participant.ranks > cores)
      throw Failure(ExitCode::scene, "key 'participants." + name + ".ranks': " + std::to_string(participant.ranks) +
                                         " ranks, but this machine has " + std::to_string(cores) + " cores");
    line += " : -n " + std::to_string(participant.ranks) + " " + quoted(find_program(name, participant.program)) +
            " --name " + quoted(name);
  }
  return line;
}

} // namespace heartbus::coupler
