#include "coupler/results_name.h"

#include <cstdlib>
#include <gtest/gtest.h>

using namespace heartbus;
using namespace heartbus::coupler;

namespace {

std::string name_of(const std::vector<std::string> &settings, const std::string &scene = "ideal_lv/efs1.yaml") {
  return results_name("efs1", changes(std::getenv("HEARTBUS_SOURCE") + ("/configs/" + scene), settings));
}

} // namespace

TEST(ResultsName, IsOfTheSceneAndWhatIsChangedHoweverItIsWritten) {
  EXPECT_EQ(name_of({}), "efs1");
  EXPECT_EQ(name_of({"mesh=M1", "time.step=0.4 ms"}), "efs1-mesh=M1-step=0.4ms");
  EXPECT_EQ(name_of({"time.step=0.4 ms", "geometry.mesh=M1"}), "efs1-mesh=M1-step=0.4ms");
  EXPECT_EQ(name_of({"alpha=8000 kg/(m^2 s)"}), "efs1-alpha=8000kg_m2s");
  EXPECT_EQ(name_of({"mesh=M1", "mesh=M2"}), "efs1-mesh=M2");
  EXPECT_EQ(name_of({"mech.ranks=7", "ep.ranks=7"}), "efs1-ep.ranks=7-mech.ranks=7");
  EXPECT_EQ(name_of({"mechanics.pericardium.labels=[]"}), "efs1-labels=none");
}

TEST(ResultsName, IsThatOfTheSceneWhenNothingButItsLengthChanges) {
  EXPECT_EQ(name_of({"mesh=M0", "time.step=200 us", "time.end=20 ms"}), "efs1");
  EXPECT_EQ(name_of({"time.beats=3"}), "efs1");
}

TEST(ResultsName, TellsBlocksAndListsThatAreTakenAway) {
  EXPECT_EQ(name_of({"participants.ep=", "active.model=none"}), "efs1-active.model=none-ep=none");
  EXPECT_EQ(name_of({"mechanics.pericardium.labels=[epicardium, base]"}), "efs1-labels=epicardium_base");
}

TEST(ResultsName, CanBeAFolderHoweverMuchIsChanged) {
  const std::string odd = name_of({"participants.mech.command=/bin/true '..//$(x)' \"" + std::string(300, 'y') + "\""});
  EXPECT_LT(odd.size(), 110u);
  EXPECT_EQ(odd.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_.=+"),
            std::string::npos);
  const std::vector<std::string> many{"mesh=M1",
                                      "alpha=8000 kg/(m^2 s)",
                                      "time.step=0.4 ms",
                                      "aortic_pressure=80 mmHg",
                                      "mitral_pressure=11 mmHg",
                                      "valve_hysteresis=11 Pa",
                                      "aortic_resistance=2e7 kg/(m^4 s)"};
  const std::string name = name_of(many);
  EXPECT_LE(name.size(), 104u);
  EXPECT_EQ(name.find("efs1-alpha=8000kg_m2s-"), 0u) << name;
  std::vector<std::string> others = many;
  others.back() = "aortic_resistance=3e7 kg/(m^4 s)";
  EXPECT_NE(name_of(others), name);
  EXPECT_EQ(name_of({many.rbegin(), many.rend()}), name);
}
