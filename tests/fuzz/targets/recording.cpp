#include "tests/fuzz/targets/target.h"

#include "common/io/recording.h"

#include <cmath>

using namespace heartbus;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
  const auto file = own_folder() / "recording.h5";
  write(file, text_of(data, size));
  try {
    const io::RecordingReader reader(file.string());
    const auto &field = reader.field();
    for (const double value : reader.times().empty() ? std::vector<double>{} : reader.values(reader.times().size() - 1))
      if (!std::isfinite(value))
        __builtin_trap();
    if (field.coordinates.size() % 3 != 0)
      __builtin_trap();
    reader.values_at(0.3e-3, 0);
  } catch (const Failure &) {
  }
  return 0;
}
