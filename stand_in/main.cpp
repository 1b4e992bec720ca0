#include "common/bus/participant.h"
#include "stand_in/stand_in.h"

using namespace heartbus;

int main(int argc, char **argv) {
  bus::Participant participant(argc, argv, "stand_in", "stand_in");
  return participant.run([&] {
    const SceneParameters scene = read_scene(participant.scene_text(), "scene");
    const auto number = [&](const std::string &key, const std::string &meaning) {
      return std::stod(participant.setting(key, meaning));
    };
    stand_in::StandIn solver(participant.name(), scene,
                             {participant.setting("mischief", "what is done wrong: none, nan, fail or silence?"),
                              static_cast<int>(number("step", "in which step is it done wrong?")),
                              number("delay", "how long does each solve take [s]?")});
    participant.serve(solver, bus::Participant::Sends::anything);
  });
}
