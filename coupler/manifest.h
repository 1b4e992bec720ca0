#pragma once

#include <map>
#include <string>

namespace heartbus::coupler {

/// What a set of states says of itself: manifest.json in its folder, with a checksum of its own and of each file.
struct Manifest {
  int step = 0;
  double time = 0, step_size = 0;           ///< [s], of the run that saved it
  std::map<std::string, std::string> model; ///< what a run that goes on from it must agree with, see `model_of`
};

/// Completes a set: all its other files are there. Failure(file).
void write_manifest(const std::string &folder, const Manifest &manifest);

/// Failure(file) when there is none, or it is damaged: "checkpoint FOLDER: what is wrong".
Manifest read_manifest(const std::string &folder);
/// The same, and all files are there and undamaged.
Manifest verify_set(const std::string &folder);

/// A manifest, which is JSON, with its checksum; of text that is no JSON object the text itself.
std::string sealed(const std::string &manifest);

[[noreturn]] void refuse_set(const std::string &folder, const std::string &what);

} // namespace heartbus::coupler
