#include "mech_solver/parameters.h"

#include <algorithm>

namespace heartbus::mech {

namespace {

constexpr config::Range pressure = config::between(-1e6, 1e6, "pressures around a heart are a few 10 kPa at most");

void describe_law(Guccione &law, config::Section &s) {
  s.quantity("c", law.c, "Pa", config::positive, "stiffness of the exponential");
  s.number("a_ff", law.a_ff, config::non_negative, "exponent along the fibre");
  s.number("a_ss", law.a_ss, config::non_negative, "exponent along the sheet");
  s.number("a_nn", law.a_nn, config::non_negative, "exponent along the sheet normal");
  s.number("a_fs", law.a_fs, config::non_negative, "exponent of shear fibre-sheet");
  s.number("a_fn", law.a_fn, config::non_negative, "exponent of shear fibre-normal");
  s.number("a_sn", law.a_sn, config::non_negative, "exponent of shear sheet-normal");
  s.quantity("kappa", law.kappa, "Pa", config::positive, "bulk modulus");
}

void describe_law(NeoHookean &law, config::Section &s) {
  s.quantity("mu", law.mu, "Pa", config::positive, "shear modulus");
  s.quantity("kappa", law.kappa, "Pa", config::positive, "bulk modulus");
}

} // namespace

void ActiveParameters::describe(config::Section &s) {
  s.choice("model", model, {"rdq18_ann", "none"}, "force generation; none: a passive solid");
  s.quantity("tension_max", tension_max, "Pa", config::non_negative, "tension at full permissivity");
  s.quantity(
      "sarcomere_length", sarcomere_length, "um", config::between(1, 3),
      "at rest; the paper gives none; with 1.75 um its 500 kPa and cells paced every 0.8 s eject half of the volume");
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

double EndPressureParameters::at(double time) const {
  return initial + (final - initial) * (ramp > 0 ? std::clamp(time / ramp, 0.0, 1.0) : 1.0);
}

void EndPressureParameters::describe(config::Section &s) {
  s.text("label", label, "boundary part that is pushed; empty: none");
  s.quantity("initial", initial, "Pa", pressure, "at the start, inflation included");
  s.quantity("final", final, "Pa", pressure, "after the ramp");
  s.quantity("ramp", ramp, "s", config::non_negative, "time from the one to the other");
}

void SolverParameters::describe(config::Section &s) {
  s.number("residual_tolerance", residual_tolerance, {1e-14, 1e-2}, "of Newton, relative to the norm of nodal forces");
  s.number("update_tolerance", update_tolerance, {1e-14, 1}, "of what Newton's next update would be, relative to the smallest cell");
  s.number("linear_tolerance", linear_tolerance, {1e-14, 0.5}, "of the linear solver, relative to the residual");
  s.integer("max_iterations", max_iterations, {1, 1000}, "of Newton");
  s.choice("preconditioner", preconditioner, {"auto", "jacobi", "ilu", "amg"},
           "of the dynamic systems; auto: ilu, and amg from where a stiff wall makes it slow");
}

void Parameters::describe(config::Section &s) {
  s.choice("law", law, {"guccione", "neo_hookean"}, "constitutive law");
  describe_law(guccione, s.section("guccione", "transversely anisotropic exponential law of passive myocardium"));
  describe_law(neo_hookean, s.section("neo_hookean", "isotropic law"));
  s.texts("passive_regions", passive_regions,
          "material regions of the mesh that are neo-Hookean and do not contract, e.g. valve rings");
  s.quantity("density", density, "kg/m^3", config::positive, "in the reference configuration");
  active.describe(s.section("active", "force generation"));
  pericardium.describe(s.section("pericardium", "springs and dampers on the outside"));
  s.texts("fixed", fixed, "boundary parts without displacement");
  s.texts("rollers", rollers, "flat boundary parts without normal displacement");
  s.quantity("initial_pressure", initial_pressure, "Pa", pressure,
             "on the interface, to which the solid is inflated");
  s.integer("inflation_steps", inflation_steps, {1, 10000}, "load steps of the inflation");
  end_pressure.describe(s.section("end_pressure", "pressure from outside on one boundary part"));
  s.boolean(
      "active_increment", active_increment,
      "whether the first wall force of a step contains the change of active stress; without: the classical lagged "
      "Robin-Neumann datum");
  solver.describe(s.section("solver", "Newton and its linear systems"));
}

} // namespace heartbus::mech
