#include "tests/fuzz/targets/target.h"

#include "scene/scene.h"

using namespace heartbus;

/// A scene that is accepted reads back from its own print.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
  std::string text;
  try {
    text = print_scene(read_scene(text_of(data, size), "scene.yaml"));
  } catch (const Failure &) {
    return 0;
  }
  if (print_scene(read_scene(text, "printed")) != text)
    __builtin_trap();
  return 0;
}
