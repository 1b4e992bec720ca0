#include "common/schema/scene.h"
#include "common/bus/failure.h"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

using namespace heartbus;

namespace {

std::string complaint(const std::string &text, const std::vector<std::string> &settings = {}) {
  const auto file = std::filesystem::temp_directory_path() / ("heartbus_scene_" + std::to_string(getpid()) + ".yaml");
  std::ofstream(file) << text;
  std::string message;
  try {
    load_scene(file.string(), settings);
  } catch (const Failure &failure) {
    message = failure.what();
  }
  std::filesystem::remove(file);
  return message;
}

} // namespace

TEST(Scene, TheDefaultSceneReadsBackFromItsOwnPrint) {
  const std::string text = print_scene({});
  EXPECT_EQ(print_scene(read_scene(text, "print")), text);
}

TEST(Scene, OnlyTheListedParticipantsTakePart) {
  const SceneParameters scene =
      read_scene("participants:\n  mech: {ranks: 2}\n  mine: {program: ./x, settings: {a: 1 b}}\n"
                 "coupling: {scheme: electromechanics}\n",
                 "scene");
  EXPECT_EQ(scene.participants.size(), 2u);
  EXPECT_EQ(scene.participants.at("mech").program, "mech_solver");
  EXPECT_EQ(scene.participants.at("mine").settings.at("a"), "1 b");
}

TEST(Scene, KeysOnTheCommandLineMayBeShortenedWhileTheyAreUnique) {
  EXPECT_EQ(complaint("scene: a", {"alpha=8000 kg/(m^2 s)", "mech.ranks=2", "time.end=1 ms"}), "");
  EXPECT_NE(complaint("scene: a", {"ranks=2"}).find("--set ranks: the key is not unique"), std::string::npos);
  EXPECT_NE(complaint("scene: a", {"alhpa=2"}).find("did you mean 'alpha'?"), std::string::npos);
  EXPECT_NE(complaint("scene: a", {"alpha=2"}).find("--set alpha=2: key 'coupling.alpha': '2' has no unit"),
            std::string::npos);
  EXPECT_NE(complaint("scene: a", {"alpha"}).find("write key=value"), std::string::npos);
}

TEST(Scene, AlphaIsAQuantityOrAutomatic) {
  EXPECT_FALSE(read_scene("coupling: {alpha: 8000 kg/(m^2 s)}", "scene").coupling.automatic_alpha);
  const SceneParameters automatic = read_scene("coupling: {alpha: auto}", "scene");
  EXPECT_TRUE(automatic.coupling.automatic_alpha);
  EXPECT_TRUE(read_scene(print_scene(automatic), "printed").coupling.automatic_alpha);
  EXPECT_EQ(complaint("coupling: {alpha: auto}", {"alpha=5 kg/(m^2 s)"}), "");
  EXPECT_NE(complaint("coupling: {alpha: automatic}").find("key 'coupling.alpha'"), std::string::npos);
}

TEST(Scene, KeysOfAnotherSchemeAreRefused) {
  EXPECT_EQ(complaint("coupling: {scheme: E1FS, iterations: 9, tolerance: 1e-6, acceleration: anderson}"), "");
  EXPECT_NE(complaint("coupling: {scheme: adaptive, iterations: 9, tolerance: 1e-6}").find("only 'scheme: E1FS'"),
            std::string::npos);
  EXPECT_NE(complaint("coupling: {scheme: by_phase}").find("more than one"), std::string::npos);
  EXPECT_NE(complaint("coupling: {acceleration: anderson}").find("no iterations to accelerate"), std::string::npos);
}

