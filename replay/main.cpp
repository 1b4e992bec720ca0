#include "common/bus/participant.h"
#include "replay/player.h"

int main(int argc, char **argv) {
  heartbus::bus::Participant participant(argc, argv, "replay", "replay");
  return participant.run([&] {
    const std::string &file = participant.setting("file", "which recording is to be played?");
    heartbus::replay::Player player(participant.communicator(), file);
    participant.serve(player);
  });
}
