#include "common/geometry/mesh_file.h"

#include "common/base/failure.h"
#include "common/geometry/mesh_tools.h"
#include "common/io/checksum.h"
#include "common/io/hdf5_object.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

namespace heartbus::geometry {
namespace {

std::vector<std::string> lines(const std::string &text) {
  std::vector<std::string> all;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);)
    all.push_back(line);
  return all;
}

/// One group of the file.
class Part {
 public:
  Part(hid_t file, const std::string &name)
      : group_(H5Gopen2(file, name.c_str(), H5P_DEFAULT), H5Gclose, "find " + name) {}

  MeshSummary summary() const {
    MeshSummary s;
    const std::string kind = io::read_text(group_, "cell_kind");
    if (kind != "tetrahedra" && kind != "hexahedra")
      throw Failure(ExitCode::file, "cells are '" + kind + "', neither tetrahedra nor hexahedra");
    s.kind = kind == "hexahedra" ? Mesh::CellKind::hexahedron : Mesh::CellKind::tetrahedron;
    s.n_points = rows("points", 3);
    s.n_cells = rows("cells", kind == "hexahedra" ? 8 : 4);
    s.labels = names("label_names");
    s.regions = names("region_names");
    s.has_fibres = H5Lexists(group_, "fibres", H5P_DEFAULT) > 0;
    return s;
  }

  Mesh read() const {
    const MeshSummary s = summary();
    Mesh mesh;
    mesh.kind = s.kind;
    mesh.labels = s.labels;
    mesh.material_names = s.regions;
    const auto x = io::read_all<double>(group_, "points", H5T_NATIVE_DOUBLE);
    for (std::size_t i = 0; i < x.size(); i += 3)
      mesh.points.push_back({x[i], x[i + 1], x[i + 2]});
    mesh.cells = io::read_all<unsigned>(group_, "cells", H5T_NATIVE_UINT);
    mesh.materials = io::read_all<unsigned>(group_, "regions", H5T_NATIVE_UINT);
    read_faces(mesh);
    if (s.has_fibres)
      read_fibres(mesh);
    return mesh;
  }

 private:
  hsize_t rows(const std::string &table_name, hsize_t columns) const {
    const io::Hdf5Object table(H5Dopen2(group_, table_name.c_str(), H5P_DEFAULT), H5Dclose, "find " + table_name);
    const auto sizes = io::extent(table);
    if (sizes.size() != 2 || sizes[1] != columns || sizes[0] == 0 || sizes[0] > 0x7fffffff)
      throw Failure(ExitCode::file, table_name + " is no table with " + std::to_string(columns) + " columns");
    return sizes[0];
  }

  std::vector<std::string> names(const std::string &attribute) const {
    const auto all = lines(io::read_text(group_, attribute));
    if (all.empty() || std::set<std::string>(all.begin(), all.end()).size() != all.size())
      throw Failure(ExitCode::file, attribute + " is empty, or has a name twice");
    return all;
  }

  void read_faces(Mesh &mesh) const {
    const unsigned n = mesh.vertices_per_face();
    const hsize_t n_faces = rows("faces", n);
    const auto vertices = io::read_all<unsigned>(group_, "faces", H5T_NATIVE_UINT),
               labels = io::read_all<unsigned>(group_, "face_labels", H5T_NATIVE_UINT);
    if (labels.size() != n_faces)
      throw Failure(ExitCode::file, "face_labels are " + std::to_string(labels.size()) + ", faces " +
                                        std::to_string(n_faces) + "; they must be as many");
    for (std::size_t f = 0; f < n_faces; ++f) {
      Mesh::Face face{{}, labels[f]};
      std::copy_n(&vertices[f * n], n, face.vertices.begin());
      mesh.faces.push_back(face);
    }
  }

