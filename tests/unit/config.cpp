#include "common/base/failure.h"
#include "common/config/printer.h"
#include "common/units/nearest.h"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

using namespace heartbus;
using namespace heartbus::config;

namespace {

struct Site {
  std::vector<double> at{0, 0, 0};
  void describe(Section &s) { s.quantities("at", at, "m", 3, "centre"); }
};

struct Fluid {
  double viscosity = 0.0035, density = 1060, share = 0.1;
  int iterations = 1;
  bool stabilised = true;
  std::string scheme = "implicit", note = "a: b # c";
  std::vector<std::string> fields{"velocity", "pressure"};
  std::vector<Site> sites;

  void describe(Section &s) {
    s.quantity("viscosity", viscosity, "Pa s", positive, "dynamic viscosity");
    s.quantity("density", density, "kg/m^3", positive, "density");
    s.number("share", share, between(0, 1), "a share");
    s.integer("iterations", iterations, {1, 9}, "iterations");
    s.boolean("stabilised", stabilised, "use the stabilisation");
    s.choice("scheme", scheme, {"implicit", "explicit"}, "time scheme");
    s.text("note", note, "anything");
    s.texts("fields", fields, "output");
    sites.resize(s.list("sites", sites.size(), "places"));
    for (std::size_t i = 0; i < sites.size(); ++i)
      sites[i].describe(s.item("sites", i));
  }
};

struct Whole {
  Fluid fluid;
  void describe(Section &s) { fluid.describe(s.section("fluid", "blood")); }
};

Describe describe(Whole &whole) {
  return [&whole](Section &section) { whole.describe(section); };
}

Whole read_whole(const std::string &text) {
  Whole whole;
  read(parse_yaml(text, "scene.yaml"), describe(whole));
  return whole;
}

std::string complaint(const std::string &text) {
  try {
    read_whole(text);
  } catch (const Failure &failure) {
    EXPECT_EQ(failure.code(), ExitCode::scene);
    return failure.what();
  }
  return "";
}

} // namespace

TEST(Config, ValuesAreReadWithTheirUnitsAndTheRestKeepsItsDefault) {
  const Whole whole = read_whole("fluid: {viscosity: 4 mPa s, iterations: 2, sites: [{at: [1 mm, 0 m, -2 cm]}]}");
  EXPECT_EQ(whole.fluid.viscosity, 0.004);
  EXPECT_EQ(whole.fluid.density, 1060);
  EXPECT_EQ(whole.fluid.iterations, 2);
  ASSERT_EQ(whole.fluid.sites.size(), 1u);
  EXPECT_EQ(whole.fluid.sites[0].at, (std::vector<double>{0.001, 0, -0.02}));
}

TEST(Config, AnUnknownKeyIsReportedWithItsPlaceAndTheNearestOne) {
  EXPECT_EQ(
      complaint("fluid:\n  viscosty: 1 Pa s\n"),
      "scene.yaml:2: key 'fluid.viscosty' is unknown; did you mean 'viscosity'? Allowed here: viscosity, density, "
      "share, iterations, stabilised, scheme, note, fields, sites");
  EXPECT_EQ(complaint("fluid: {}\nflud: {}\n"),
            "scene.yaml:2: key 'flud' is unknown; did you mean 'fluid'? Allowed here: fluid");
}

TEST(Config, TheNearestKeyIsOfferedForSlipsOnly) {
  EXPECT_EQ(did_you_mean("edn", {"step", "end"}), "; did you mean 'end'?");
  EXPECT_EQ(did_you_mean("viscosty", {"velocity", "viscosity"}), "; did you mean 'viscosity'?");
  EXPECT_EQ(did_you_mean("banana", {"step", "end"}), ".");
}

TEST(Config, ValuesOutOfRangeShowTheRangeInTheUnitOfTheKey) {
  EXPECT_EQ(complaint("fluid:\n  density: -1 g/cm^3"),
            "scene.yaml:2: key 'fluid.density': -1000 kg/m^3 is out of range; allowed: above 0 kg/m^3");
  EXPECT_EQ(complaint("fluid: {share: 2}"), "scene.yaml:1: key 'fluid.share': 2 is out of range; allowed: from 0 to 1");
}

