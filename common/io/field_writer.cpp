#include "common/io/field_writer.h"

#include "common/bus/failure.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <hdf5.h>
#include <numeric>
#include <sstream>

namespace heartbus::io {
namespace {

/// An HDF5 identifier, closed when it goes out of scope.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t), const std::string &what) : id_(id), close_(close) {
    if (id < 0)
      throw Failure(ExitCode::file, "HDF5 could not " + what);
  }
  ~Handle() { close_(id_); }
  Handle(const Handle &) = delete;
  Handle &operator=(const Handle &) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

void require(herr_t status, const std::string &what) {
  if (status < 0)
    throw Failure(ExitCode::file, "HDF5 could not " + what);
}

void write_table(hid_t group, const std::string &name, hid_t type, hsize_t rows, hsize_t columns, const void *data) {
  const hsize_t extent[2] = {rows, columns};
  const Handle space(H5Screate_simple(2, extent, nullptr), H5Sclose, "describe the table " + name);
  const Handle table(H5Dcreate2(group, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Dclose,
                     "create the table " + name);
  require(H5Dwrite(table, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), "write the table " + name + " (disk full?)");
}

void write_time(hid_t group, double time) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose, "describe the time");
  const Handle attribute(H5Acreate2(group, "time", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                         "create the time");
  require(H5Awrite(attribute, H5T_NATIVE_DOUBLE, &time), "write the time");
}

/// VTK and XDMF go around the quadrilaterals of a hexahedron; ours are lexicographic. Tetrahedra agree.
void to_vtk_order(std::vector<std::uint64_t> &cells, unsigned nodes_per_cell) {
  if (nodes_per_cell == 8)
    for (std::size_t cell = 0; cell < cells.size(); cell += 8) {
      std::swap(cells[cell + 2], cells[cell + 3]);
      std::swap(cells[cell + 6], cells[cell + 7]);
    }
}

std::string topology_name(unsigned nodes_per_cell) {
  return nodes_per_cell == 8 ? "Hexahedron" : nodes_per_cell == 4 ? "Tetrahedron" : "Tetrahedron_10";
}

std::string group_name(std::size_t instant) {
  char name[16];
  std::snprintf(name, sizeof(name), "%06zu", instant);
  return name;
}

template <class T>
MPI_Datatype mpi_type();
template <>
MPI_Datatype mpi_type<double>() {
  return MPI_DOUBLE;
}
template <>
MPI_Datatype mpi_type<std::uint64_t>() {
  return MPI_UINT64_T;
}

/// How many rows each rank owns and where they go in the whole table (on rank 0).
struct Layout {
  std::vector<int> counts, offsets;
  std::size_t total = 0;

  Layout(MPI_Comm communicator, std::size_t n_rows) {
    int size = 0;
    MPI_Comm_size(communicator, &size);
    counts.resize(size);
    offsets.resize(size);
    const int mine = n_rows;
    MPI_Gather(&mine, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, communicator);
    std::partial_sum(counts.begin(), counts.end() - 1, offsets.begin() + 1);
    total = std::accumulate(counts.begin(), counts.end(), std::size_t(0));
  }
};

template <class T>
std::vector<T> gather(MPI_Comm communicator, const Layout &layout, unsigned columns, const T *values,
                      std::size_t n_rows) {
  MPI_Datatype row;
  MPI_Type_contiguous(columns, mpi_type<T>(), &row);
  MPI_Type_commit(&row);
  std::vector<T> all(layout.total * columns);
  MPI_Gatherv(values, n_rows, row, all.data(), layout.counts.data(), layout.offsets.data(), row, 0, communicator);
  MPI_Type_free(&row);
  return all;
}

} // namespace

struct FieldWriter::Implementation {
  Implementation(MPI_Comm communicator, const OutputMesh &mesh)
      : communicator(communicator), n_owned_nodes(mesh.points.size()),
        n_owned_cells(mesh.cells.size() / mesh.nodes_per_cell), nodes_per_cell(mesh.nodes_per_cell),
        nodes(communicator, n_owned_nodes), cells(communicator, n_owned_cells) {
    int rank = 0;
    MPI_Comm_rank(communicator, &rank);
    root = rank == 0;
    // Ranks own ascending ranges of nodes, so where a rank's rows start is its first node.
    std::uint64_t first = mesh.first_owned_node;
    std::vector<std::uint64_t> firsts(nodes.offsets.size());
    MPI_Gather(&first, 1, MPI_UINT64_T, firsts.data(), 1, MPI_UINT64_T, 0, communicator);
    if (root)
      std::copy(firsts.begin(), firsts.end(), nodes.offsets.begin());
  }

