#include "scene/scene.h"
#include "common/base/failure.h"

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
                 "coupling: {scheme: one_way}\n",
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

TEST(Scene, AShortKeyIsTheOneThatTheSceneUses) {
  const std::string piston =
      "geometry: {shape: piston}\nparticipants: {mech: , ale: , fluid: }\nfluid: {no_slip: []}\n"
      "mechanics: {law: neo_hookean, fixed: [], pericardium: {labels: []}}\nlifting: {fixed: []}\n";
  EXPECT_EQ(complaint(piston, {"kappa=1 kPa", "density=1.1 g/cm^3", "geometry.piston.fluid=5 mm"}),
            "--set density: the key is not unique; write one of mechanics.density, fluid.density");
  EXPECT_EQ(complaint(piston, {"kappa=1 kPa"}), "");
  EXPECT_EQ(complaint("mechanics: {law: neo_hookean}", {"neo_hookean.kappa=1 kPa", "law=neo_hookean"}), "");
  const std::string tube = "geometry: {shape: tube}\nparticipants: {mech: , ale: , fluid: }\nfluid: {no_slip: []}\n"
                           "mechanics: {fixed: [ends], pericardium: {labels: []}}\nlifting: {fixed: []}\n";
  EXPECT_EQ(complaint(tube, {"wall=2 mm", "radius=4 mm"}), "");
  EXPECT_EQ(complaint("scene: a", {"wall=12 mm"}), "");
}

TEST(Scene, AKeyOfALawIsUsedWhereTheWallOrARegionHasTheLaw) {
  const std::string piston =
      "geometry: {shape: piston}\nparticipants: {mech: , ale: , fluid: }\nfluid: {no_slip: []}\nlifting: {fixed: []}\n"
      "mechanics: {fixed: [], pericardium: {labels: []}, regions: {box: {law: neo_hookean}}}\n";
  EXPECT_EQ(complaint(piston, {"guccione.kappa=1 kPa"}), "");
  EXPECT_EQ(complaint(piston, {"mechanics.neo_hookean.mu=1 kPa"}), ""); // which the region takes
  EXPECT_EQ(complaint(piston, {"box.neo_hookean.mu=1 kPa"}), "");
  for (const auto &[setting, why] :
       {std::pair{"box.guccione.kappa=1 kPa", "'mechanics.regions.box.law' is neo_hookean"},
        {"mechanics.saint_venant_kirchhoff.mu=1 kPa", "'mechanics.law' is guccione"}})
    EXPECT_NE(complaint(piston, {setting}).find(why), std::string::npos) << complaint(piston, {setting});
}

TEST(Scene, AValueForAKeyThatTheSceneDoesNotUseIsRefusedWithTheReason) {
  const std::string radius = complaint("scene: a", {"radius=0.1 mm"});
  EXPECT_NE(radius.find("--set radius: this scene does not use 'geometry.tube.radius': 'geometry.shape' is "
                        "ideal_left_ventricle"),
            std::string::npos)
      << radius;
  EXPECT_NE(radius.find("geometry.ventricle.mitral_radius"), std::string::npos) << radius;
  for (const auto &[setting, why] : {std::pair{"mu=1 kPa", "'mechanics.law' is guccione"},
                                     {"inlet.pressure.values=[1 kPa]", "'fluid.inlet.label' is empty"},
                                     {"epsilon=1e-6", "'coupling.scheme' is EFS1"},
                                     {"fibres.direction=[1, 0, 0]", "'fibres.rule' is transmural"},
                                     {"eikonal.speed=0.7 m/s", "'electrophysiology.model' is monodomain"},
                                     {"prescribed.calcium.values=[1 uM]", "'electrophysiology.model' is monodomain"}})
    EXPECT_NE(complaint("scene: a", {setting}).find(why), std::string::npos)
        << setting << complaint("scene: a", {setting});
  const std::string alone = "participants: {ep: }\ncoupling: {scheme: one_way}\n";
  EXPECT_NE(complaint(alone, {"aortic_pressure=9 kPa"}).find("neither fluid_solver nor fsi_solver takes part"),
            std::string::npos);
  EXPECT_EQ(
      complaint("participants: {mech: {program: ./mine}}\ncoupling: {scheme: one_way}\n", {"aortic_pressure=9 kPa"}),
      "")
      << "a program from elsewhere may use any key";
  EXPECT_EQ(complaint("participants: {mech: }\ncoupling: {scheme: one_way}\n", {"period=0.5 s"}), "");
  EXPECT_NE(complaint("electrophysiology: {model: eikonal}", {"substep_tolerance=0.2"})
                .find("'electrophysiology.model' is eikonal"),
            std::string::npos);
  const std::string one_pressure =
      "participants: {mech: , circulation: {program: cavity_solver}}\ncoupling: {scheme: circulation}\n";
  EXPECT_EQ(complaint(one_pressure, {"aortic_pressure=9 kPa"}), "");
  EXPECT_NE(complaint(one_pressure, {"lifting.tolerance=1e-9"}).find("no ale_solver takes part"), std::string::npos);
}

