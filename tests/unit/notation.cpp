// What a run prints of a scheme is what a scene may say.
#include "coupler/sequence/notation.h"
#include "coupler/sequence/vocabulary.h"
#include "tests/unit/all_schemes.h"

#include <algorithm>
#include <gtest/gtest.h>

using namespace heartbus;
using namespace heartbus::coupler;

namespace {

/// And one that iterates to a tolerance.
std::vector<CouplingParameters> schemes_and_one_with_tolerance() {
  std::vector<CouplingParameters> all = all_schemes();
  CouplingParameters converged = all[2];
  converged.tolerance = 1.2345678901e-8;
  all.push_back(converged);
  return all;
}

/// The one gives the other its calcium.
std::pair<bus::ParticipantInfo, bus::ParticipantInfo> ep_and_fluid() {
  bus::ParticipantInfo ep, fluid;
  ep.name = "ep";
  ep.fields = {{"calcium", "tissue", "uM", "n+1", 1, true}};
  fluid.name = "fluid";
  fluid.fields = {{"calcium", "tissue", "uM", "", 1, false}};
  return {ep, fluid};
}

SceneParameters scene_with(const std::string &sequence) {
  return read_scene("coupling:\n  scheme: custom\n  sequence:" + sequence, "scene.yaml");
}

/// As a scene would have it: each line under `sequence` is indented by two more.
std::string indented(std::string text) {
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 3)
    text.insert(at + 1, "  ");
  return text;
}

void expect_equal(const Nodes &a, const Nodes &b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].kind, b[i].kind);
    EXPECT_EQ(a[i].participant, b[i].participant);
    EXPECT_EQ(a[i].task, b[i].task);
    EXPECT_EQ(a[i].receiver, b[i].receiver);
    EXPECT_EQ(a[i].field, b[i].field);
    EXPECT_EQ(a[i].times, b[i].times);
    EXPECT_EQ(a[i].limit, b[i].limit);
    EXPECT_EQ(a[i].required, b[i].required);
    EXPECT_EQ(a[i].optional, b[i].optional);
    EXPECT_EQ(a[i].if_wanted, b[i].if_wanted);
    expect_equal(a[i].body, b[i].body);
  }
}

void expect_equal(const Sequence &a, const Sequence &b) {
  expect_equal(a.constants, b.constants);
  expect_equal(a.start, b.start);
  expect_equal(a.step, b.step);
}

std::string complaint(const std::string &sequence) {
  try {
    const SceneParameters scene = scene_with(sequence);
    check_names(scheme(scene.coupling), {"ep", "mech", "ale", "fluid"});
  } catch (const Failure &failure) {
    return failure.what();
  }
  return "";
}

} // namespace

TEST(Notation, ASchemeIsPrintedLineByLineAsItIsDefined) {
  EXPECT_EQ(to_yaml(scheme(all_schemes()[2])),
            "\n  once: [held mech->fluid if known, hold fluid]"
            "\n  start: [inflate mech, displacement mech->ale, solve ale, mesh_motion ale->fluid, start fluid]"
            "\n  step:\n    - solve ep\n    - calcium ep->mech\n    - prepare mech\n    - displacement mech->ale\n    "
            "- solve ale"
            "\n    - mesh_motion ale->fluid\n    - 3 times:\n        - wall_velocity mech->fluid\n        - wall_force "
            "mech->fluid"
            "\n        - solve fluid\n        - blood_force fluid->mech\n        - solve mech\n    - wall_velocity "
            "mech->fluid"
            "\n    - budget fluid\n    - commit ep\n    - commit mech\n    - commit ale\n    - commit fluid");
}

TEST(Notation, WhatARunPrintsOfASchemeIsThatSchemeInAScene) {
  for (const auto &coupling : schemes_and_one_with_tolerance()) {
    const std::string printed = to_yaml(scheme(coupling));
    const SceneParameters scene = scene_with(indented(printed));
    expect_equal(scheme(scene.coupling), scheme(coupling));
    EXPECT_EQ(to_yaml(scheme(scene.coupling)), printed);
    EXPECT_EQ(scene.coupling.has_robin_condition(), coupling.has_robin_condition()) << coupling.scheme;
    EXPECT_EQ(scene.coupling.repeats(), coupling.repeats()) << coupling.scheme;
  }
}

TEST(Notation, TheResolvedSceneSaysTheSameScheme) {
  for (const auto &coupling : schemes_and_one_with_tolerance()) {
    const SceneParameters scene = scene_with(indented(to_yaml(scheme(coupling))));
    const SceneParameters again = read_scene(print_scene(scene), "scene.resolved.yaml");
    expect_equal(scheme(again.coupling), scheme(coupling));
  }
}

TEST(Notation, AWrittenRepetitionIsAcceleratedLikeOurs) {
  CouplingParameters ours = all_schemes()[2];
  SceneParameters scene = scene_with(indented(to_yaml(scheme(ours))));
  ours.acceleration = scene.coupling.acceleration = "anderson";
  expect_equal(make_sequence(scene.coupling, 0.2e-3), make_sequence(ours, 0.2e-3));
}

