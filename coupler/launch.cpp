#include "coupler/launch.h"

#include "common/base/failure.h"
#include "common/geometry/shapes.h"
#include "common/units/nearest.h"

#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <sstream>
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

// Beside the coupler, on the PATH, or as given when it is a path. `key` is where the scene names it.
std::string find_program(const std::string &key, const std::string &program) {
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
  throw Failure(ExitCode::scene, "key '" + key + "': there is no executable '" + program + "'" +
                                     config::did_you_mean(program, programs_beside_the_coupler()) +
                                     " Looked beside the coupler and on the PATH");
}

/// A command as a shell would take it: words between blanks, quotes of both kinds.
std::vector<std::string> split(const std::string &key, const std::string &command) {
  std::vector<std::string> words;
  char quote = 0;
  bool in_word = false;
  for (const char c : command) {
    const bool begins_quote = !quote && (c == '\'' || c == '"');
    if (!quote && std::isspace(static_cast<unsigned char>(c))) {
      in_word = false;
      continue;
    }
    if (!in_word)
      words.emplace_back();
    in_word = true;
    if (begins_quote)
      quote = c;
    else if (c == quote)
      quote = 0;
    else
      words.back() += c;
  }
  if (quote || words.empty())
    throw Failure(ExitCode::scene, "key '" + key + "': '" + command + "' " +
                                       (quote ? "has a quote that is not closed" : "names no program"));
  return words;
}

/// A program of ours is told its name; others get it by a variable. The launcher forwards SIGUSR1, by which runs are
/// stopped, to every process, and by default it ends them: they inherit that it is ignored.
std::vector<std::string> words_of(const std::string &name, const ParticipantParameters &participant) {
  const std::string key = "participants." + name;
  if (participant.command.empty())
    return {find_program(key + ".program", participant.program), "--name", name};
  std::vector<std::string> words = split(key + ".command", participant.command);
  words.front() = find_program(key + ".command", words.front());
  const std::vector<std::string> before{"env", "--ignore-signal=USR1", "HEARTBUS_NAME=" + name};
  words.insert(words.begin(), before.begin(), before.end());
  return words;
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

/// Of all ranks [byte]: a process with its libraries and the transport, and what the unknowns of fluid and wall take
/// with all that belongs to them (docs/performance.md).
double estimated_memory(const std::vector<AppContext> &contexts, const SceneParameters &scene) {
  constexpr double of_a_rank = 180. * (1 << 20), of_an_unknown = 4.4 * (1 << 10);
  const bool has_fluid = scene.has("fluid") || scene.has("fsi");
  double unknowns = 3. * geometry::n_solid_points(scene.geometry);
  if (has_fluid)
    unknowns += 4. * geometry::n_fluid_points(scene.geometry);
  double memory = of_an_unknown * unknowns;
  for (const AppContext &context : contexts)
    memory += of_a_rank * context.ranks;
  return memory;
}

} // namespace

std::string program_name(const std::string &program) { return fs::path(program).filename(); }

std::vector<AppContext> launch(const Options &options, const SceneParameters &scene) {
  std::vector<std::string> words{own_program(), options.scene_file};
  for (const auto &setting : options.settings)
    words.insert(words.end(), {"--set", setting});
  if (options.ranks > 0)
    words.insert(words.end(), {"--ranks", std::to_string(options.ranks)});
  for (const auto &[field, file] : records_of(options))
    words.insert(words.end(), {"--record", field + "=" + file});
  if (!options.restart.empty())
    words.insert(words.end(), {"--restart", options.restart});
  words.insert(words.end(), {"--out", folder_of(options, scene)});

  std::vector<AppContext> contexts{{"coupler", 1, words}};
  for (const auto &[name, participant] : scene.participants)
    contexts.push_back({name, participant.ranks, words_of(name, participant)});
  return contexts;
}

std::string launch_line(const std::vector<AppContext> &contexts) {
  std::string line;
  for (const AppContext &context : contexts) {
    line += (line.empty() ? "-n " : " : -n ") + std::to_string(context.ranks);
    for (const std::string &word : context.words)
      line += " " + quoted(word);
  }
  return line;
}

void hand_over(int file, const std::vector<AppContext> &contexts, const Options &options,
               const SceneParameters &scene) {
  std::string text;
  const auto add = [&text](const std::string &key, const std::string &value) { text += key + '\0' + value + '\0'; };
  add("folder", folder_of(options, scene));
  add("deadline", std::to_string(scene.coupling.deadline));
  add("memory", std::to_string(estimated_memory(contexts, scene)));
  for (const AppContext &context : contexts) {
    add("participant", context.participant);
    add("ranks", std::to_string(context.ranks));
    for (const std::string &word : context.words)
      add("word", word);
  }
  for (std::size_t n = 0; n < text.size();) {
    const ssize_t written = write(file, text.data() + n, text.size() - n);
    if (written < 0)
      throw Failure(ExitCode::file, "--hand-over " + std::to_string(file) + ": cannot be written");
    n += static_cast<std::size_t>(written);
  }
}

} // namespace heartbus::coupler
