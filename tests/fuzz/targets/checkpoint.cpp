#include "tests/fuzz/targets/target.h"

#include "coupler/checkpoints.h"

using namespace heartbus;

namespace {

void look_for(const std::string &choice) {
  try {
    coupler::find_checkpoint(choice, own_folder(), SceneParameters());
  } catch (const Failure &) {
  }
}

} // namespace

/// A manifest as it is, and with the checksum that lets it pass to what reads it.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
  const auto set = own_folder() / "checkpoints/000040";
  std::filesystem::create_directories(set);
  const std::string text = text_of(data, size);
  for (const std::string &manifest : {text, coupler::sealed(text)}) {
    write(set / "manifest.json", manifest);
    look_for("latest");
    look_for("8 ms");
  }
  look_for(text);
  return 0;
}
