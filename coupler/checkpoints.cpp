#include "coupler/checkpoints.h"

#include "common/bus/failure.h"
#include "common/config/units.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

namespace heartbus::coupler {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

[[noreturn]] void refuse(const fs::path &set, const std::string &what) {
  throw Failure(ExitCode::file, "checkpoint " + set.string() + ": " + what);
}

/// 64-bit FNV-1a (Fowler, Noll, Vo): finds every damage but an intended one.
std::string checksum(const fs::path &file) {
  std::ifstream in(file, std::ios::binary);
  std::vector<char> block(1 << 20);
  std::uint64_t sum = 0xcbf29ce484222325u;
  do {
    in.read(block.data(), block.size());
    for (std::streamsize i = 0; i < in.gcount(); ++i)
      sum = (sum ^ static_cast<unsigned char>(block[i])) * 0x100000001b3u;
  } while (in);
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(sum));
  return text.data();
}

void check_file(const fs::path &set, const std::string &name, const ordered_json &expected) {
  std::error_code error;
  const auto size = fs::file_size(set / name, error);
  if (error)
    refuse(set, name + " is missing");
  if (const auto wanted = expected.at("bytes").get<std::uintmax_t>(); size != wanted)
    refuse(set, name + " has " + std::to_string(size) + " bytes instead of " + std::to_string(wanted));
  if (checksum(set / name) != expected.at("checksum").get<std::string>())
    refuse(set, name + " is damaged: its checksum is not the one in manifest.json");
}

CheckpointSet verified(const fs::path &set) {
  std::ifstream file(set / "manifest.json");
  if (!file)
    refuse(set, "there is no manifest.json, so it is not a complete checkpoint");
  try {
    const auto manifest = ordered_json::parse(file);
    for (const auto &[name, expected] : manifest.at("files").items())
      check_file(set, name, expected);
    return {fs::absolute(set).lexically_normal().string(),
            manifest.at("step").get<int>(),
            manifest.at("time").get<double>(),
            manifest.at("step_size").get<double>(),
            {}};
  } catch (const nlohmann::json::exception &error) {
    refuse(set, std::string("manifest.json is damaged: ") + error.what());
  }
}

/// Sets are named by their step; those being written have another ending.
std::vector<fs::path> sets_of(const fs::path &results) {
  std::vector<fs::path> sets;
  std::error_code error;
  for (const auto &entry : fs::directory_iterator(results / "checkpoints", error))
    if (const std::string name = entry.path().filename();
        !name.empty() && name.find_first_not_of("0123456789") == std::string::npos)
      sets.push_back(entry.path());
  std::sort(sets.begin(), sets.end(),
            [](const fs::path &a, const fs::path &b) { return std::stoi(a.filename()) < std::stoi(b.filename()); });
  return sets;
}

CheckpointSet latest_of(const fs::path &results) {
  std::vector<std::string> passed_over;
  auto sets = sets_of(results);
  for (auto set = sets.rbegin(); set != sets.rend(); ++set)
    try {
      CheckpointSet found = verified(*set);
      found.passed_over = passed_over;
      return found;
    } catch (const Failure &failure) {
      passed_over.push_back(failure.what());
    }
  std::string reasons;
  for (const auto &reason : passed_over)
    reasons += "; " + reason;
  throw Failure(ExitCode::file,
                "--restart: there is no complete checkpoint in " + (results / "checkpoints").string() + reasons);
}

CheckpointSet at_time(const std::string &choice, const fs::path &results) {
  double time = 0;
  try {
    time = config::parse_quantity(choice, "s");
  } catch (const std::invalid_argument &error) {
    throw Failure(ExitCode::file, "--restart " + choice + ": there is no such folder, and as a time: " + error.what() +
                                      "; write 'latest', a time such as '48 ms' or a folder");
  }
  std::string others;
  for (const auto &set : sets_of(results)) {
    std::ifstream file(set / "manifest.json");
    const auto manifest = ordered_json::parse(file, nullptr, false);
    if (!manifest.is_object() || !manifest.contains("time"))
      continue;
    if (std::abs(manifest["time"].get<double>() - time) < 1e-9)
      return verified(set);
    others += (others.empty() ? "" : ", ") + config::with_unit(1e3 * manifest["time"].get<double>(), "ms");
  }
  throw Failure(ExitCode::file, "--restart: there is no checkpoint of " + choice + " in " + results.string() +
                                    "; there are: " + (others.empty() ? "none" : others));
}

} // namespace

CheckpointSet find_checkpoint(const std::string &choice, const std::string &folder) {
  if (choice == "latest")
    return latest_of(folder);
  if (!fs::is_directory(choice))
    return at_time(choice, folder);
  return fs::is_directory(fs::path(choice) / "checkpoints") ? latest_of(choice) : verified(choice);
}

Checkpoints::Checkpoints(const std::string &results, const CheckpointParameters &parameters, const TimeControl &time)
    : results_(results), parameters_(parameters), time_(time) {}

std::string Checkpoints::set_folder(int step_number) const {
  std::array<char, 16> name{};
  std::snprintf(name.data(), name.size(), "%06d", step_number);
  return results_ + "/checkpoints/" + name.data();
}

bool Checkpoints::due(int step_number) const {
  const auto intervals = [&](int n) { return std::floor(time_.step(n).time / parameters_.every + 1e-6); };
  return time_.refreshes_at(step_number) &&
         (step_number == time_.last_refresh() ||
          (parameters_.every > 0 && intervals(step_number) > intervals(step_number - TimeControl::refresh_interval)));
}

std::string Checkpoints::open(const bus::Step &step) const {
  const std::string folder = set_folder(step.number) + ".part";
  std::error_code error;
  fs::remove_all(folder, error);
  if (!fs::create_directories(folder, error))
    throw Failure(ExitCode::file, folder + ": this folder cannot be made: " + error.message());
  return folder;
}

void Checkpoints::close(const bus::Step &step) const {
  const fs::path set = set_folder(step.number), aside = set.string() + ".part";
  std::error_code error;
  fs::copy_file(results_ + "/history.csv", aside / "history.csv", error);
  ordered_json files;
  for (const auto &entry : fs::directory_iterator(aside))
    files[entry.path().filename()] = {{"bytes", entry.file_size()}, {"checksum", checksum(entry.path())}};
  std::ofstream manifest(aside / "manifest.json");
  manifest << ordered_json{{"step", step.number}, {"time", step.time}, {"step_size", step.size}, {"files", files}}.dump(
                  2)
           << '\n';
  manifest.close();
  fs::remove_all(set, error);
  if (manifest)
    fs::rename(aside, set, error);
  if (!manifest || error || !files.contains("history.csv"))
    refuse(set, "cannot be written " + (error ? error.message() : "(disk full?)"));

  auto sets = sets_of(results_);
  for (std::size_t i = 0; i + parameters_.keep < sets.size(); ++i)
    fs::remove_all(sets[i], error);
}

void Checkpoints::remove_after(int step_number) const {
  std::error_code error;
  for (const auto &set : sets_of(results_))
    if (std::stoi(set.filename()) > step_number)
      fs::remove_all(set, error);
}

} // namespace heartbus::coupler
