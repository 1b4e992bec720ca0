#include "coupler/checkpoints.h"

#include "common/base/failure.h"
#include "common/units/nearest.h"
#include "common/units/units.h"
#include "scene/model.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <tuple>

namespace heartbus::coupler {

namespace fs = std::filesystem;

namespace {

constexpr const char *being_written = ".part";

/// A folder among the checkpoints, named by its step; one that was completed, but not renamed any more, counts.
struct Named {
  fs::path folder;
  int step = 0;
};

std::vector<Named> sets_of(const fs::path &checkpoints, std::vector<std::string> *odd = nullptr) {
  std::vector<Named> sets;
  std::error_code error;
  for (const auto &entry : fs::directory_iterator(checkpoints, error)) {
    const std::string name = entry.path().filename();
    int step = 0;
    const auto [end, problem] = std::from_chars(name.data(), name.data() + name.size(), step);
    const std::string rest(end, name.data() + name.size() - end);
    std::error_code unknown;
    if (problem == std::errc() && step >= 0 && name[0] != '-' && (rest.empty() || rest == being_written) &&
        entry.is_directory(unknown)) {
      if (rest.empty() || fs::exists(entry.path() / "manifest.json", unknown))
        sets.push_back({entry.path(), step});
    } else if (odd)
      odd->push_back("checkpoint " + entry.path().string() + ": a set is a folder named by its step");
  }
  std::sort(sets.begin(), sets.end(), [](const Named &a, const Named &b) {
    return std::tie(a.step, a.folder) < std::tie(b.step, b.folder); // 000240 before 000240.part, which is newer
  });
  return sets;
}

/// Locked first, so that nobody removes it any more.
CheckpointSet verified(const fs::path &set) {
  auto lock = FileLock::take(set / "manifest.json", FileLock::Kind::shared);
  if (!lock)
    refuse_set(set, "another run is about to remove it");
  Manifest manifest = verify_set(set);
  return {fs::canonical(set).string(), std::move(manifest), {}, std::make_shared<FileLock>(std::move(*lock))};
}

/// Results beside these that are of the scene, too, with other settings, and have checkpoints.
std::string others_of(const std::string &scene, const fs::path &results) {
  std::vector<std::string> others;
  std::error_code error;
  const fs::path parent = results.has_parent_path() ? results.parent_path() : fs::path(".");
  for (const auto &entry : fs::directory_iterator(parent, error)) {
    const std::string name = entry.path().filename();
    if ((name == scene || name.compare(0, scene.size() + 1, scene + "-") == 0) &&
        !sets_of(entry.path() / "checkpoints").empty())
      others.push_back((results.parent_path() / name).string());
  }
  std::sort(others.begin(), others.end());
  return others.empty() ? "" : "; there are checkpoints in " + config::joined(others) + ": --restart FOLDER";
}

CheckpointSet latest_of(const fs::path &results, const std::string &scene) {
  std::vector<std::string> passed_over;
  auto sets = sets_of(results / "checkpoints", &passed_over);
  for (auto set = sets.rbegin(); set != sets.rend(); ++set)
    try {
      CheckpointSet found = verified(set->folder);
      found.passed_over = passed_over;
      return found;
    } catch (const Failure &failure) {
      passed_over.push_back(failure.what());
    }
  std::string reasons = passed_over.empty() && fs::exists(results / "history.csv")
                            ? "; the run there saved none (key 'output.checkpoint.every')"
                            : "";
  for (const auto &reason : passed_over)
    reasons += "; " + reason;
  throw Failure(ExitCode::file, "--restart: there is no complete checkpoint in " + (results / "checkpoints").string() +
                                    reasons + others_of(scene, results));
}

CheckpointSet at_time(const std::string &choice, const fs::path &results) {
  double time = 0;
  try {
    time = config::parse_quantity(choice, "s");
  } catch (const std::invalid_argument &error) {
    throw Failure(ExitCode::file, "--restart " + choice + ": there is no such folder, and as a time: " + error.what() +
                                      "; write 'latest', a time such as '48 ms' or a folder");
  }
  std::vector<std::string> passed_over;
  std::string others;
  for (const auto &set : sets_of(results / "checkpoints", &passed_over))
    try {
      const double saved = read_manifest(set.folder).time;
      if (std::abs(saved - time) < 1e-9) {
        CheckpointSet found = verified(set.folder);
        found.passed_over = passed_over;
        return found;
      }
      others += (others.empty() ? "" : ", ") + config::with_unit(1e3 * saved, "ms");
    } catch (const Failure &failure) {
      passed_over.push_back(failure.what());
    }
  std::string message = "--restart: there is no checkpoint of " + choice + " in " + results.string() +
                        "; there are: " + (others.empty() ? "none" : others);
  for (const auto &reason : passed_over)
    message += "; " + reason;
  throw Failure(ExitCode::file, message);
}

bool is_folder(const fs::path &path) {
  std::error_code error; // e.g. a name too long
  return fs::is_directory(path, error);
}

CheckpointSet found(const std::string &choice, const std::string &folder, const std::string &scene) {
  if (choice == "latest")
    return latest_of(folder, scene);
  if (!is_folder(choice))
    return at_time(choice, folder);
  return is_folder(fs::path(choice) / "checkpoints") ? latest_of(choice, scene) : verified(choice);
}

/// Unless somebody reads it.
void remove_set(const fs::path &set) {
  std::error_code error;
  if (const auto lock = FileLock::take(set / "manifest.json", FileLock::Kind::exclusive))
    fs::remove_all(set, error);
}

} // namespace

CheckpointSet find_checkpoint(const std::string &choice, const std::string &folder, const SceneParameters &scene) {
  CheckpointSet set = found(choice, folder, scene.name);
  if (const std::string differences = differences_of(set.manifest.model, model_of(scene)); !differences.empty())
    refuse_set(set.folder, "its state is of another model than this scene: " + differences);
  return set;
}

Checkpoints::Checkpoints(const std::string &results, const SceneParameters &scene, const CheckpointSet *from)
    : results_(results), parameters_(scene.output.checkpoint), model_(model_of(scene)), time_(scene.time) {
  std::error_code error;
  if (from && fs::equivalent(fs::path(from->folder).parent_path(), results + "/checkpoints", error))
    last_before_ = from->manifest.step;
}

bool Checkpoints::due(int step_number) const {
  const auto intervals = [&](int n) { return std::floor(time_.step(n).time / parameters_.every + 1e-6); };
  return time_.refreshes_at(step_number) &&
         (step_number == time_.last_refresh() ||
          (parameters_.every > 0 && intervals(step_number) > intervals(step_number - TimeControl::refresh_interval)));
}

namespace {

std::string name_of(int step_number) {
  std::array<char, 16> name{};
  std::snprintf(name.data(), name.size(), "%06d", step_number);
  return name.data();
}

/// To the first free name in a folder.
void move_into(const fs::path &folder, const fs::path &set) {
  std::error_code error;
  fs::create_directories(folder, error);
  for (int copy = 0; copy < 1000; ++copy) {
    const fs::path target = folder / (name_of(std::atoi(set.filename().c_str())) + std::string(copy, '_'));
    if (!fs::exists(fs::symlink_status(target, error))) {
      fs::rename(set, target, error);
      return;
    }
  }
}

} // namespace

std::string Checkpoints::open(const bus::Step &step) const {
  const fs::path folder = fs::path(results_) / "checkpoints" / (name_of(step.number) + being_written);
  std::error_code error;
  if (fs::exists(folder / "manifest.json", error)) // complete: an earlier run's, which ended before it could rename it
    move_into(results_ + "/checkpoints.old", folder);
  fs::remove_all(folder, error);
  if (!fs::create_directories(folder, error))
    throw Failure(ExitCode::file, folder.string() + ": this folder cannot be made (disk full?): " + error.message());
  return folder;
}

void Checkpoints::close(const bus::Step &step) {
  const fs::path set = fs::path(results_) / "checkpoints" / name_of(step.number), aside = set.string() + being_written;
  std::error_code error;
  if (!fs::copy_file(results_ + "/history.csv", aside / "history.csv", error))
    refuse_set(set, "cannot be written (disk full?): " + error.message());
  write_manifest(aside, {step.number, step.time, step.size, model_});
  own_numbers_.insert(step.number);
  set_others_aside();
  fs::rename(aside, set, error); // if somebody reads a set of that name, this one keeps its name: it is complete

  std::vector<Named> own;
  for (const auto &known : sets_of(set.parent_path()))
    if (is_own(known.step))
      own.push_back(known);
  for (std::size_t i = 0; i + parameters_.keep < own.size(); ++i)
    remove_set(own[i].folder);
}

/// Of this run or of those it went on from.
bool Checkpoints::is_own(int step_number) const {
  return step_number <= last_before_ || own_numbers_.count(step_number) > 0;
}

void Checkpoints::set_others_aside() const {
  std::vector<fs::path> others;
  for (const auto &set : sets_of(results_ + "/checkpoints"))
    if (const bool replaced = own_numbers_.count(set.step) && set.step == *own_numbers_.rbegin() &&
                              set.folder.extension() != being_written;
        replaced || !is_own(set.step))
      others.push_back(set.folder);
  if (others.empty())
    return;
  const fs::path old = results_ + "/checkpoints.old";
  for (const auto &set : sets_of(old))
    remove_set(set.folder);
  for (const auto &set : others)
    if (FileLock::take(set / "manifest.json", FileLock::Kind::exclusive))
      move_into(old, set);
}

} // namespace heartbus::coupler
