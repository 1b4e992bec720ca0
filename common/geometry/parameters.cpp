#include "common/geometry/parameters.h"

#include "common/geometry/mesh_file.h"
#include "common/units/units.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <string>

namespace heartbus::geometry {

using config::between;
using config::positive;

namespace {

constexpr config::Range size_of_heart = between(1e-3, 0.5, "hearts measure centimetres"),
                        size_of_wall = between(1e-4, 0.1, "walls of hearts measure millimetres"),
                        size_of_part = between(1e-4, 0.2, "valves measure millimetres to centimetres"),
                        place_in_heart = between(-0.5, 0.5, "hearts measure centimetres"),
                        size_of_body = between(1e-5, 10, "tissue and vessels measure millimetres to centimetres");
constexpr config::Range number_of_cells = between(1, 10000);

void limit_cells(config::Section &s, const std::string &key, double n) {
  if (n > 1e8)
    s.fail(key, "makes " + std::to_string(std::llround(std::min(n, 1e18))) + " cells; 100000000 at most");
}

/// A valve lies in the base, which the endocardium cuts in a circle.
void check_valve(config::Section &s, const std::string &name, double centre, double radius, double base_radius) {
  if (std::abs(centre) + radius > base_radius)
    s.fail(name + "_radius", "the disc reaches " + config::with_unit(1e3 * (std::abs(centre) + radius), "mm") +
                                 " from the axis, beyond the base, whose radius is " +
                                 config::with_unit(1e3 * base_radius, "mm") + " inside the wall");
}

void describe_file(config::Section &s, Parameters &p) {
  std::string &mesh = p.mesh;
  if (mesh == Parameters().mesh)
    mesh.clear();
  s.text("mesh", mesh, "mesh file, made by `tools/mesh import`");
  if (mesh.empty())
    s.fail("mesh", "must be given with 'shape: file': the mesh file that `tools/mesh import` has made");
  mesh = s.file("mesh", mesh);
  const std::filesystem::path path(mesh);
  if (path.extension() != ".h5")
    s.fail("mesh", "'" + path.filename().string() + "' is no mesh file; `tools/mesh import SOLID FLUID --unit mm -o " +
                       path.stem().string() + ".h5` makes one of .msh, .vtu, .vtk, .xdmf, .pts and .elem");
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    s.fail("mesh", "there is no file " + path.string());
  const MeshFile file(mesh);
  const auto kind = file.summary(file.has("solid") ? "solid" : "fluid").kind;
  p.cells = kind == Mesh::CellKind::hexahedron ? "hexahedra" : "tetrahedra";
}

} // namespace

void Parameters::describe(config::Section &s) {
  s.choice("shape", shape, {"ideal_left_ventricle", "piston", "slab", "tube", "file"}, "what the body looks like");
  if (shape == "file") {
    describe_file(s, *this);
  } else {
    s.choice("mesh", mesh, {"MXS", "M0", "M1", "M2", "M3", "custom"},
             "mesh of the ideal left ventricle, from coarse to fine; custom: by the numbers in 'ventricle'");
    s.choice("cells", cells, {"hexahedra", "tetrahedra"},
             "tetrahedra: every hexahedron is split into five, on the same vertices");
  }
  ventricle.describe(s.section("ventricle", "shape ideal_left_ventricle"));
  piston.describe(s.section("piston", "shape piston"));
  slab.describe(s.section("slab", "shape slab"));
  tube.describe(s.section("tube", "shape tube"));
}

void VentricleParameters::describe(config::Section &s) {
  s.quantity("endocardium_across", endocardium_across, "m", size_of_heart, "short semi-axis of the endocardium");
  s.quantity("endocardium_along", endocardium_along, "m", size_of_heart, "long semi-axis of the endocardium");
  s.quantity("wall", wall, "m", size_of_wall, "thickness of the wall, added to both semi-axes");
  s.quantity("base_height", base_height, "m", place_in_heart, "height of the base above the widest section");
  s.quantity("mitral_radius", mitral_radius, "m", size_of_part, "radius of the mitral disc");
  s.quantity("aortic_radius", aortic_radius, "m", size_of_part, "radius of the aortic disc");
  s.quantity("mitral_centre", mitral_centre, "m", place_in_heart, "x of the centre of the mitral disc");
  s.quantity("aortic_centre", aortic_centre, "m", place_in_heart, "x of the centre of the aortic disc");
  s.integer("cells_along", cells_along, number_of_cells, "of mesh custom: cells of the core from apex to base");
  s.integer("cells_across", cells_across, number_of_cells,
            "cells along each side of the square core; four times as many around");
  s.integer("shells", shells, number_of_cells, "layers of fluid cells between core and wall");
  s.integer("layers", layers, number_of_cells, "layers of cells through the wall");
  limit_cells(s, "cells_along",
              double(cells_along + cells_across) * cells_across * (cells_across + 4. * (shells + layers)));
  if (std::abs(base_height) >= endocardium_along)
    s.fail("base_height", "the base must cut the endocardium: its height must be less than endocardium_along");
  if (std::abs(aortic_centre - mitral_centre) < aortic_radius + mitral_radius)
    s.fail("mitral_centre", "the discs of the valves overlap: their centres must be apart by the sum of the radii");
  const double share = base_height / endocardium_along, base_radius = endocardium_across * std::sqrt(1 - share * share);
  check_valve(s, "mitral", mitral_centre, mitral_radius, base_radius);
  check_valve(s, "aortic", aortic_centre, aortic_radius, base_radius);
}

void PistonParameters::describe(config::Section &s) {
  s.quantity("width", width, "m", size_of_body, "side of the square cross-section");
  s.quantity("column", column, "m", size_of_body, "length of the elastic column");
  s.quantity("fluid", fluid, "m", size_of_body, "height of the box of fluid above it");
  s.integer("cells_across", cells_across, number_of_cells, "cells along each side of the cross-section");
  s.integer("cells_column", cells_column, number_of_cells, "cells along the column");
  s.integer("cells_fluid", cells_fluid, number_of_cells, "cells along the height of the fluid");
  limit_cells(s, "cells_across", double(cells_across) * cells_across * (cells_column + cells_fluid));
}

void SlabParameters::describe(config::Section &s) {
  s.quantities("size", size, "m", 3, "lengths along x, y, z");
  s.quantity("cell", cell, "m", size_of_body, "wanted edge length of a cell");
  s.quantities("cells", cells, "1", 0, "numbers of cells along x, y, z in place of 'cell'");
  s.quantity("hollow", hollow, "m", config::non_negative,
             "radius of a cylinder along z that the end at low x clasps; 0 m: the end is flat");
  if (!cells.empty() && (cells.size() != 3 || *std::min_element(cells.begin(), cells.end()) < 1))
    s.fail("cells", "must be three numbers from 1 on");
  if (hollow > 0 && hollow < size[1] / 2)
    s.fail("hollow", "must be half of the width along y at least");
  double n_cells = 1;
  for (const double length : size) {
    if (!(length >= size_of_body.low && length <= size_of_body.high))
      s.fail("size", "the lengths must be positive, from 0.01 mm to 10 m");
    n_cells *= std::max(1., std::round(length / cell));
  }
  if (!cells.empty())
    n_cells = cells[0] * cells[1] * cells[2];
  limit_cells(s, "cell", n_cells);
}

void TubeParameters::describe(config::Section &s) {
  s.quantity("length", length, "m", size_of_body, "length of the tube, along z");
  s.quantity("radius", radius, "m", size_of_body, "inner radius");
  s.quantity("wall", wall, "m", size_of_body, "thickness of the wall");
  s.integer("cells_along", cells_along, number_of_cells, "cells along the tube");
  s.integer("cells_across", cells_across, number_of_cells,
            "cells along each side of the square core; four times as many around");
  s.integer("shells", shells, number_of_cells, "layers of fluid cells between core and wall");
  s.integer("layers", layers, number_of_cells, "layers of cells through the wall");
  limit_cells(s, "cells_along", double(cells_along) * cells_across * (cells_across + 4. * (shells + layers)));
}

namespace {

constexpr config::Range angle = between(-3.2, 3.2, "half a turn is 3.14 rad or 180 deg");

} // namespace

void OutflowFibreParameters::describe(config::Section &s) {
  s.texts("rings", rings, "boundary parts around its orifice; none: no such tract");
  s.quantity("angle_endo", angle_endo, "rad", angle, "fibre angle on the endocardium of the tract");
  s.quantity("angle_epi", angle_epi, "rad", angle, "fibre angle on the epicardium of the tract");
  s.quantity("length", length, "m", size_of_part, "over which fibres turn into those of the rest of the wall");
}

void FibreParameters::describe(config::Section &s) {
  s.choice(
      "rule", rule, {"transmural", "apicobasal", "ellipsoid", "constant", "file"},
      "how fibres are laid: through the wall, below a flat base with normal z or between apex and any orifices; "
      "ellipsoid: by the depth between the ventricle's ellipsoids; or all in one direction; file: as the mesh file has "
      "them");
  s.quantity("angle_endo", angle_endo, "rad", angle, "fibre angle on the endocardium, against the circumference");
  s.quantity("angle_epi", angle_epi, "rad", angle, "fibre angle on the epicardium");
  s.quantity(
      "dispersion_angle", dispersion_angle, "rad", config::between(0, 1.5),
      "where the wall's normal is closer than this to the long axis, at the apex, fibres disperse along the wall");
  s.texts("rings", rings, "of the rule apicobasal: boundary parts around the orifices, to which the long axis leads");
  outflow.describe(s.section("outflow", "fibres around an outflow tract"));
  s.quantities("direction", direction, "1", 3, "fibre direction of the constant rule");
  s.quantities("sheet", sheet, "1", 3, "sheet direction of the constant rule, made orthogonal to the fibre");
  if (rule == "apicobasal" && rings.empty())
    s.fail("rings", "the rule apicobasal needs one boundary part at least, such as 'base'");
  const auto product = [](const std::vector<double> &a, const std::vector<double> &b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
  };
  const double ff = product(direction, direction), fs = product(direction, sheet), ss = product(sheet, sheet);
  if (ff * ss - fs * fs <= 1e-12 * ff * ss)
    s.fail("direction", "`direction` and `sheet` must be neither zero nor parallel");
}

} // namespace heartbus::geometry
