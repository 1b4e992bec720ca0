#include "common/settings/participants.h"

namespace heartbus {

void ParticipantParameters::describe(config::Section &s) {
  s.text("program", program, "executable, beside the coupler or on the PATH");
  s.text("command", command, "in place of 'program': any program with its words, e.g. python3 my_ep.py --fast");
  if (!command.empty())
    program.clear();
  s.integer("ranks", ranks, {1, 100000}, "MPI processes");
  config::Section &block = s.section("settings", "free keys of this participant; quantities carry units");
  for (const auto &key : block.free_keys())
    settings[key];
  for (auto &[key, value] : settings)
    block.text(key, value, "");
}

} // namespace heartbus
