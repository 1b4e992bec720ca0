#include "cavity_solver/cavity_solver.h"
#include "common/base/failure.h"
#include "common/bus/participant.h"
#include "common/units/units.h"
#include "scene/scene.h"

#include <stdexcept>

using namespace heartbus;

namespace {

/// The atrium and the aorta are those of the block `fluid`, so that blood of one pressure and blood in three dimensions
/// can take each other's place; the rest are settings of the participant.
cavity::CirculationParameters read_parameters(bus::Participant &participant, const fluid::Parameters &blood) {
  cavity::CirculationParameters circulation;
  circulation.atrial_pressure = blood.valves.mitral_pressure;
  circulation.aortic_resistance = blood.aortic_resistance;
  circulation.density = blood.density;
  circulation.arterial_pressure = blood.valves.aortic_pressure;
  const auto quantity = [&](const std::string &key, const std::string &unit, double &value) {
    try {
      if (const std::string *written = participant.setting(key))
        value = config::parse_quantity(*written, unit);
      if (key != "venous_pressure" && !(value >= 0 && value < 1e30))
        throw std::invalid_argument("must not be negative or infinite");
      if (key == "mitral_resistance" && value == 0)
        throw std::invalid_argument("must be above 0, e.g. 1e5 kg/(s m^4)");
    } catch (const std::invalid_argument &error) {
      throw Failure(ExitCode::scene,
                    "key 'participants." + participant.name() + ".settings." + key + "': " + error.what());
    }
  };
  quantity("mitral_resistance", "kg/(s m^4)", circulation.mitral_resistance);
  quantity("compliance", "m^3/Pa", circulation.arteries.compliance);
  quantity("peripheral_resistance", "kg/(s m^4)", circulation.arteries.peripheral_resistance);
  quantity("mitral_area", "m^2", circulation.mitral_area);
  quantity("aortic_area", "m^2", circulation.aortic_area);
  quantity("venous_pressure", "Pa", circulation.arteries.venous_pressure);
  if (circulation.arteries.compliance > 0 && !(circulation.arteries.peripheral_resistance > 0))
    throw Failure(ExitCode::scene,
                  "key 'participants." + participant.name() +
                      ".settings.peripheral_resistance': a compliance needs one, e.g. 1.2e8 kg/(s m^4)");
  return circulation;
}

} // namespace

int main(int argc, char **argv) {
  bus::Participant participant(argc, argv, "circulation", "cavity_solver");
  return participant.run([&] {
    const SceneParameters scene = read_scene(participant.scene_text(), "scene");
    cavity::CavitySolver solver(participant.communicator(), read_parameters(participant, scene.fluid),
                                scene.mech.initial_pressure);
    participant.serve(solver);
  });
}
