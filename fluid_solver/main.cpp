#include "common/bus/participant.h"
#include "common/fem/on_root.h"
#include "common/fem/runtime.h"
#include "common/geometry/shapes.h"
#include "common/log/log.h"
#include "fluid_solver/fluid_solver.h"
#include "scene/scene.h"

using namespace heartbus;

int main(int argc, char **argv) {
  bus::Participant participant(argc, argv, "fluid", "fluid_solver");
  return participant.run([&] {
    const SceneParameters scene = read_scene(participant.scene_text(), "scene");
    const fem::Runtime runtime(participant.communicator());
    const MPI_Comm communicator = participant.communicator();
    const fem::LagrangeSpace space(
        communicator, fem::mesh_on_root(communicator, [&] { return geometry::make_fluid(scene.geometry); }));
    int rank = 0;
    MPI_Comm_rank(participant.communicator(), &rank);
    fluid::FluidSolver solver(space, scene.fluid, interface::blood_settings(participant.coupling()), scene.time.step,
                              log::open_log(participant.output_folder(), participant.name(), rank));
    solver.write_fields(participant.output_folder() + "/fields", scene.output);
    participant.serve(solver);
  });
}
