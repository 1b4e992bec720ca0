#include "common/bus/participant.h"
#include "common/fem/on_root.h"
#include "common/fem/runtime.h"
#include "common/geometry/mesh_tools.h"
#include "common/geometry/shapes.h"
#include "ep_solver/activation_solver.h"
#include "ep_solver/activation_times.h"
#include "ep_solver/conductivity.h"
#include "ep_solver/ep_solver.h"
#include "scene/scene.h"

using namespace heartbus;

int main(int argc, char **argv) {
  bus::Participant participant(argc, argv, "ep", "ep_solver");
  return participant.run([&] {
    const SceneParameters scene = read_scene(participant.scene_text(), "scene");
    const fem::Runtime runtime(participant.communicator());
    const MPI_Comm communicator = participant.communicator();
    const geometry::Mesh wall = fem::mesh_on_root(communicator, [&] { return geometry::make_solid(scene.geometry); });
    const double edge = dealii::Utilities::MPI::broadcast(communicator, geometry::longest_edge(wall));
    const fem::LagrangeSpace space(communicator, wall, scene.ep.refinements_of(edge), scene.ep.degree);
    const fem::Fibres fibres(space, scene.fibres);
    const auto serve = [&](auto &&solver) {
      solver.write_fields(participant.output_folder() + "/fields", scene.output);
      participant.serve(solver);
    };
    if (scene.ep.model == "monodomain") {
      ep::EPSolver solver(space, ep::conductivity(space, fibres, scene.ep.conductivity), scene.ep);
      solver.expect_steps_of(scene.time.step);
      return serve(solver);
    }
    const auto cell = ep::make_ionic_model(scene.ep.ionic_model);
    serve(ep::ActivationSolver(space, ep::activation_times(space, fibres, *cell, scene.ep), *cell, scene.ep));
  });
}