  void create(const std::string &folder, const std::string &base_name, const OutputMesh &mesh) {
    name = base_name;
    const auto points = gather(communicator, nodes, 3, n_owned_nodes ? mesh.points[0].data() : nullptr, n_owned_nodes);
    auto vertices = gather(communicator, cells, nodes_per_cell, mesh.cells.data(), n_owned_cells);
    if (!root)
      return;
    std::error_code ignored; // opening the file reports what matters
    std::filesystem::create_directories(folder, ignored);
    path = folder + "/" + name;
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    file = std::make_unique<Handle>(H5Fcreate((path + ".h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT),
                                    H5Fclose, "create " + path + ".h5; does the folder exist, may it be written?");
    const Handle group(H5Gcreate2(*file, "mesh", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose, "create a group");
    to_vtk_order(vertices, nodes_per_cell);
    write_table(group, "points", H5T_NATIVE_DOUBLE, nodes.total, 3, points.data());
    write_table(group, "cells", H5T_NATIVE_UINT64, cells.total, nodes_per_cell, vertices.data());
  }

  void write(const std::string &field, const std::string &centre, const Layout &layout, unsigned components,
             const double *values, std::size_t n_rows) {
    const auto all = gather(communicator, layout, components, values, n_rows);
    if (!root)
      return;
    write_table(*instant, field, H5T_NATIVE_DOUBLE, layout.total, components, all.data());
    xdmf << "      <Attribute Name=\"" << field << "\" AttributeType=\"" << (components == 3 ? "Vector" : "Scalar")
         << "\" Center=\"" << centre << "\">\n"
         << item(group_name(n_instants) + "/" + field, "Float", layout.total, components) << "      </Attribute>\n";
  }

  std::string item(const std::string &table, const char *type, std::size_t rows, unsigned columns) const {
    std::ostringstream text;
    text << "        <DataItem Format=\"HDF\" NumberType=\"" << type << "\" Precision=\"8\" Dimensions=\"" << rows
         << ' ' << columns << "\">" << name << ".h5:/" << table << "</DataItem>\n";
    return text.str();
  }

  void begin(double time) {
    if (!root)
      return;
    instant = std::make_unique<Handle>(
        H5Gcreate2(*file, group_name(n_instants).c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose,
        "open an instant in " + path + ".h5");
    write_time(*instant, time);
    xdmf.precision(16);
    xdmf << "    <Grid Name=\"" << name << "\" GridType=\"Uniform\">\n      <Time Value=\"" << time << "\"/>\n"
         << "      <Topology TopologyType=\"" << topology_name(nodes_per_cell) << "\" NumberOfElements=\""
         << cells.total << "\">\n"
         << item("mesh/cells", "UInt", cells.total, nodes_per_cell) << "      </Topology>\n"
         << "      <Geometry GeometryType=\"XYZ\">\n"
         << item("mesh/points", "Float", nodes.total, 3) << "      </Geometry>\n";
  }

  void end() {
    if (!root)
      return;
    xdmf << "    </Grid>\n";
    instant.reset();
    ++n_instants;
    require(H5Fflush(*file, H5F_SCOPE_GLOBAL), "flush " + path + ".h5 (disk full?)");
    // A reader sees either the old or the new description, never half of one.
    const std::string temporary = path + ".xdmf.tmp";
    std::ofstream out(temporary);
    out << "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n <Domain>\n  <Grid Name=\"" << name
        << "\" GridType=\"Collection\" CollectionType=\"Temporal\">\n"
        << xdmf.str() << "  </Grid>\n </Domain>\n</Xdmf>\n";
    out.close();
    if (!out || std::rename(temporary.c_str(), (path + ".xdmf").c_str()) != 0)
      throw Failure(ExitCode::file, "could not write " + path + ".xdmf; is the disk full?");
  }

  MPI_Comm communicator;
  bool root = false;
  std::size_t n_owned_nodes, n_owned_cells;
  unsigned nodes_per_cell;
  Layout nodes, cells;
  std::string name, path;
  std::unique_ptr<Handle> file, instant; ///< on rank 0
  std::ostringstream xdmf;               ///< the grids written so far
  std::size_t n_instants = 0;
};

FieldWriter::FieldWriter(MPI_Comm communicator, const std::string &folder, const std::string &name,
                         const OutputMesh &mesh)
    : implementation_(std::make_unique<Implementation>(communicator, mesh)) {
  implementation_->create(folder, name, mesh);
}

FieldWriter::~FieldWriter() = default;

void FieldWriter::begin(double time) { implementation_->begin(time); }

void FieldWriter::nodal(const std::string &field, unsigned components, const double *values) {
  const auto &i = *implementation_;
  implementation_->write(field, "Node", i.nodes, components, values, i.n_owned_nodes);
}

void FieldWriter::cellwise(const std::string &field, unsigned components, const double *values) {
  const auto &i = *implementation_;
  implementation_->write(field, "Cell", i.cells, components, values, i.n_owned_cells);
}

void FieldWriter::end() { implementation_->end(); }

} // namespace heartbus::io
