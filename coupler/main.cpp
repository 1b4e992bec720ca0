#include "common/bus/coordinator.h"
#include "coupler/options.h"
#include "coupler/simulation.h"

using namespace heartbus;

int main(int argc, char **argv) {
  coupler::Options options;
  if (const auto exit_code = coupler::parse(argc, argv, options))
    return *exit_code;
  if (options.action != coupler::Options::Action::run)
    return coupler::answer(options);
  bus::Coordinator coordinator;
  std::optional<coupler::Simulation> simulation;
  return coordinator.run([&] { simulation.emplace(coordinator, options).run(); });
}
