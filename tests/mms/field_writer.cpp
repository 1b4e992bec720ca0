#include "common/io/field_writer.h"
#include "common/base/failure.h"
#include "tests/mms/mpi_test_main.h"

#include <filesystem>
#include <fstream>
#include <hdf5.h>
#include <sstream>

using namespace heartbus;

namespace {

int rank_of_world() {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}

/// A row of two unit cubes with 12 nodes; the second rank, if any, owns the far half of both.
io::OutputMesh two_cubes() {
  int size = 0;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  const unsigned rank = rank_of_world(), first = rank == 0 ? 0 : 6, last = size == 1 || rank == 1 ? 12 : 6;
  io::OutputMesh mesh;
  mesh.first_owned_node = first;
  for (unsigned node = first; node < last; ++node)
    mesh.points.push_back({double(node / 4), double(node & 1), double(node >> 1 & 1)});
  for (unsigned cube = 0; cube < 2; ++cube) // node = 4 x + y + 2 z; cells are lexicographic, x fastest
    if (size == 1 || cube == rank)
      for (unsigned v = 0; v < 8; ++v)
        mesh.cells.push_back(4 * (cube + (v & 1)) + (v >> 1 & 1) + 2 * (v >> 2));
  return mesh;
}

std::vector<double> table(hid_t file, const std::string &name) {
  const hid_t set = H5Dopen2(file, name.c_str(), H5P_DEFAULT), space = H5Dget_space(set);
  std::vector<double> values(H5Sget_simple_extent_npoints(space));
  H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  H5Sclose(space);
  H5Dclose(set);
  return values;
}

const std::string folder = std::filesystem::temp_directory_path() / "heartbus_field_writer";

/// Writes v = (x, y, z) + time at the nodes and the cube's number in the cells.
void write(io::FieldWriter &writer, const io::OutputMesh &mesh, double time) {
  std::vector<double> v;
  for (const auto &x : mesh.points)
    for (double c : x)
      v.push_back(c + time);
  std::vector<double> cubes;
  for (std::size_t cell = 0; cell < mesh.cells.size(); cell += 8)
    cubes.push_back(mesh.cells[cell] / 4);
  writer.begin(time);
  writer.nodal("velocity", "m/s", 3, v.data());
  writer.cellwise("cube", "1", 1, cubes.data());
  writer.end();
}

} // namespace

TEST(FieldWriter, KeepsEveryValueAtItsNodeWhateverTheRanks) {
  const io::OutputMesh mesh = two_cubes();
  io::FieldWriter writer(MPI_COMM_WORLD, folder, "cubes", mesh);
  write(writer, mesh, 0);
  write(writer, mesh, 0.5);
  if (rank_of_world() != 0)
    return;
  // Read while the writer still holds the file, as after a crash: it must be consistent.
  std::filesystem::copy_file(folder + "/cubes.h5", folder + "/copy.h5",
                             std::filesystem::copy_options::overwrite_existing);
  const hid_t file = H5Fopen((folder + "/copy.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  const auto points = table(file, "mesh/points"), velocity = table(file, "000001/velocity");
  ASSERT_EQ(points.size(), 36u);
  for (unsigned i = 0; i < 36; ++i)
    EXPECT_EQ(velocity[i], points[i] + 0.5);
  EXPECT_EQ(table(file, "000001/cube"), (std::vector<double>{0, 1}));
  H5Fclose(file);
}

TEST(FieldWriter, WritesHexahedraInTheOrderOfVtk) {
  const io::OutputMesh mesh = two_cubes();
  {
    io::FieldWriter writer(MPI_COMM_WORLD, folder, "order", mesh);
    write(writer, mesh, 0);
  }
  if (rank_of_world() != 0)
    return;
  const hid_t file = H5Fopen((folder + "/order.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  EXPECT_EQ(table(file, "mesh/cells"), (std::vector<double>{0, 4, 5, 1, 2, 6, 7, 3, 4, 8, 9, 5, 6, 10, 11, 7}));
  H5Fclose(file);
}

TEST(FieldWriter, DescribesEveryInstantToParaView) {
  const io::OutputMesh mesh = two_cubes();
  io::FieldWriter writer(MPI_COMM_WORLD, folder, "series", mesh);
  write(writer, mesh, 0);
  write(writer, mesh, 0.25);
  if (rank_of_world() != 0)
    return;
  std::stringstream text;
  text << std::ifstream(folder + "/series.xdmf").rdbuf();
  EXPECT_NE(text.str().find("<Time Value=\"0.25\"/>"), std::string::npos);
  EXPECT_NE(text.str().find("/000001.h5:/velocity</DataItem>"), std::string::npos);
  EXPECT_NE(text.str().find("Dimensions=\"12 3\""), std::string::npos);
  EXPECT_NE(text.str().find("Name=\"velocity [m/s]\""), std::string::npos);
  EXPECT_NE(text.str().find("Name=\"cube\""), std::string::npos);
  EXPECT_NE(text.str().find("</Xdmf>"), std::string::npos);
}

TEST(FieldWriter, RefusesAFolderThatCannotExist) {
  if (rank_of_world() == 0) {
    const io::OutputMesh empty{0, {{0, 0, 0}}, 4, {0, 0, 0, 0}};
    EXPECT_THROW(io::FieldWriter(MPI_COMM_SELF, "/dev/null/nowhere", "x", empty), Failure);
  }
}

int main(int argc, char **argv) { return run_mpi_tests(argc, argv); }
