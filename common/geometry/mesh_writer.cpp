#include "common/geometry/mesh_writer.h"

#include "common/geometry/mesh_file.h"
#include "common/io/hdf5_object.h"

namespace heartbus::geometry {
namespace {

void write_text(hid_t object, const std::string &name, const std::string &text) {
  const io::Hdf5Object type(H5Tcopy(H5T_C_S1), H5Tclose, "make a type of text"),
      space(H5Screate(H5S_SCALAR), H5Sclose, "make a data space");
  io::require(H5Tset_size(type, text.size()), "set the length of a text");
  const io::Hdf5Object attribute(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                                 "create " + name);
  io::require(H5Awrite(attribute, type, text.data()), "write " + name);
}

template <class T>
void write_table(hid_t group, const std::string &name, const std::vector<T> &values, hsize_t columns, hid_t type) {
  const hsize_t sizes[2] = {values.size() / columns, columns};
  const io::Hdf5Object space(H5Screate_simple(columns == 1 ? 1 : 2, sizes, nullptr), H5Sclose, "make a data space");
  const io::Hdf5Object table(H5Dcreate2(group, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                             H5Dclose, "create " + name);
  io::require(H5Dwrite(table, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), "write " + name);
}

std::string in_lines(const std::vector<std::string> &names) {
  std::string text;
  for (const auto &name : names)
    text += (text.empty() ? "" : "\n") + name;
  return text;
}

void write_part(hid_t group, const Mesh &mesh) {
  write_text(group, "cell_kind", mesh.kind == Mesh::CellKind::hexahedron ? "hexahedra" : "tetrahedra");
  write_text(group, "label_names", in_lines(mesh.labels));
  write_text(group, "region_names", in_lines(mesh.material_names));
  std::vector<double> points, fibres;
  for (const Point3 &x : mesh.points)
    points.insert(points.end(), x.begin(), x.end());
  for (const auto &directions : mesh.fibres)
    for (const Point3 &direction : directions)
      fibres.insert(fibres.end(), direction.begin(), direction.end());
  std::vector<unsigned> faces, labels;
  for (const Mesh::Face &face : mesh.faces) {
    faces.insert(faces.end(), face.vertices.begin(), face.vertices.begin() + mesh.vertices_per_face());
    labels.push_back(face.label);
  }
  write_table(group, "points", points, 3, H5T_NATIVE_DOUBLE);
  write_table(group, "cells", mesh.cells, mesh.vertices_per_cell(), H5T_NATIVE_UINT);
  write_table(group, "regions", mesh.materials, 1, H5T_NATIVE_UINT);
  write_table(group, "faces", faces, mesh.vertices_per_face(), H5T_NATIVE_UINT);
  write_table(group, "face_labels", labels, 1, H5T_NATIVE_UINT);
  if (!fibres.empty())
    write_table(group, "fibres", fibres, 6, H5T_NATIVE_DOUBLE);
}

} // namespace

void write_mesh_file(const std::string &name, const std::map<std::string, Mesh> &parts) {
  const std::string aside = name + ".part";
  {
    io::Hdf5Object file = io::create_file(aside, "create the mesh file " + aside);
    write_text(file, "format", mesh_file_format);
    for (const auto &[part, mesh] : parts)
      write_part(io::Hdf5Object(H5Gcreate2(file, part.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose,
                                "create the group " + part),
                 mesh);
    file.close("write the mesh file " + aside);
  }
  io::publish(aside, name);
}

} // namespace heartbus::geometry
