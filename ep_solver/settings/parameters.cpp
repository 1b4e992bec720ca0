#include "ep_solver/settings/parameters.h"

#include "common/units/units.h"
#include "ep_solver/ionic/ionic_models.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace heartbus::ep {

void StimulusSite::describe(config::Section &s) {
  s.choice("shape", shape, {"ball", "cube"}, "a ball has a smooth edge, a cube a sharp one");
  s.quantities("centre", centre, "m", 3, "in the reference configuration");
  for (const double x : centre)
    if (std::abs(x) > 1)
      s.fail("centre", config::with_unit(x, "m") + " is out of range; hearts measure centimetres");
  s.quantity("radius", radius, "m", config::between(1e-5, 1, "hearts measure centimetres"),
             "of the cube: half an edge; at least two cells wide");
}

void StimulusParameters::describe(config::Section &s) {
  s.quantity("amplitude", amplitude, "V/s", config::between(-1e5, 1e5), "applied current over capacitance, not 0");
  s.quantity("duration", duration, "s", config::between(1e-6, 1e3), "of the stimulus, from the start of each period");
  s.quantity("period", period, "s", config::between(1e-3, 1e3, "hearts beat about once a second"),
             "from one stimulus to the next");
  if (amplitude == 0)
    s.fail("amplitude", "a stimulus of 0 V/s never fires; typical are 35.7 V/s");
  if (duration > period)
    s.fail("duration", "the stimulus lasts longer than its period");
  sites.resize(s.list("sites", sites.size(), "where the current is applied, at least one"));
  if (sites.empty())
    s.fail("sites", "there must be a site, or the stimulus never fires");
  for (std::size_t i = 0; i < sites.size(); ++i)
    sites[i].describe(s.item("sites", i));
}

void Conductivity::describe(config::Section &s) {
  s.quantity("fibre", fibre, "m^2/s", config::non_negative, "along the fibres");
  s.quantity("sheet", sheet, "m^2/s", config::non_negative, "along the sheets, across the fibres");
  s.quantity("normal", normal, "m^2/s", config::non_negative, "across the sheets");
}

void ConductivityParameters::describe(config::Section &s) {
  Conductivity::describe(s);
  config::Section &by_name = s.section("regions", "regions of the mesh that differ, by name: the keys above");
  for (auto &[name, region] : config::named(regions, by_name, Conductivity{*this}))
    region.describe(by_name.section(name, ""));
}

double ConductivityParameters::smallest() const {
  const auto least = [](const Conductivity &c) { return std::min({c.fibre, c.sheet, c.normal}); };
  double result = least(*this);
  for (const auto &[name, region] : regions)
    result = std::min(result, least(region));
  return result;
}

void EikonalParameters::describe(config::Section &s) {
  s.quantity_or("speed", speed, "m/s", config::between(0.01, 10, "fronts in hearts travel at about 0.7 m/s"), "auto",
                automatic_speed,
                "of a plane front along the fibres, in other directions as the root of the conductivity; auto: of the "
                "ionic model in tissue of this conductivity");
}

void PrescribedParameters::describe(config::Section &s) {
  s.text("activation", activation,
         "file with a time for each node, as a run leaves it in fields/activation.h5; empty: all nodes at once");
  if (!activation.empty()) {
    activation = s.file("activation", activation);
    std::error_code error;
    if (!std::filesystem::is_regular_file(activation, error))
      s.fail("activation", "there is no file " + activation);
  }
  config::Section &transient = s.section("calcium", "over the time since activation; default: of the ionic model");
  calcium.describe(transient, "uM", config::between(0, 100, "cells have 0.1 to 2 uM"), "calcium of the cytosol");
  if (has_calcium() && calcium.times.front() < 0)
    transient.fail("times", "must not begin before the activation, at 0 s");
}

void Parameters::describe(config::Section &s) {
  std::vector<std::string> models;
#define HEARTBUS_NAME(name, make) models.emplace_back(name);
  HEARTBUS_IONIC_MODELS(HEARTBUS_NAME)
#undef HEARTBUS_NAME
  s.choice("model", model, {"monodomain", "eikonal", "prescribed"},
           "how the wall is activated: by the monodomain equation; by a front of given speed; at prescribed times");
  s.integer("degree", degree, {1, 2}, "of the elements; 2 on tetrahedra only, with nodes at the middle of edges too");
  s.integer_or(
      "refinements", refinements, {0, 5}, "auto", automatic_refinements,
      "of the mesh of the mechanics, which stays nested in this one; auto: until nodes are 4 mm apart at most");
  s.choice("integrator", integrator, {"exponential_midpoint", "imex_euler"},
           "exponential_midpoint: of second order; imex_euler: the paper's, of first");
  s.integer_or("substeps", substeps, {1, 1000}, "auto", automatic_substeps,
               "steps of electrophysiology in one step of the coupling; auto: as an error estimate asks");
  s.number("substep_tolerance", substep_tolerance, {1e-4, 1},
           "of this estimate: difference from extrapolation, over 100 mV in potential and 1 mM in subspace calcium");
  s.choice("ionic_model", ionic_model, models, "model and type of the cells");
  s.choice("initial_state", initial_state, {"limit_cycle", "published"},
           "limit_cycle: end of a beat after 800 beats of 800 ms; published: with the model");
  conductivity.describe(s.section("conductivity", "over membrane area and capacitance"));
  stimulus.describe(s.section("stimulus", "applied current"));
  eikonal.describe(s.section("eikonal", "of the model eikonal"));
  prescribed.describe(s.section("prescribed", "of the model prescribed"));
  if (model == "eikonal" && conductivity.smallest() <= 0)
    s.fail("conductivity", "the model eikonal needs one above 0 m^2/s in all directions, or its front never crosses");
  s.number("tolerance", tolerance, {1e-14, 1e-2}, "of the linear solver, relative to the whole right-hand side");
  s.choice("preconditioner", preconditioner, {"jacobi", "ilu", "amg"}, "of GMRES; the paper's is amg");
}

int Parameters::refinements_of(double edge) const {
  if (!automatic_refinements)
    return refinements;
  int n = 0;
  for (edge /= degree; edge > longest_edge; edge /= 2)
    ++n;
  return n;
}

} // namespace heartbus::ep
