#include "ep_solver/parameters.h"

#include "ep_solver/ionic/ionic_models.h"

namespace heartbus::ep {

void StimulusSite::describe(config::Section &s) {
  s.choice("shape", shape, {"ball", "cube"}, "a ball has a smooth edge, a cube a sharp one");
  s.quantities("centre", centre, "m", 3, "in the reference configuration");
  s.quantity("radius", radius, "m", config::positive, "of the cube: half an edge; at least two cells wide");
}

void StimulusParameters::describe(config::Section &s) {
  s.quantity("amplitude", amplitude, "V/s", config::any, "applied current over capacitance");
  s.quantity("duration", duration, "s", config::non_negative, "of the stimulus, from the start of each period");
  s.quantity("period", period, "s", config::positive, "from one stimulus to the next");
  sites.resize(s.list("sites", sites.size(), "where the current is applied"));
  for (std::size_t i = 0; i < sites.size(); ++i)
    sites[i].describe(s.item("sites", i));
}

void ConductivityParameters::describe(config::Section &s) {
  s.quantity("fibre", fibre, "m^2/s", config::non_negative, "along the fibres");
  s.quantity("sheet", sheet, "m^2/s", config::non_negative, "along the sheets, across the fibres");
  s.quantity("normal", normal, "m^2/s", config::non_negative, "across the sheets");
}

void Parameters::describe(config::Section &s) {
  std::vector<std::string> models;
#define HEARTBUS_NAME(name, make) models.emplace_back(name);
  HEARTBUS_IONIC_MODELS(HEARTBUS_NAME)
#undef HEARTBUS_NAME
  s.integer("refinements", refinements, {0, 5}, "of the mesh of the mechanics, which stays nested in this one");
  s.integer("substeps", substeps, {1, 1000}, "steps of electrophysiology in one step of the coupling");
  s.choice("ionic_model", ionic_model, models, "model and type of the cells");
  s.choice("initial_state", initial_state, {"limit_cycle", "published"},
           "limit_cycle: end of a beat after 800 beats of 800 ms; published: with the model");
  conductivity.describe(s.section("conductivity", "over membrane area and capacitance"));
  stimulus.describe(s.section("stimulus", "applied current"));
  s.number("tolerance", tolerance, {1e-14, 1e-2}, "of the linear solver, relative to the whole right-hand side");
  s.choice("preconditioner", preconditioner, {"jacobi", "ilu", "amg"}, "of GMRES; the paper's is amg");
}

} // namespace heartbus::ep