TEST(Scene, NearMissesGetASuggestion) {
  EXPECT_NE(
      complaint("participants: {ep: }\ncoupling: {scheme: one_way}", {"aortic_presure=1"}).find("'aortic_pressure'"),
      std::string::npos)
      << "of a key that the scene does not use, too";
  for (const auto &[key, meant] : {std::pair{"alhpa", "'alpha'"},
                                   {"coupling.alpa", "'coupling.alpha'"},
                                   {"ventricle.wal", "'ventricle.wall'"},
                                   {"tension_m", "tension_max"},
                                   {"windkessel.resistance", "fluid.aortic_resistance"}})
    EXPECT_NE(complaint("scene: a", {std::string(key) + "=1"}).find(meant), std::string::npos)
        << complaint("scene: a", {std::string(key) + "=1"});
  const std::string other_law = complaint("scene: a", {"holzapfel_ogden.kappa=1 kPa"});
  EXPECT_NE(other_law.find("did you mean mechanics.guccione.kappa?"), std::string::npos) << other_law;
  const std::string no_mesh =
      complaint("geometry: {shape: slab}\nparticipants: {ep: }\ncoupling: {scheme: one_way}", {"mesh=M1"});
  EXPECT_NE(no_mesh.find("this scene does not use 'geometry.mesh'"), std::string::npos) << no_mesh;
  EXPECT_EQ(no_mesh.find("did you mean"), std::string::npos)
      << "the key is right, the scene has no use for it: " << no_mesh;
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
  EXPECT_NE(complaint("coupling: {iterations: 2}").find("EFS1 has one iteration"), std::string::npos);
  EXPECT_NE(complaint("participants: {mech: {}, fluid: {}}").find("need 'ale'"), std::string::npos);
  EXPECT_NE(complaint("fluid: {initial_pressure: 10 mmHg}").find("start in balance"), std::string::npos);
  EXPECT_NE(complaint("scene: ../up").find("cannot name a folder"), std::string::npos);
  EXPECT_NE(complaint("participants: {mine: {ranks: 1}}").find("has neither 'program' nor 'command'"),
            std::string::npos);
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
  EXPECT_NE(complaint("time: {beats: 2, until_periodic: 1 %}\ncoupling: {scheme: one_way}\n"
                      "participants: {ep: , mech: {}}")
                .find("neither 'fluid' nor 'fsi' takes part"),
            std::string::npos);
  EXPECT_NE(complaint("electrophysiology: {stimulus: {period: 0.30005 s}}").find("key 'time.step'"), std::string::npos);
}

TEST(Scene, APulseNeedsAnOpening) {
  const config::Table pulse{{0, 3e-3, 3e-3}, {1333, 1333, 0}};
  EXPECT_EQ(pulse.at(1e-4), 1333);
  EXPECT_EQ(pulse.at(30 * 1e-4), 1333);
  EXPECT_EQ(pulse.at(31 * 1e-4), 0);
  EXPECT_NE(complaint("fluid: {inlet: {label: base}}").find("nothing comes through 'base'"), std::string::npos);
  EXPECT_NE(complaint("fluid: {inlet: {label: inlet, pressure: {values: [10 ms]}}}")
                .find("key 'fluid.inlet.pressure.values'"),
            std::string::npos);
}

