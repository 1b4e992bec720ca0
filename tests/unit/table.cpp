#include "common/config/table.h"

#include "common/base/failure.h"
#include "common/config/printer.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

using namespace heartbus;
using namespace heartbus::config;

namespace {

/// Read from a scene in this folder, which may hold a file table.csv.
struct Folder {
  std::string path;
  Folder() {
    char name[] = "/tmp/heartbus_table_XXXXXX";
    path = mkdtemp(name);
  }
  ~Folder() { std::filesystem::remove_all(path); }
  void write(const std::string &text) const { std::ofstream(path + "/table.csv") << text; }
  Table read(const std::string &scene) const {
    Table table;
    config::read(parse_yaml(scene, path + "/scene.yaml"),
                 [&](Section &s) { table.describe(s, "Pa", between(-1e6, 1e6), "pressure"); });
    return table;
  }
  std::string complaint(const std::string &scene) const {
    try {
      read(scene);
      return "";
    } catch (const Failure &failure) {
      return failure.what();
    }
  }
};

} // namespace

TEST(Table, IsLinearBetweenItsEntriesAndConstantBeyond) {
  const Table table{{1, 2, 4}, {10, 20, 0}};
  const double times[] = {0, 1, 1.5, 2, 3, 4, 9}, values[] = {10, 10, 15, 20, 10, 0, 0};
  for (int k = 0; k < 7; ++k)
    EXPECT_NEAR(table.at(times[k]), values[k], 1e-12) << times[k];
}

TEST(Table, AStepThatEndsAtAJumpSeesWhatWasBefore) {
  const Table table{{0, 3e-3, 3e-3}, {5, 5, 0}};
  EXPECT_EQ(table.at(30 * 1e-4), 5);
  EXPECT_EQ(table.at(3e-3 * (1 + 1e-12)), 5);
  EXPECT_EQ(table.at(3.1e-3), 0);
}

TEST(Table, ComesFromAFileBesideTheScene) {
  const Folder folder;
  folder.write("time [ms],pressure [kPa]\n0,1\n500,2.5\r\n\n1000,0\n");
  const Table table = folder.read("table: table.csv");
  EXPECT_EQ(table.times, (std::vector<double>{0, 0.5, 1}));
  EXPECT_EQ(table.values, (std::vector<double>{1000, 2500, 0}));
  Table copy = table; // what is printed needs no file
  const std::string printed = print([&](Section &s) { copy.describe(s, "Pa", between(-1e6, 1e6), "pressure"); });
  EXPECT_EQ(Folder().read(printed).values, table.values);
}

TEST(Table, WhatIsWrongIsSaidWithItsPlace) {
  const Folder folder;
  EXPECT_NE(folder.complaint("table: table.csv").find("table.csv: this table cannot be read"), std::string::npos);
  const std::pair<const char *, const char *> files[] = {
      {"time [ms],pressure [kPa],more\n", "table.csv:1: a table has two columns"},
      {"time [ms],pressure [kPa]\n0,1\n1\n", "table.csv:3: this line has not two columns"},
      {"time [ms],pressure\n0,1\n", "table.csv:2: '1' has no unit"},
      {"time [ms],pressure [mm]\n0,1\n", "table.csv:2: expected a pressure-like unit"},
      {"time [ms],pressure [kPa]\n0,nan\n", "table.csv:2:"},
      {"time [ms],pressure [kPa]\n0,x\n", "table.csv:2:"},
      {"time [ms],pressure [kPa]\n", "has 0 entries"},
      {"time [ms],pressure [kPa]\n1,1\n0,1\n", "must ascend"},
      {"time [ms],pressure [kPa]\n0,1e9\n", "out of range"}};
  for (const auto &[text, reason] : files) {
    folder.write(text);
    EXPECT_NE(folder.complaint("table: table.csv").find(reason), std::string::npos)
        << text << folder.complaint("table: table.csv");
  }
  folder.write("time [ms],pressure [kPa]\n0,1\n");
  EXPECT_NE(folder.complaint("{table: table.csv, values: [2 Pa]}").find("is given beside 'values'"), std::string::npos);
  EXPECT_NE(folder.complaint("{times: [0 s, 1 s], values: [2 Pa]}").find("1 entries for 2"), std::string::npos);
}
