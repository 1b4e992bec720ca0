#include "common/bus/participant.h"
#include "common/fem/on_root.h"
#include "common/fem/runtime.h"
#include "common/geometry/shapes.h"
#include "common/log/log.h"
#include "fsi_solver/fsi_solver.h"
#include "scene/scene.h"

using namespace heartbus;

int main(int argc, char **argv) {
  bus::Participant participant(argc, argv, "fsi", "fsi_solver");
  return participant.run([&] {
    SceneParameters scene = read_scene(participant.scene_text(), "scene");
    scene.mech.active_increment = false; // belongs to the Robin datum
    const MPI_Comm communicator = participant.communicator();
    const fem::Runtime runtime(communicator);
    const auto on_root = [&](auto make) {
      return fem::mesh_on_root(communicator, [&] { return make(scene.geometry); });
    };
    const fem::LagrangeSpace wall(communicator, on_root(geometry::make_solid)),
        cavity(communicator, on_root(geometry::make_fluid));
    const fem::Fibres fibres(wall, scene.fibres);
    const auto log = log::open_log(participant.output_folder(), participant.name(),
                                   dealii::Utilities::MPI::this_mpi_process(communicator));
    mech::MechSolver mech(wall, fibres, scene.mech, log);
    fluid::FluidSolver fluid(cavity, scene.fluid, interface::BloodSettings{}, scene.time.step, log);
    const std::string fields = participant.output_folder() + "/fields";
    mech.write_fields(fields, scene.output);
    fluid.write_fields(fields, scene.output);
    fsi::FsiSolver solver(mech, fluid, scene.time.step);
    participant.serve(solver);
  });
}
