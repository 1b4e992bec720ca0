#include "common/geometry/mesh_file.h"
#include "common/base/failure.h"
#include "common/geometry/mesh_tools.h"
#include "common/geometry/shapes.h"
#include "common/io/hdf5_object.h"
#include "scene/model.h"
#include "scene/scene.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <random>
#include <unistd.h>

using namespace heartbus;
using namespace heartbus::geometry;
namespace fs = std::filesystem;

namespace {

/// Of tests/data/meshes/lv_solid.msh and lv_fluid.msh, by `tools/mesh import`.
fs::path ventricle() { return fs::path(std::getenv("HEARTBUS_SOURCE")) / "tests/data/meshes/lv.h5"; }

/// A copy of the ventricle that may be damaged.
class Copy {
 public:
  Copy() : path_(fs::temp_directory_path() / ("heartbus_mesh_" + std::to_string(getpid()) + ".h5")) {
    fs::copy_file(ventricle(), path_, fs::copy_options::overwrite_existing);
    fs::permissions(path_, fs::perms::owner_write, fs::perm_options::add);
  }
  ~Copy() { fs::remove(path_); }
  std::string name() const { return path_; }

  /// Replaces one value of a table, counted row by row.
  template <class T>
  void set(const std::string &table_name, std::size_t index, T value, hid_t type) const {
    const io::Hdf5Object file(H5Fopen(path_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose, "open");
    const io::Hdf5Object table(H5Dopen2(file, table_name.c_str(), H5P_DEFAULT), H5Dclose, "open the table");
    auto values = io::read_all<T>(file, table_name, type);
    values.at(index) = value;
    io::require(H5Dwrite(table, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), "write");
  }
  void set_index(const std::string &table, std::size_t index, unsigned value) const {
    set<unsigned>(table, index, value, H5T_NATIVE_UINT);
  }
  void set_number(const std::string &table, std::size_t index, double value) const {
    set<double>(table, index, value, H5T_NATIVE_DOUBLE);
  }
  void cut(double share) const { fs::resize_file(path_, std::size_t(share * fs::file_size(path_))); }

  std::string complaint(const std::string &part = "solid") const {
    try {
      MeshFile(name()).read(part);
    } catch (const Failure &failure) {
      return failure.what();
    }
    return "";
  }

 private:
  fs::path path_;
};

Parameters of_file(const std::string &name) {
  Parameters p;
  p.shape = "file";
  p.mesh = name;
  return p;
}

bool contains(const std::string &text, const std::string &part) { return text.find(part) != std::string::npos; }

} // namespace

TEST(MeshFile, HoldsWallAndBloodInMetres) {
  const MeshFile file(ventricle());
  const Mesh solid = file.read("solid"), fluid = file.read("fluid");
  EXPECT_EQ(solid.kind, Mesh::CellKind::tetrahedron);
  EXPECT_EQ(solid.n_cells(), 1838u);
  EXPECT_EQ(fluid.n_cells(), 958u);
  EXPECT_NEAR(volume(solid), 142.4e-6, 0.1e-6);
  EXPECT_NEAR(volume(fluid), 116.7e-6, 0.1e-6);
  EXPECT_NEAR(area(solid, "interface"), area(fluid, "interface"), 1e-12);
  EXPECT_EQ(solid.material_names, std::vector<std::string>{"myocardium"});
  EXPECT_TRUE(solid.fibres.empty());
}

TEST(MeshFile, NamesAreKnownWithoutTheMeshes) {
  const Parameters p = of_file(ventricle());
  EXPECT_EQ(solid_labels(p), make_solid(p).labels);
  EXPECT_EQ(fluid_labels(p), make_fluid(p).labels);
  EXPECT_EQ(solid_regions(p), make_solid(p).material_names);
  EXPECT_EQ(n_solid_points(p), make_solid(p).points.size());
  EXPECT_EQ(n_fluid_points(p), make_fluid(p).points.size());
  EXPECT_FALSE(brings_fibres(p));
}

TEST(MeshFile, TheStateBelongsToTheMeshWhateverItsFileIsCalled) {
  const Copy copy;
  const auto model = [](const std::string &name) {
    return model_of(read_scene("geometry: {shape: file, mesh: " + name + "}", "scene"));
  };
  EXPECT_EQ(differences_of(model(ventricle()), model(copy.name())), "");
  copy.set_number("solid/points", 0, 0.0152);
  EXPECT_TRUE(contains(differences_of(model(ventricle()), model(copy.name())), "geometry.mesh"));
}

TEST(MeshFile, DamageIsSaidWithItsPlace) {
  const auto after = [](auto damage, const std::string &part = "solid") {
    const Copy copy;
    damage(copy);
    return copy.complaint(part);
  };
  EXPECT_EQ(after([](const Copy &) {}), "");
  EXPECT_TRUE(contains(after([](const Copy &c) { c.set_number("solid/points", 7, NAN); }), "node 2 is at nan m"));
  EXPECT_TRUE(
      contains(after([](const Copy &c) { c.set_number("fluid/points", 7, 1e3); }, "fluid"), "node 2 is at 1000"));
  EXPECT_TRUE(
      contains(after([](const Copy &c) { c.set_index("solid/cells", 9, 530); }), "cell 2 has the node 530 of 530"));
  EXPECT_TRUE(
      contains(after([](const Copy &c) { c.set_index("solid/regions", 5, 1); }), "cell 5 has the region 1 of 1"));
  EXPECT_TRUE(contains(after([](const Copy &c) { c.set_index("solid/faces", 3, 9999); }), "face 1 has a node"));
  EXPECT_TRUE(contains(after([](const Copy &c) { c.set_index("solid/face_labels", 3, 8); }), "label without a name"));
  for (const double share : {0.1, 0.5, 0.99})
    EXPECT_TRUE(contains(after([&](const Copy &c) { c.cut(share); }), "is no HDF5 file")) << share;
}

TEST(MeshFile, FlippedBitsAreRefusedOrHarmless) {
  std::ifstream in(ventricle(), std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(in), {}};
  unsigned n_refused = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    std::mt19937 random(seed);
    std::string text = whole;
    for (unsigned k = 0; k < 8; ++k) // in the beginning lies what describes the rest
      text[random() % (seed % 2 ? text.size() : 6000)] ^= 1 << random() % 8;
    const Copy copy;
    std::ofstream(copy.name(), std::ios::binary) << text;
    n_refused += !copy.complaint().empty();
  }
  EXPECT_GT(n_refused, 50u);
}