  void read_fibres(Mesh &mesh) const {
    if (rows("fibres", 6) != mesh.n_cells())
      throw Failure(ExitCode::file, "fibres are not as many as cells");
    const auto f = io::read_all<double>(group_, "fibres", H5T_NATIVE_DOUBLE);
    for (std::size_t i = 0; i < f.size(); i += 6)
      mesh.fibres.push_back({Point3{f[i], f[i + 1], f[i + 2]}, Point3{f[i + 3], f[i + 4], f[i + 5]}});
  }

  io::Hdf5Object group_;
};

[[noreturn]] void refuse_entry(const std::string &what, std::size_t index, const std::string &why) {
  throw Failure(ExitCode::file, what + " " + std::to_string(index) + " " + why);
}

void check_indices(const std::string &what, const std::vector<unsigned> &indices, unsigned per_entry, std::size_t n,
                   const std::string &of_what) {
  for (std::size_t i = 0; i < indices.size(); ++i)
    if (indices[i] >= n)
      refuse_entry(what, i / per_entry,
                   "has " + of_what + " " + std::to_string(indices[i]) + " of " + std::to_string(n));
}

void check_fibres(const Mesh &mesh) {
  constexpr double tolerance = 1e-6;
  const auto product = [](const Point3 &a, const Point3 &b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  for (std::size_t c = 0; c < mesh.fibres.size(); ++c) {
    const auto &[f, s] = mesh.fibres[c];
    const double error = std::max({std::abs(product(f, f) - 1), std::abs(product(s, s) - 1), std::abs(product(f, s))});
    if (!(error <= tolerance)) // NaN neither
      refuse_entry("cell", c, "has a fibre and a sheet that are not orthogonal unit vectors");
  }
}

void check_arrays(const Mesh &mesh) {
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    for (const double x : mesh.points[i])
      if (!(std::abs(x) <= 10)) // NaN neither
        refuse_entry("node", i, "is at " + std::to_string(x) + " m, which is no place in a heart");
  check_indices("cell", mesh.cells, mesh.vertices_per_cell(), mesh.points.size(), "the node");
  if (mesh.materials.size() != mesh.n_cells())
    throw Failure(ExitCode::file, "regions are not as many as cells");
  check_indices("cell", mesh.materials, 1, mesh.material_names.size(), "the region");
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    for (unsigned v = 0; v < mesh.vertices_per_face(); ++v)
      if (mesh.faces[f].vertices[v] >= mesh.points.size())
        refuse_entry("face", f, "has a node that does not exist");
  check_fibres(mesh);
}

/// Whatever goes wrong is said with the file.
template <class Action>
auto said_of(const std::string &name, const Action &action) {
  try {
    return action();
  } catch (const Failure &failure) {
    throw Failure(failure.code(), "mesh file " + name + ": " + failure.what());
  }
}

io::Hdf5Object open(const std::string &name) {
  return io::open_file(name, "open it: it does not exist, or is no HDF5 file (`tools/mesh import` makes one)");
}

} // namespace

MeshFile::MeshFile(const std::string &name) : name_(name) {
  said_of(name_, [&] {
    const io::Hdf5Object file = open(name_);
    if (const std::string found = io::read_text(file, "format"); found != mesh_file_format)
      throw Failure(ExitCode::file, "its format is '" + found + "', this version reads '" + mesh_file_format + "'");
    if (!has("solid") && !has("fluid"))
      throw Failure(ExitCode::file, "has neither a group `solid` nor `fluid`");
  });
}

bool MeshFile::has(const std::string &part) const { return H5Lexists(open(name_), part.c_str(), H5P_DEFAULT) > 0; }

MeshSummary MeshFile::summary(const std::string &part) const {
  return said_of(name_ + ", " + part, [&] {
    const io::Hdf5Object file = open(name_);
    return Part(file, part).summary();
  });
}

Mesh MeshFile::read(const std::string &part) const {
  return said_of(name_ + ", " + part, [&] {
    const io::Hdf5Object file = open(name_);
    Mesh mesh = Part(file, part).read();
    check_arrays(mesh);
    check(mesh);
    return mesh;
  });
}

std::string MeshFile::checksum() const { return io::checksum_of_file(name_); }

} // namespace heartbus::geometry
