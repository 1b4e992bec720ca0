#include "mech_solver/settings/parameters.h"

#include "common/base/failure.h"
#include "common/units/nearest.h"
#include "mech_solver/active/force_models.h"

#include <algorithm>

namespace heartbus::mech {

namespace {

constexpr config::Range pressure_range =
    config::between(-1e6, 1e6, "pressures around a heart are a few 10 kPa at most");

} // namespace

void ActiveParameters::describe(config::Section &s) {
  std::vector<std::string> models = force_model_names();
  models.insert(models.end(), {"prescribed", "none"});
  s.choice("model", model, models, "force generation; prescribed: 'tension' everywhere; none: a passive solid");
  s.quantity("tension_max", tension_max, "Pa", config::non_negative, "tension at full permissivity");
  s.quantity(
      "sarcomere_length", sarcomere_length, "um", config::between(1, 3),
      "at rest; the paper gives none; with 1.75 um its 500 kPa and cells paced every 0.8 s eject half of the volume");
  tension.describe(s.section("tension", "of model prescribed"), "Pa", config::non_negative, "active tension");
  s.choice("measure", measure, {"nominal", "second_piola"}, "what a prescribed tension is as a stress");
}

void PericardiumParameters::describe(config::Section &s) {
  s.texts("labels", labels, "boundary parts it covers");
  s.quantity("K_perp", K_perp, "Pa/m", config::non_negative,
             "normal stiffness; the paper prints 10 kPa/m for the ellipsoid, less than the tangential stiffness and a "
             "twentieth of what it uses for the realistic ventricle, taken for a misprint");
  s.quantity("K_par", K_par, "Pa/m", config::non_negative, "tangential stiffness");
  s.quantity("C_perp", C_perp, "Pa s/m", config::non_negative, "normal damping");
  s.quantity("C_par", C_par, "Pa s/m", config::non_negative, "tangential damping");
}

void LoadParameters::describe(config::Section &s) {
  s.text("label", label, "boundary part that is loaded");
  pressure.describe(s.section("pressure", "from outside, follows the surface"), "Pa", pressure_range, "pressure");
  s.quantities("traction", traction, "Pa", 3, "dead load per area at rest");
  share.describe(s.section("share", "of the traction, in time"), "1", config::between(-1e6, 1e6), "factor");
  if (label.empty())
    s.fail("label", "which boundary part does this load act on?");
}

Law MaterialParameters::chosen_law() const {
#define HEARTBUS_CHOOSE(Law, name)                                                                                     \
  if (law == #name)                                                                                                    \
    return name;
  HEARTBUS_LAWS(HEARTBUS_CHOOSE)
#undef HEARTBUS_CHOOSE
  throw Failure(ExitCode::scene, "there is no law '" + law + "'; there are " + config::joined(law_names()));
}

void MaterialParameters::describe(config::Section &s) {
  s.choice("law", law, law_names(), "constitutive law");
#define HEARTBUS_DESCRIBE(Law, name) name.describe(s.section(#name, Law::meaning));
  HEARTBUS_LAWS(HEARTBUS_DESCRIBE)
#undef HEARTBUS_DESCRIBE
  s.quantity("density", density, "kg/m^3", config::positive, "in the reference configuration");
}

void RegionParameters::describe(config::Section &s) {
  MaterialParameters::describe(s);
  s.boolean("contracts", contracts, "whether it has active tension");
}

void SolverParameters::describe(config::Section &s) {
  s.number("residual_tolerance", residual_tolerance, {1e-14, 1e-2}, "of Newton, relative to the norm of nodal forces");
  s.number("update_tolerance", update_tolerance, {1e-14, 1},
           "of what Newton's next update would be, relative to the smallest cell");
  s.number("linear_tolerance", linear_tolerance, {1e-14, 0.5}, "of the linear solver, relative to the residual");
  s.integer("max_iterations", max_iterations, {1, 1000}, "of Newton");
  s.choice("preconditioner", preconditioner, {"auto", "jacobi", "ilu", "amg"},
           "of the dynamic systems; auto: ilu, and amg from where a stiff wall makes it slow");
}

void Parameters::describe(config::Section &s) {
  s.choice("model", model, {"elastic", "prescribed"}, "prescribed: no mechanics, the cavity follows 'cavity_volume'");
  cavity_volume.describe(s.section("cavity_volume", "of model prescribed"), "m^3", config::between(0, 1e-2),
                         "volume of the cavity");
  const auto &[times, volumes] = cavity_volume;
  if (model == "prescribed" && *std::min_element(volumes.begin(), volumes.end()) <= 0)
    s.fail("cavity_volume", "needs volumes above 0 in time, e.g. {table: volumes.csv}");
  if (std::adjacent_find(times.begin(), times.end()) != times.end())
    s.fail("cavity_volume", "has the same time twice: a volume cannot jump");
  MaterialParameters::describe(s);
  config::Section &by_name =
      s.section("regions", "regions of the mesh that differ, by name: the keys above and 'contracts'");
  for (auto &[name, region] : config::named(regions, by_name, RegionParameters{*this, true}))
    region.describe(by_name.section(name, ""));
  s.choice("volume", volume, {"penalty", "mean_dilatation"},
           "energy of volume at each point, or of each cell as a whole: for large kappa");
  s.boolean("inertia", inertia, "false: a state of equilibrium in each step");
  active.describe(s.section("active", "force generation"));
  pericardium.describe(s.section("pericardium", "springs and dampers on the outside"));
  s.texts("fixed", fixed, "boundary parts without displacement");
  s.texts("rollers", rollers, "flat boundary parts without normal displacement");
  s.quantity("initial_pressure", initial_pressure, "Pa", pressure_range,
             "on the interface, to which the solid is inflated; without blood it stays there");
  s.integer("inflation_steps", inflation_steps, {1, 10000}, "load steps of the inflation");
  config::Section &pushes = s.section("loads", "pressures and tractions on boundary parts, by names of one's own");
  for (auto &[name, load] : config::named(loads, pushes, LoadParameters{}))
    load.describe(pushes.section(name, ""));
  s.quantities("gravity", gravity, "m/s^2", 3, "acceleration by a dead body force");
  config::Section &points =
      s.section("probes", "points at rest whose displacements are columns of history.csv, by name");
  for (auto &[name, point] : config::named(probes, points, std::vector<double>(3)))
    points.quantities(name, point, "m", 3, "");
  s.boolean(
      "active_increment", active_increment,
      "whether the first wall force of a step contains the change of active stress; without: the classical lagged "
      "Robin-Neumann datum");
  solver.describe(s.section("solver", "Newton and its linear systems"));
}

} // namespace heartbus::mech