TEST(MeshFile, ScenesSayWhereTheFileIs) {
  const auto complaint = [](const std::string &text) -> std::string {
    try {
      read_scene(text, "scene");
    } catch (const Failure &failure) {
      return failure.what();
    }
    return "";
  };
  const std::string mesh = ventricle();
  EXPECT_EQ(complaint("geometry: {shape: file, mesh: " + mesh + "}"), "");
  EXPECT_TRUE(contains(complaint("geometry: {shape: file}"), "key 'geometry.mesh': must be given"));
  EXPECT_TRUE(contains(complaint("geometry: {shape: file, mesh: lv.msh}"), "tools/mesh import"));
  EXPECT_TRUE(contains(complaint("geometry: {shape: file, mesh: /nowhere/lv.h5}"), "there is no file /nowhere/lv.h5"));
  EXPECT_TRUE(contains(complaint("geometry: {shape: file, mesh: " + mesh + "}\nmechanics: {fixed: [bse]}"),
                       "no boundary label 'bse'; did you mean 'base'?"));
  EXPECT_TRUE(contains(complaint("geometry: {shape: file, mesh: " + mesh + "}\nfibres: {rule: file}"),
                       "needs a mesh file with fibres"));
}

TEST(MeshFile, PathsAreRelativeToTheSceneThatSaysThem) {
  const fs::path folder = fs::temp_directory_path() / ("heartbus_scenes_" + std::to_string(getpid()));
  fs::create_directories(folder / "below");
  fs::copy_file(ventricle(), folder / "lv.h5");
  std::ofstream(folder / "base.yaml") << "geometry: {shape: file, mesh: lv.h5}";
  std::ofstream(folder / "below/over.yaml") << "base: ../base.yaml";
  EXPECT_EQ(load_scene(folder / "below/over.yaml", {}).geometry.mesh, (folder / "lv.h5").string());
  fs::remove_all(folder);
}
