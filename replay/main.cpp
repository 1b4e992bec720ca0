#include "common/bus/failure.h"
#include "common/bus/participant.h"
#include "replay/player.h"

#include <yaml-cpp/yaml.h>

namespace {

/// The recording named by the scene: participants.NAME.settings.file.
std::string file_of(const heartbus::bus::Participant &participant) {
  const YAML::Node file = YAML::Load(participant.scene_text())["participants"][participant.name()]["settings"]["file"];
  if (!file)
    throw heartbus::Failure(heartbus::ExitCode::scene,
                            "participants." + participant.name() +
                                ".settings.file is missing: which recording is to be played?");
  return file.as<std::string>();
}

} // namespace

int main(int argc, char **argv) {
  heartbus::bus::Participant participant(argc, argv, "replay", "replay");
  return participant.run([&] {
    heartbus::replay::Player player(participant.communicator(), file_of(participant));
    participant.serve(player);
  });
}
