#include "common/bus/participant.h"
#include "common/fem/on_root.h"
#include "common/fem/runtime.h"
#include "common/geometry/shapes.h"
#include "common/log/log.h"
#include "mech_solver/mech_solver.h"
#include "mech_solver/prescribed_wall.h"
#include "scene/scene.h"

using namespace heartbus;

int main(int argc, char **argv) {
  bus::Participant participant(argc, argv, "mech", "mech_solver");
  return participant.run([&] {
    const SceneParameters scene = read_scene(participant.scene_text(), "scene");
    const fem::Runtime runtime(participant.communicator());
    const MPI_Comm communicator = participant.communicator();
    const fem::LagrangeSpace space(
        communicator, fem::mesh_on_root(communicator, [&] { return geometry::make_solid(scene.geometry); }));
    if (scene.mech.model == "prescribed") {
      mech::PrescribedWall wall(space, scene.mech.cavity_volume);
      participant.serve(wall);
      return;
    }
    const fem::Fibres fibres(space, scene.fibres);
    const auto log = log::open_log(participant.output_folder(), participant.name(),
                                   dealii::Utilities::MPI::this_mpi_process(participant.communicator()));
    mech::MechSolver solver(space, fibres, scene.mech, log);
    solver.write_fields(participant.output_folder() + "/fields", scene.output);
    solver.couple(interface::wall_settings(participant.coupling()));
    participant.serve(solver);
  });
}
