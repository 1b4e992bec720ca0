#include "common/io/field_writer.h"

#include "common/io/hdf5_object.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <numeric>
#include <sstream>

namespace heartbus::io {

namespace fs = std::filesystem;

namespace {

void write_unit(hid_t table, const std::string &unit) {
  const Hdf5Object type(H5Tcopy(H5T_C_S1), H5Tclose, "describe a unit"),
      space(H5Screate(H5S_SCALAR), H5Sclose, "describe a unit");
  require(H5Tset_size(type, unit.size()), "describe a unit");
  const Hdf5Object attribute(H5Acreate2(table, "unit", type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                             "create a unit (disk full?)");
  require(H5Awrite(attribute, type, unit.data()), "write a unit (disk full?)");
}

void write_table(hid_t group, const std::string &name, hid_t type, hsize_t rows, hsize_t columns, const void *data,
                 const std::string &unit = "") {
  const hsize_t extent[2] = {rows, columns};
  const Hdf5Object space(H5Screate_simple(2, extent, nullptr), H5Sclose, "describe the table " + name);
  const Hdf5Object table(H5Dcreate2(group, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Dclose,
                         "create the table " + name + " (disk full?)");
  require(H5Dwrite(table, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), "write the table " + name + " (disk full?)");
  if (!unit.empty())
    write_unit(table, unit);
}

void write_time(hid_t group, double time) {
  const Hdf5Object space(H5Screate(H5S_SCALAR), H5Sclose, "describe the time");
  const Hdf5Object attribute(H5Acreate2(group, "time", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
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

std::string numbered(std::size_t instant) {
  char name[24];
  std::snprintf(name, sizeof(name), "%06zu", instant);
  return name;
}

constexpr const char *parts_mark = ".parts-";

/// The number of FOLDER/NAME.parts-NUMBER, or 0.
int parts_number(const fs::path &folder, const std::string &name) {
  const std::string file = folder.filename(), start = name + parts_mark;
  return file.compare(0, start.size(), start) == 0 ? std::atoi(file.c_str() + start.size()) : 0;
}

/// The folder for the parts of a new series: nobody else's, even when two begin at once.
std::string make_parts(const std::string &folder, const std::string &name) {
  std::error_code error;
  fs::create_directories(folder, error);
  int number = 0;
  for (const auto &entry : fs::directory_iterator(folder, error))
    number = std::max(number, parts_number(entry.path(), name));
  for (++number; !error; ++number)
    if (const std::string parts = name + parts_mark + std::to_string(number);
        fs::create_directory(folder + "/" + parts, error))
      return parts;
  throw Failure(ExitCode::file, folder + ": no folder can be made in it: " + error.message());
}

std::string content(const std::string &file_name) {
  std::ifstream file(file_name);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// An instant of a series: the file that holds it and its description.
struct Instant {
  std::string part, grid;
};

/// Those of a series as it is on disk, up to a time [s]; a foreign file has none.
std::vector<Instant> instants_until(double last, const std::string &xdmf_name, const std::string &name) {
  const std::string text = content(xdmf_name), begin = "    <Grid ", end = "    </Grid>\n", time = "<Time Value=\"",
                    part = ">" + name + parts_mark;
  std::vector<Instant> found;
  for (std::size_t from = 0; (from = text.find(begin, from)) != std::string::npos;) {
    const std::size_t to = text.find(end, from);
    const std::string grid = text.substr(from, to == std::string::npos ? 0 : to + end.size() - from);
    // the mesh comes first, then the fields
    const std::size_t when = grid.find(time), where = grid.rfind(part), stop = grid.find(":/", where);
    if (when == std::string::npos || where == std::string::npos || stop == std::string::npos)
      break;
    if (std::strtod(grid.c_str() + when + time.size(), nullptr) > last)
      break;
    found.push_back({grid.substr(where + 1, stop - where - 1), grid});
    from = to + end.size();
  }
  return found;
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

  void create(const std::string &in_folder, const std::string &base_name, const OutputMesh &mesh) {
    name = base_name;
    folder = in_folder + "/";
    const auto points = gather(communicator, nodes, 3, n_owned_nodes ? mesh.points[0].data() : nullptr, n_owned_nodes);
    auto vertices = gather(communicator, cells, nodes_per_cell, mesh.cells.data(), n_owned_cells);
    if (!root)
      return;
    parts = make_parts(in_folder, name);
    open("mesh.h5");
    to_vtk_order(vertices, nodes_per_cell);
    write_table(*file, "points", H5T_NATIVE_DOUBLE, nodes.total, 3, points.data(), "m");
    write_table(*file, "cells", H5T_NATIVE_UINT64, cells.total, nodes_per_cell, vertices.data());
    close();
  }

  void go_on_from(double time) {
    if (root)
      instants = instants_until(time * (1 + 1e-9), folder + name + ".xdmf", name);
  }

  /// A part of the series, aside.
  void open(const std::string &part_name) {
    part = parts + "/" + part_name;
    file =
        std::make_unique<Hdf5Object>(create_file(folder + part + ".tmp", "create " + folder + part + " (disk full?)"));
  }

  void close() {
    file->close("write " + folder + part + " (disk full?)");
    file.reset();
    publish(folder + part + ".tmp", folder + part);
  }

  void write(const std::string &field, const std::string &unit, const std::string &centre, const Layout &layout,
             unsigned components, const double *values, std::size_t n_rows) {
    const auto all = gather(communicator, layout, components, values, n_rows);
    if (!root)
      return;
    write_table(*file, field, H5T_NATIVE_DOUBLE, layout.total, components, all.data(), unit);
    const std::string shown = unit == "1" ? field : field + " [" + unit + "]";
    grid << "      <Attribute Name=\"" << shown << "\" AttributeType=\"" << (components == 3 ? "Vector" : "Scalar")
         << "\" Center=\"" << centre << "\">\n"
         << item(part + ":/" + field, "Float", layout.total, components) << "      </Attribute>\n";
  }

  static std::string item(const std::string &table, const char *type, std::size_t rows, unsigned columns) {
    std::ostringstream text;
    text << "        <DataItem Format=\"HDF\" NumberType=\"" << type << "\" Precision=\"8\" Dimensions=\"" << rows
         << ' ' << columns << "\">" << table << "</DataItem>\n";
    return text.str();
  }

  void begin(double time) {
    if (!root)
      return;
    open(numbered(instants.size()) + ".h5");
    write_time(*file, time);
    grid.str("");
    grid.precision(16);
    grid << "    <Grid Name=\"" << name << "\" GridType=\"Uniform\">\n      <Time Value=\"" << time << "\"/>\n"
         << "      <Topology TopologyType=\"" << topology_name(nodes_per_cell) << "\" NumberOfElements=\""
         << cells.total << "\">\n"
         << item(parts + "/mesh.h5:/cells", "UInt", cells.total, nodes_per_cell) << "      </Topology>\n"
         << "      <Geometry GeometryType=\"XYZ\">\n"
         << item(parts + "/mesh.h5:/points", "Float", nodes.total, 3) << "      </Geometry>\n";
  }

  void end() {
    if (!root)
      return;
    close();
    grid << "    </Grid>\n";
    instants.push_back({part, grid.str()});
    show();
  }

  /// A reader sees either the series before or the one after, never half of one.
  void show() const {
    const std::string series = folder + name + ".h5";
    Hdf5Object links = create_file(series + ".tmp", "create " + series + " (disk full?)");
    const auto link = [&](const std::string &to, const std::string &as) {
      require(H5Lcreate_external(to.c_str(), "/", links, as.c_str(), H5P_DEFAULT, H5P_DEFAULT), "write " + series);
    };
    link(parts + "/mesh.h5", "mesh");
    for (std::size_t i = 0; i < instants.size(); ++i)
      link(instants[i].part, numbered(i));
    links.close("write " + series + " (disk full?)");
    publish(series + ".tmp", series);
    if (instants.empty())
      return;
    const std::string description = folder + name + ".xdmf";
    std::ofstream out(description + ".tmp");
    out << "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n <Domain>\n  <Grid Name=\"" << name
        << "\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
    for (const Instant &instant : instants)
      out << instant.grid;
    out << "  </Grid>\n </Domain>\n</Xdmf>\n";
    out.close();
    if (!out)
      throw Failure(ExitCode::file, "cannot write " + description + " (disk full?)");
    publish(description + ".tmp", description);
  }

  MPI_Comm communicator;
  bool root = false;
  std::size_t n_owned_nodes, n_owned_cells;
  unsigned nodes_per_cell;
  Layout nodes, cells;
  std::string folder, name, parts, part; ///< parts and part relative to the folder
  std::unique_ptr<Hdf5Object> file;      ///< on rank 0: the part that is being written
  std::ostringstream grid;               ///< its description
  std::vector<Instant> instants;
};

FieldWriter::FieldWriter(MPI_Comm communicator, const std::string &folder, const std::string &name,
                         const OutputMesh &mesh)
    : implementation_(std::make_unique<Implementation>(communicator, mesh)) {
  implementation_->create(folder, name, mesh);
}

FieldWriter::~FieldWriter() = default;

void FieldWriter::go_on_from(double time) { implementation_->go_on_from(time); }

void FieldWriter::begin(double time) { implementation_->begin(time); }

void FieldWriter::nodal(const std::string &field, const std::string &unit, unsigned components, const double *values) {
  const auto &i = *implementation_;
  implementation_->write(field, unit, "Node", i.nodes, components, values, i.n_owned_nodes);
}

void FieldWriter::cellwise(const std::string &field, const std::string &unit, unsigned components,
                           const double *values) {
  const auto &i = *implementation_;
  implementation_->write(field, unit, "Cell", i.cells, components, values, i.n_owned_cells);
}

void FieldWriter::end() { implementation_->end(); }

void remove_old_parts(const std::string &folder) {
  std::error_code error;
  std::map<std::string, std::map<int, fs::path>> parts; // of each series
  std::string descriptions;
  for (const auto &entry : fs::directory_iterator(folder, error)) {
    const fs::path path = entry.path();
    const std::string file = path.filename(), name = file.substr(0, file.rfind(parts_mark));
    if (const int number = name == file ? 0 : parts_number(path, name))
      parts[name][number] = path;
    else if (path.extension() == ".xdmf")
      descriptions += content(path);
  }
  for (auto &[name, of_series] : parts)
    for (auto old = of_series.begin(); std::distance(old, of_series.end()) > 2; ++old)
      if (descriptions.find(">" + old->second.filename().string() + "/") == std::string::npos)
        fs::remove_all(old->second, error);
}

} // namespace heartbus::io