TEST(Scene, BlocksThatDoNotFitTogetherAreRefused) {
  EXPECT_NE(complaint("time: {end: 1 ms, step: 0.3 ms}").find("key 'time.step'"), std::string::npos);
  EXPECT_NE(complaint("output: {every: 0.3 ms}").find("must be a multiple of 'time.step'"), std::string::npos);
  EXPECT_NE(complaint("coupling: {scheme: electromechanics}").find("no participants 'fluid'"), std::string::npos);
  EXPECT_NE(complaint("coupling: {iterations: 2}").find("EFS1 has one iteration"), std::string::npos);
  EXPECT_NE(complaint("participants: {mech: {}, fluid: {}}").find("need 'ale'"), std::string::npos);
  EXPECT_NE(complaint("fluid: {initial_pressure: 10 mmHg}").find("start in balance"), std::string::npos);
  EXPECT_NE(complaint("scene: ../up").find("cannot name a folder"), std::string::npos);
  EXPECT_NE(complaint("participants: {mine: {ranks: 1}}").find("has no 'program'"), std::string::npos);
}

TEST(Scene, ARunLastsBeatsOrEndsAtATime) {
  const auto time = [](const std::string &text) { return read_scene(text, "scene").time; };
  EXPECT_EQ(time("scene: a").end, 0.8);
  EXPECT_EQ(time("time: {beats: 3}").n_steps(), 12000);
  EXPECT_EQ(time("time: {end: 40 ms}").n_steps(), 200);
  EXPECT_EQ(time("time: {end: 1.6 s, beats: 2}").n_steps(), 8000);
  EXPECT_EQ(time("time: {beats: 3}\nelectrophysiology: {stimulus: {period: 0.5 s}}").end, 1.5);
  EXPECT_EQ(time("time: {beats: 5, until_periodic: 1 %}").until_periodic, 0.01);
  for (const char *text : {"time: {beats: 3}", "time: {end: 40 ms}", "time: {end: 1.6 s, beats: 2}"}) {
    const std::string printed = print_scene(read_scene(text, "scene"));
    EXPECT_EQ(print_scene(read_scene(printed, "printed")), printed);
  }
}

TEST(Scene, BeatsThatContradictTheEndAreRefused) {
  EXPECT_NE(complaint("time: {end: 2 s, beats: 3}")
                .find("key 'time.end': is 2 s, but 'beats: 3' of 0.8 s (electrophysiology.stimulus.period) end at"),
            std::string::npos);
  EXPECT_NE(complaint("time: {end: 2 s}", {"beats=1"}).find("write one of the two"), std::string::npos);
  EXPECT_EQ(complaint("time: {beats: 2}", {"time.end=40 ms", "beats=0"}), "");
  EXPECT_NE(complaint("time: {beats: 0}").find("key 'time.beats': must be 1 at least"), std::string::npos);
  EXPECT_NE(complaint("time: {until_periodic: 1 %}").find("needs 'beats'"), std::string::npos);
  EXPECT_NE(complaint("time: {beats: 2, until_periodic: 1 ms}").find("key 'time.until_periodic'"), std::string::npos);
  EXPECT_NE(complaint("time: {beats: 2, until_periodic: 1 %}\ncoupling: {scheme: electromechanics}\n"
                      "participants: {ep: , mech: {}}")
                .find("neither 'fluid' nor 'fsi' takes part"),
            std::string::npos);
  EXPECT_NE(complaint("electrophysiology: {stimulus: {period: 0.30005 s}}").find("key 'time.step'"), std::string::npos);
}

TEST(Scene, APulseNeedsAnOpening) {
  const fluid::InletParameters pulse{"inlet", 1333, 3e-3};
  EXPECT_EQ(pulse.at(1e-4), 1333);
  EXPECT_EQ(pulse.at(30 * 1e-4), 1333);
  EXPECT_EQ(pulse.at(31 * 1e-4), 0);
  EXPECT_NE(complaint("fluid: {inlet: {label: base}}").find("no pulse comes through 'base'"), std::string::npos);
  EXPECT_NE(complaint("fluid: {inlet: {label: inlet, pressure: 10 ms}}").find("key 'fluid.inlet.pressure'"),
            std::string::npos);
}

TEST(Scene, FieldsAreDueAtMultiplesOfTheirInterval) {
  OutputParameters output;
  output.every = 1e-3;
  EXPECT_TRUE(output.due(0, 2e-4));
  EXPECT_FALSE(output.due(4, 2e-4));
  EXPECT_TRUE(output.due(5, 2e-4));
  output.every = 0;
  EXPECT_FALSE(output.due(5, 2e-4));
}