TEST(Notation, ALineThatIsNoneIsToldWithItsPlaceAndWhatItCouldBe) {
  const std::string begin = "\n    step:\n      - solve ep\n      - ";
  for (const auto &[line, words] : std::vector<std::pair<std::string, std::string>>{
           {"solve", "'solve' is no line of a sequence; those are 'solve P'"},
           {"solve ep mech", "'solve ep mech' is no line of a sequence"},
           {"calcium ep->", "'calcium ep->' is no line of a sequence"},
           {"every 3 steps: [solve ep]", "'every 3 steps' is no line of a sequence"},
           {"2 times", "'2 times' repeats nothing; it needs a list of lines below"},
           {"2 times: []", "'2 times' repeats nothing; it needs a list of lines below"},
           {"0 times: [solve ep]", "'0 times' repeats from 1 to 1000 times"},
           {"99999999999 times: [solve ep]", "repeats from 1 to 1000 times"},
           {"solve mech: [solve ale]", "'solve mech' repeats nothing, so no lines can be below it"},
           {"at most 3 times until loss of fluid < 1 Pa: [solve ep]", "is no line of a sequence"},
           {"at most 3 times until loss of fluid < small: [solve ep]", "ends with a limit, a plain number in SI units"},
           {"2 times: [at most 3 times until loss of fluid < 1: [solve ep]]", "not within another repetition"},
           {"solve mehc", "the scene has no participant 'mehc'; did you mean 'mech'? It has ep, mech, ale, fluid"},
           {"calcium ep->mehc", "the scene has no participant 'mehc'"},
           {"2 times: [solve mehc]", "the scene has no participant 'mehc'"},
           {"at most 3 times until loss of fluidd < 1: [solve ep]", "the scene has no participant 'fluidd'"},
           {"{solve: ep}", "an entry is a line, or one with a list of its own"}}) {
    const std::string said = complaint(begin + line);
    EXPECT_EQ(said.find("scene.yaml:6: "), 0u) << said;
    EXPECT_NE(said.find(words), std::string::npos) << said;
  }
  EXPECT_NE(complaint("\n    start: [at most 3 times until loss of fluid < 1: [solve ep]]\n    step: [solve ep]")
                .find("scene.yaml:4: 'at most 3 times until loss of fluid < 1' depends on a scalar"),
            std::string::npos);
}

TEST(Notation, ASchemeNeedsAStepAndSaysItselfHowOften) {
  EXPECT_NE(complaint(" {start: [solve ep]}").find("custom needs 'coupling.sequence.step'"), std::string::npos);
  EXPECT_NE(complaint(" {step: [solve ep, commit ep]}\n  iterations: 2").find("custom says itself how often"),
            std::string::npos);
  EXPECT_NE(complaint(" {step: solve ep}").find("must be a list"), std::string::npos);
}

TEST(Notation, WhatALineOfTheSceneNamesAndNobodyHasIsToldAtOnce) {
  auto [ep, fluid] = ep_and_fluid();
  fluid.tasks = {"budget"};
  fluid.scalars = {{"volume_loss", "1", {}}};
  const SceneParameters scene = scene_with(R"(
    start: [sart fluid]
    step:
      - solve ep
      - calcum ep->fluid
      - at most 3 times until volume_los of fluid < 1e-3:
          - solve fluid
          - budgt fluid
      - commit ep
      - commit fluid)");
  try {
    drop_absent(scheme(scene.coupling), {ep, fluid});
    FAIL();
  } catch (const Failure &failure) {
    EXPECT_STREQ(
        failure.what(),
        "the scheme custom needs scene.yaml:4: 'sart' of fluid (no such task), scene.yaml:7: 'calcum' from ep "
        "to fluid (ep declares no such output; did you mean 'calcium'?), scene.yaml:8: 'volume_los' of fluid (no "
        "such scalar; did you mean 'volume_loss'?), scene.yaml:10: 'budgt' of fluid (no such task; did you mean "
        "'budget'?)");
  }
}

TEST(Notation, AStepThatDoesNotFitIsToldAtThePlaceOfItsLine) {
  auto [ep, fluid] = ep_and_fluid();
  const auto complaint = [&, ep = ep, fluid = fluid](const std::string &lines) -> std::string {
    const SceneParameters scene = scene_with("\n    step:" + lines);
    try {
      check(make_sequence(scene.coupling, 0.2e-3), {ep, fluid});
    } catch (const Failure &failure) {
      return failure.what();
    }
    return "";
  };
  const std::string does_not_fit = ": the scheme custom does not fit this run: ";
  EXPECT_EQ(complaint(" [solve ep, calcium ep->fluid, solve fluid, commit ep, commit fluid]"), "");
  EXPECT_EQ(complaint("\n      - solve ep\n      - commit ep\n      - calcium ep->fluid\n      - solve fluid"),
            "scene.yaml:7" + does_not_fit + "'ep' is busy after its commit, which must be its last line");
  EXPECT_EQ(complaint("\n      - solve ep\n      - calcium ep->fluid\n      - solve fluid\n      - commit ep"),
            "scene.yaml:8" + does_not_fit +
                "'fluid' must be solved and committed in each step, but is solved 1 and committed 0 times");
  EXPECT_EQ(complaint("\n      - calcium ep->fluid\n      - solve ep\n      - solve fluid\n      - commit ep\n      - "
                      "commit fluid"),
            "scene.yaml:5" + does_not_fit + "'calcium' is sent before 'ep' has computed it: 'solve ep' comes first");
  EXPECT_EQ(complaint("\n      - solve ep\n      - solve fluid\n      - commit ep\n      - commit fluid"),
            "scene.yaml:6" + does_not_fit +
                "'fluid' is solved before it has received 'calcium': 'calcium ep->fluid' comes first");
}
