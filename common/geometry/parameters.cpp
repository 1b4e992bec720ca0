#include "common/geometry/parameters.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace heartbus::geometry {

using config::positive;

void Parameters::describe(config::Section &s) {
  s.choice("shape", shape, {"ideal_left_ventricle", "piston", "slab", "tube"}, "what the body looks like");
  s.choice("mesh", mesh, {"MXS", "M0", "M1", "M2", "M3"}, "mesh of the ideal left ventricle, from coarse to fine");
  ventricle.describe(s.section("ventricle", "shape ideal_left_ventricle"));
  piston.describe(s.section("piston", "shape piston"));
  slab.describe(s.section("slab", "shape slab"));
  tube.describe(s.section("tube", "shape tube"));
}

void VentricleParameters::describe(config::Section &s) {
  s.quantity("endocardium_across", endocardium_across, "m", positive, "short semi-axis of the endocardium");
  s.quantity("endocardium_along", endocardium_along, "m", positive, "long semi-axis of the endocardium");
  s.quantity("wall", wall, "m", positive, "thickness of the wall, added to both semi-axes");
  s.quantity("base_height", base_height, "m", config::any, "height of the base above the widest section");
  s.quantity("mitral_radius", mitral_radius, "m", positive, "radius of the mitral disc");
  s.quantity("aortic_radius", aortic_radius, "m", positive, "radius of the aortic disc");
  s.quantity("mitral_centre", mitral_centre, "m", config::any, "x of the centre of the mitral disc");
  s.quantity("aortic_centre", aortic_centre, "m", config::any, "x of the centre of the aortic disc");
  if (std::abs(base_height) >= endocardium_along)
    s.fail("base_height", "the base must cut the endocardium: its height must be less than endocardium_along");
  if (std::abs(aortic_centre - mitral_centre) < aortic_radius + mitral_radius)
    s.fail("mitral_centre", "the discs of the valves overlap: their centres must be apart by the sum of the radii");
}

void PistonParameters::describe(config::Section &s) {
  s.quantity("width", width, "m", positive, "side of the square cross-section");
  s.quantity("column", column, "m", positive, "length of the elastic column");
  s.quantity("fluid", fluid, "m", positive, "height of the box of fluid above it");
  s.integer("cells_across", cells_across, {1}, "cells along each side of the cross-section");
  s.integer("cells_column", cells_column, {1}, "cells along the column");
  s.integer("cells_fluid", cells_fluid, {1}, "cells along the height of the fluid");
}

void SlabParameters::describe(config::Section &s) {
  s.quantities("size", size, "m", 3, "lengths along x, y, z");
  s.quantity("cell", cell, "m", positive, "wanted edge length of a cell");
  if (*std::min_element(size.begin(), size.end()) <= 0)
    s.fail("size", "the lengths must be positive");
}

void TubeParameters::describe(config::Section &s) {
  s.quantity("length", length, "m", positive, "length of the tube, along z");
  s.quantity("radius", radius, "m", positive, "inner radius");
  s.quantity("wall", wall, "m", positive, "thickness of the wall");
  s.integer("cells_along", cells_along, {1}, "cells along the tube");
  s.integer("cells_across", cells_across, {1}, "cells along each side of the square core; four times as many around");
  s.integer("shells", shells, {1}, "layers of fluid cells between core and wall");
  s.integer("layers", layers, {1}, "layers of cells through the wall");
}

void FibreParameters::describe(config::Section &s) {
  s.choice("rule", rule, {"transmural", "constant"}, "how fibres are laid");
  s.quantity("angle_endo", angle_endo, "rad", config::any, "fibre angle on the endocardium, against the circumference");
  s.quantity("angle_epi", angle_epi, "rad", config::any, "fibre angle on the epicardium");
  s.quantity("dispersion_angle", dispersion_angle, "rad", config::between(0, 1.5),
             "where the wall's normal is closer than this to the long axis, at the apex, fibres disperse along the wall");
  s.quantities("direction", direction, "1", 3, "fibre direction of the constant rule");
  s.quantities("sheet", sheet, "1", 3, "sheet direction of the constant rule, made orthogonal to the fibre");
  const auto product = [](const std::vector<double> &a, const std::vector<double> &b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
  };
  const double ff = product(direction, direction), fs = product(direction, sheet), ss = product(sheet, sheet);
  if (ff * ss - fs * fs <= 1e-12 * ff * ss)
    s.fail("direction", "`direction` and `sheet` must be neither zero nor parallel");
}

} // namespace heartbus::geometry
