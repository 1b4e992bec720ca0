#pragma once

#include "common/bus/packer.h"
#include "common/bus/solver.h"

#include <string>
#include <string_view>
#include <vector>

namespace heartbus::bus {

/// Something that a rank has done, on its steady clock [s].
struct Slice {
  int name = 0; ///< one of the trace's names
  double begin = 0, end = 0;
  int step = 0, iteration = 0;
};

/// What a rank has done when: slices that follow or contain each other. So many are kept; later ones are counted only.
class Trace {
 public:
  Trace();
  void add(std::string_view name, Stopwatch::Time begin, Stopwatch::Time end, const Step &step);

  static constexpr std::size_t most_slices = 200000;
  std::vector<std::string> names; ///< few
  std::vector<Slice> slices;
  std::size_t n_dropped = 0;
  double clock_origin; ///< what to add to the steady clock so that the ranks of a launch agree [s]
};

Packer &operator<<(Packer &packer, const Trace &trace);
Unpacker &operator>>(Unpacker &unpacker, Trace &trace);

} // namespace heartbus::bus