TEST(Scene, NonsenseIsRefusedWithAReason) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"geometry: {ventricle: {endocardium_across: 22 m}}",
       "22 m is out of range; allowed: from 0.001 to 0.5 m: hearts measure centimetres; metres for millimetres?"},
      {"geometry: {ventricle: {mitral_radius: 1e-300 m}}", "out of range"},
      {"geometry: {ventricle: {mitral_centre: -15 mm}}", "beyond the base, whose radius is"},
      {"geometry: {shape: slab, slab: {cell: 1e-9 m}}\nparticipants: {ep: {}}\ncoupling: {scheme: one_way}",
       "key 'geometry.slab.cell'"},
      {"geometry: {shape: slab, slab: {cell: 0.01 mm}}\nparticipants: {ep: {}}\ncoupling: {scheme: one_way}",
       "cells; 100000000 at most"},
      {"geometry: {piston: {cells_across: 5000}}", "cells; 100000000 at most"},
      {"geometry: {shape: slab}", "has no fluid; take ideal_left_ventricle"},
      {"time: {end: 1e5 s, step: 1e-9 s}", "makes 1e+14 steps; a run has 1e9 at most"},
      {"time: {end: 1e-12 s}", "must divide the end of the run"},
      {"output: {every: 1e-11 s}", "must be a multiple of 'time.step'"},
      {"output: {checkpoint: {every: 1e-12 s}}", "is less than 'time.step'"},
      {"coupling: {alpha: 1e308 kg/(m^2 s)}", "no quantity here is larger than 1e15"},
      {"coupling: {alpha: 1e308 Gg/(m^2 s)}", "too large for a number in kg/(m^2 s)"},
      {"fluid: {density: 4.9e-324 ng/m^3}", "too small for a number in kg/m^3"},
      {"mechanics: {guccione: {a_ff: 1e300}}", "no quantity here is larger"},
      {"fluid: {mitral_pressure: 1333 kPa}", "pressures of blood are a few 10 kPa"},
      {"mechanics: {fixed: [bottom]}", "key 'mechanics.fixed': the mesh has no boundary label 'bottom'"},
      {"mechanics: {pericardium: {labels: [epicardum]}}", "did you mean 'epicardium'?"},
      {"fluid: {inlet: {label: ends}}", "key 'fluid.inlet'"},
      {"lifting: {slip: [x_low]}", "key 'lifting.slip'"},
      {"mechanics: {loads: {push: {label: interfase}}}", "no boundary label 'interfase'; did you mean 'interface'?"},
      {"mechanics: {loads: {push: {pressure: {values: [1 Pa]}}}}", "key 'mechanics.loads.push.label'"},
      {"mechanics: {loads: {push: {label: interface, pressure: {values: [1 Pa, 2 Pa]}}}}",
       "2 entries for 1 of 'times'"},
      {"mechanics: {loads: {push: {label: interface, pressure: {times: [1 s, 0 s], values: [1 Pa, 2 Pa]}}}}",
       "must ascend"},
      {"mechanics: {loads: {push: {label: interface, pressure: {table: none.csv}}}}",
       "none.csv: this table cannot be read"},
      {"mechanics: {inertia: false}", "'inertia: false' is for a wall without blood"},
      {"mechanics: {regions: {ring: {contracts: false}}}", "the solid has no region 'ring'"},
      {"electrophysiology: {conductivity: {regions: {ring: {fibre: 0 m^2/s}}}}", "the solid has no region 'ring'"},
      {"scene: ..", "cannot name a folder"},
      {"scene: -n", "cannot name a folder"},
      {"scene: \"a\\nb\"", "control characters"},
      {"scene: \"\\e[31mred\"", "control characters"},
      {"scene: $(touch pwned)", "cannot name a folder"},
      {"participants: {':': {program: x}}", "cannot name a participant"},
      {"participants: {-n: {program: x}}", "cannot name a participant"},
      {"participants: {ep: {program: \"a\\0b\"}}", "control characters"},
      {"fibres: {angle_endo: 60 rad}", "half a turn is 3.14 rad"},
      {"electrophysiology: {model: eikonl}", "did you mean 'eikonal'?"},
      {"electrophysiology: {ionic_model: bueno_orovio}", "bueno_orovio_epi"},
      {"electrophysiology: {eikonal: {speed: 600 m/s}}", "fronts in hearts travel at about 0.7 m/s"},
      {"electrophysiology: {model: eikonal, conductivity: {normal: 0 m^2/s}}", "or its front never crosses"},
      {"electrophysiology: {model: prescribed, prescribed: {activation: none.h5}}",
       "key 'electrophysiology.prescribed.activation': there is no file "},
      {"electrophysiology: {prescribed: {calcium: {times: [0 ms, 2 ms, 1 ms], values: [1 uM, 1 uM, 1 uM]}}}",
       "key 'electrophysiology.prescribed.calcium.times': must ascend"},
      {"electrophysiology: {prescribed: {calcium: {times: [-1 ms, 1 ms], values: [1 uM, 2 uM]}}}",
       "must not begin before the activation"},
      {"electrophysiology: {prescribed: {calcium: {times: [0 ms, 1 ms], values: [1 mM, 2 uM]}}}",
       "1000 uM is out of range"}};
  for (const auto &[text, reason] : cases)
    EXPECT_NE(complaint(text).find(reason), std::string::npos) << text << ": " << complaint(text);
}

TEST(Scene, EveryRefusalIsOneLineWithItsPlace) {
  for (const std::string &text :
       {std::string("mechanics: &a {b: *a}"), std::string("a: &a [*a]"), "scene: x" + std::string(100000, 'x'),
        "time: {end: 1 " + std::string(100000, '(') + "s}", "base: " + std::string(5000, 'x'), std::string("a: *b"),
        std::string("scene: \"\\e[31m\"\nscene: b"), "x: " + std::string(3000, '['), std::string("!!x ? y : z")}) {
    const std::string said = complaint(text);
    EXPECT_NE(said.find(".yaml:"), std::string::npos) << said;
    EXPECT_LT(said.size(), 2100u);
    EXPECT_EQ(said.find_first_of("\n\x1b"), std::string::npos);
  }
  EXPECT_NE(complaint("scene: a", {std::string(100000, 'a') + ".b=1"}).find("--set"), std::string::npos);
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
