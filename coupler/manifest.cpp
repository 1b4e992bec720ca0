#include "coupler/manifest.h"

#include "common/base/failure.h"
#include "common/io/checksum.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

namespace heartbus::coupler {

namespace fs = std::filesystem;
using io::Checksum;
using nlohmann::ordered_json;

namespace {

constexpr const char *file_name = "manifest.json";
constexpr int format = 2; ///< of the whole set; goes up when states of before cannot be read any more

/// Of what the manifest says, however it is laid out.
std::string checksum_of(ordered_json manifest) {
  manifest.erase("checksum");
  const std::string text = manifest.dump();
  Checksum sum;
  sum.add(text.data(), text.size());
  return sum.text();
}

void check_file(const std::string &set, const std::string &name, const ordered_json &expected) {
  if (name.find('/') != std::string::npos)
    refuse_set(set, std::string(file_name) + " names '" + name + "', which is not in it");
  std::error_code error;
  const auto size = fs::file_size(fs::path(set) / name, error);
  if (error)
    refuse_set(set, name + " is missing");
  if (const auto wanted = expected.at("bytes").get<std::uintmax_t>(); size != wanted)
    refuse_set(set, name + " has " + std::to_string(size) + " bytes instead of " + std::to_string(wanted));
  if (io::checksum_of_file(fs::path(set) / name) != expected.at("checksum").get<std::string>())
    refuse_set(set, name + " is damaged: its checksum is not the one in " + file_name);
}

ordered_json parsed(const std::string &set) {
  constexpr std::uintmax_t longest = 1 << 20;
  const fs::path name = fs::path(set) / file_name;
  std::error_code error;
  if (!fs::is_regular_file(name, error))
    refuse_set(set, std::string("there is no ") + file_name + ", so it is not a complete checkpoint");
  if (fs::file_size(name, error) > longest)
    refuse_set(set, std::string(file_name) + " is damaged: it is longer than any manifest");
  std::ifstream file(name);
  if (!file)
    refuse_set(set, std::string(file_name) + " cannot be read");
  ordered_json manifest = ordered_json::parse(file);
  if (!manifest.at("checksum").is_string() || manifest["checksum"] != checksum_of(manifest))
    refuse_set(set, std::string(file_name) + " is damaged: it does not have its own checksum");
  return manifest;
}

template <class Action>
auto heeding_damage(const std::string &set, const Action &action) {
  try {
    return action();
  } catch (const nlohmann::json::exception &error) {
    refuse_set(set, std::string(file_name) + " is damaged: " + error.what());
  } catch (const std::ios_base::failure &) {
    refuse_set(set, std::string(file_name) + " cannot be read");
  }
}

Manifest manifest_of(const std::string &set, const ordered_json &json) {
  if (const auto saved = json.value("format", format); saved != format)
    refuse_set(set, "is of format " + std::to_string(saved) + ", this version of the program reads format " +
                        std::to_string(format));
  const Manifest manifest{json.at("step").get<int>(), json.at("time").get<double>(), json.at("step_size").get<double>(),
                          json.at("model").get<std::map<std::string, std::string>>()};
  if (manifest.step < 0 || !std::isfinite(manifest.time) || !(manifest.step_size > 0))
    refuse_set(set, std::string(file_name) + " has an impossible step or time");
  return manifest;
}

} // namespace

void refuse_set(const std::string &folder, const std::string &what) {
  throw Failure(ExitCode::file, "checkpoint " + folder + ": " + what);
}

std::string sealed(const std::string &manifest) {
  auto json = ordered_json::parse(manifest, nullptr, false);
  if (!json.is_object())
    return manifest;
  json["checksum"] = checksum_of(json);
  return json.dump(2) + "\n";
}

void write_manifest(const std::string &folder, const Manifest &manifest) {
  ordered_json files;
  std::error_code error;
  for (const auto &entry : fs::directory_iterator(folder, error))
    files[entry.path().filename()] = {{"bytes", entry.file_size(error)},
                                      {"checksum", io::checksum_of_file(entry.path())}};
  const ordered_json json{{"format", format},        {"step", manifest.step},
                          {"time", manifest.time},   {"step_size", manifest.step_size},
                          {"model", manifest.model}, {"files", files}};
  std::ofstream file(fs::path(folder) / file_name);
  file << sealed(json.dump());
  file.close();
  if (!file || error)
    refuse_set(folder, "cannot be written (disk full?)");
}

Manifest read_manifest(const std::string &folder) {
  return heeding_damage(folder, [&] { return manifest_of(folder, parsed(folder)); });
}

Manifest verify_set(const std::string &folder) {
  return heeding_damage(folder, [&] {
    const ordered_json json = parsed(folder);
    Manifest manifest = manifest_of(folder, json);
    for (const auto &[name, expected] : json.at("files").items())
      check_file(folder, name, expected);
    return manifest;
  });
}

} // namespace heartbus::coupler