TEST(Config, WrongKindsOfValuesAreRefused) {
  EXPECT_NE(complaint("fluid: {iterations: 1.5}").find("'1.5' is not an integer"), std::string::npos);
  EXPECT_NE(complaint("fluid: {stabilised: maybe}").find("neither true nor false"), std::string::npos);
  EXPECT_NE(complaint("fluid: {scheme: implicite}").find("did you mean 'implicit'?"), std::string::npos);
  EXPECT_NE(complaint("fluid: {density: 1060}").find("has no unit"), std::string::npos);
  EXPECT_NE(complaint("fluid: {density: [1 kg/m^3]}").find("must be a single value"), std::string::npos);
  EXPECT_NE(complaint("fluid: {fields: velocity}").find("must be a list"), std::string::npos);
  EXPECT_NE(complaint("fluid: 3").find("must be a block"), std::string::npos);
  EXPECT_NE(complaint("fluid: {sites: [{at: [1 mm]}]}").find("must have 3 entries, not 1"), std::string::npos);
  EXPECT_NE(complaint("fluid: {sites: [{att: 1}]}").find("key 'fluid.sites[0].att' is unknown"), std::string::npos);
}

TEST(Config, DuplicateKeysAndBrokenYamlAreRefusedWithTheirLine) {
  EXPECT_EQ(complaint("fluid:\n  density: 1 kg/m^3\n  density: 2 kg/m^3\n"),
            "scene.yaml:3: key 'density' is given twice; first at scene.yaml:2");
  EXPECT_EQ(complaint("fluid:\n  density: {1\n").substr(0, 11), "scene.yaml:");
}

TEST(Config, APrintedSceneReadsBackToTheSameValues) {
  Whole whole =
      read_whole("fluid: {viscosity: 3.3333333333333333 mPa s, scheme: explicit, sites: [{at: [1 m, 2 m, 3 m]}, "
                 "{at: [0.1 mm, 0 m, 0 m]}]}");
  const std::string text = print(describe(whole));
  Whole again = read_whole(text);
  EXPECT_EQ(print(describe(again)), text);
  EXPECT_EQ(again.fluid.viscosity, whole.fluid.viscosity);
  EXPECT_EQ(again.fluid.note, "a: b # c");
  EXPECT_EQ(again.fluid.sites[1].at[0], 1e-4);
  EXPECT_NE(text.find("# dynamic viscosity"), std::string::npos);
}

TEST(Config, ASettingFromTheCommandLineWinsAndIsNamedInErrors) {
  Node root = parse_yaml("fluid: {density: 1 kg/m^3}", "scene.yaml");
  set_value(root, "fluid.density", "2 kg/m^3", "--set density");
  set_value(root, "fluid.fields", "[a, b]", "--set fields");
  Whole whole;
  read(root, describe(whole));
  EXPECT_EQ(whole.fluid.density, 2);
  EXPECT_EQ(whole.fluid.fields, (std::vector<std::string>{"a", "b"}));
  set_value(root, "fluid.density", "2", "--set density");
  EXPECT_THROW(
      {
        try {
          read(root, describe(whole));
        } catch (const Failure &failure) {
          EXPECT_EQ(std::string(failure.what()).substr(0, 15), "--set density: ");
          throw;
        }
      },
      Failure);
}

TEST(Config, AnEmptyValueTakesAwayWhatTheBaseHas) {
  Node root = parse_yaml("fluid: {density: 1 kg/m^3, viscosity: 1 Pa s}", "base.yaml");
  set_value(root, "fluid.density", "", "scene.yaml:1");
  Whole whole;
  read(root, describe(whole));
  EXPECT_EQ(whole.fluid.density, 1060);
  EXPECT_EQ(whole.fluid.viscosity, 1);
}

TEST(Config, ASceneOverlaysItsBaseAndErrorsKeepTheirFile) {
  const auto folder = std::filesystem::temp_directory_path() / ("heartbus_config_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "base.yaml") << "fluid:\n  density: 1 kg/m^3\n  iterations: 0\n";
  std::ofstream(folder / "scene.yaml") << "base: base.yaml\nfluid: {density: 2 kg/m^3}\n";
  const Node root = load_yaml((folder / "scene.yaml").string());
  std::string message;
  Whole whole;
  try {
    read(root, describe(whole));
  } catch (const Failure &failure) {
    message = failure.what();
  }
  std::filesystem::remove_all(folder);
  EXPECT_EQ(whole.fluid.density, 2);
  EXPECT_EQ(message.find((folder / "base.yaml:3").string()), 0u) << message;
}
