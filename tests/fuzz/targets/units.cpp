#include "tests/fuzz/targets/target.h"

#include "common/units/units.h"

#include <cmath>

using namespace heartbus;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
  for (const char *unit : {"1", "m", "kg/(m^2 s)", "Pa", "uM", "m^2/s"})
    try {
      if (!std::isfinite(config::parse_quantity(text_of(data, size), unit)))
        __builtin_trap();
    } catch (const std::invalid_argument &) {
    }
  return 0;
}
