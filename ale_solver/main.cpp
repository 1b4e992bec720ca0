#include "ale_solver/ale_solver.h"
#include "common/bus/participant.h"
#include "common/fem/on_root.h"
#include "common/fem/runtime.h"
#include "common/geometry/shapes.h"
#include "scene/scene.h"

using namespace heartbus;

int main(int argc, char **argv) {
  bus::Participant participant(argc, argv, "ale", "ale_solver");
  return participant.run([&] {
    const SceneParameters scene = read_scene(participant.scene_text(), "scene");
    const fem::Runtime runtime(participant.communicator());
    const MPI_Comm communicator = participant.communicator();
    const fem::LagrangeSpace space(
        communicator, fem::mesh_on_root(communicator, [&] { return geometry::make_fluid(scene.geometry); }));
    ale::ALESolver solver(space, scene.ale);
    participant.serve(solver);
  });
}
