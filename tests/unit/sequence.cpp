#include "coupler/sequence/notation.h"
#include "coupler/sequence/sequence_runner.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <map>

using namespace heartbus;
using namespace heartbus::coupler;

namespace {

bus::ParticipantInfo participant(const std::string &name, const std::vector<std::string> &outputs,
                                 const std::vector<std::string> &inputs, const std::vector<std::string> &tasks) {
  bus::ParticipantInfo info;
  info.name = name;
  info.tasks = tasks;
  for (const auto &field : outputs)
    info.fields.push_back({field, "interface", "m", "n+1", 1, true});
  for (const auto &field : inputs)
    info.fields.push_back({field, "interface", "m", "", 1, false});
  return info;
}

std::vector<bus::ParticipantInfo> heart() {
  return {participant("ep", {"calcium"}, {}, {}),
          participant("mech", {"displacement", "wall_velocity", "wall_force", "probe_force", "alpha_limit"},
                      {"calcium", "blood_force", "probe_velocity"}, {"inflate", "begin_probe", "probe", "end_probe"}),
          participant("ale", {"mesh_motion"}, {"displacement"}, {}),
          participant("fluid", {"blood_force", "probe_velocity"},
                      {"mesh_motion", "wall_velocity", "wall_force", "probe_force", "alpha_limit"},
                      {"start", "budget", "begin_probe", "probe", "follow_limit"})};
}

std::vector<bus::ParticipantInfo> without(std::vector<bus::ParticipantInfo> all, const std::string &name) {
  for (auto at = all.begin(); at != all.end(); ++at)
    if (at->name == name) {
      all.erase(at);
      break;
    }
  return all;
}

Sequence scheme(const std::string &name, int iterations = 1, double tolerance = 0) {
  CouplingParameters coupling;
  coupling.scheme = name;
  coupling.iterations = iterations;
  coupling.tolerance = tolerance;
  return make_sequence(coupling, 0.2e-3);
}

std::string stream(const Sequence &sequence) {
  Routes routes;
  for (const auto &[node, iteration] : flatten(sequence.step))
    routes.insert({{node.participant, node.receiver, node.field}, static_cast<int>(routes.size())});
  std::string text;
  for (const auto &[who, command] : commands(sequence.step, routes, {7, 0, 1.4e-3, 2e-4}))
    text += who + " " + std::to_string(static_cast<int>(command.kind)) + command.task + " " +
            std::to_string(command.route) + " " + std::to_string(command.step.number) + "." +
            std::to_string(command.step.iteration) + "\n";
  return text;
}

std::string complaint(const Sequence &sequence, const std::vector<bus::ParticipantInfo> &participants) {
  try {
    check(drop_absent(sequence, participants), participants);
  } catch (const Failure &failure) {
    return failure.what();
  }
  return "";
}

int count(const std::string &text, const std::string &word) {
  int n = 0;
  for (std::size_t at = 0; (at = text.find(word, at)) != std::string::npos; ++at)
    ++n;
  return n;
}

} // namespace

TEST(Sequence, E1FSWithOneIterationIsTheVeryStreamOfEFS1) {
  EXPECT_EQ(stream(scheme("E1FS", 1)), stream(scheme("EFS1")));
  EXPECT_NE(stream(scheme("E1FS", 2)), stream(scheme("EFS1")));
}

TEST(Sequence, E1FSRepeatsFluidAndWallOnlyAndCountsIterations) {
  const std::string text = stream(scheme("E1FS", 3));
  const std::string solve = std::to_string(static_cast<int>(bus::Command::Kind::solve));
  EXPECT_EQ(count(text, "fluid " + solve + " "), 3);
  EXPECT_EQ(count(text, "mech " + solve + " "), 3);
  EXPECT_EQ(count(text, "ep " + solve + " "), 1);
  EXPECT_EQ(count(text, "ale " + solve + " "), 1);
  EXPECT_EQ(count(text, "mech " + solve + " -1 7.2"), 1);
}

TEST(Sequence, RepetitionsWithoutAFixedNumberAreReadAsOne) {
  const std::string text = to_text(scheme("E1FS", 20, 1e-8));
  EXPECT_NE(text.find("at most 20 times until datum_residual of fluid < 1e-08 or fail (wall_velocity mech->fluid; "),
            std::string::npos)
      << text;
  int solves = 0;
  for (const auto &[node, iteration] : flatten(scheme("E1FS", 20, 1e-8).step))
    solves += node.kind == Node::Kind::solve && node.participant == "fluid";
  EXPECT_EQ(solves, 1);
}

TEST(Sequence, IterationsGoOnFromTheOneBefore) {
  const Nodes nodes{{Node::Kind::solve, "a", "", "", "", 1, {}}};
  EXPECT_EQ(commands(nodes, {}, {7, 3, 1.4e-3, 2e-4})[0].second.step.iteration, 3);
}

TEST(Sequence, TheLimitOfAlphaIsFoundNowAndThenAndDoesNotCountIterations) {
  const Sequence sequence = scheme("EFS1");
  EXPECT_NE(
      to_text(sequence).find(
          "every 1000 steps (begin_probe mech; begin_probe fluid; 12 times (probe_force mech->fluid if known; "
          "probe fluid; probe_velocity fluid->mech if known; probe mech); end_probe mech); alpha_limit mech->fluid"),
      std::string::npos)
      << to_text(sequence);
  int probes = 0;
  for (const auto &[node, iteration] : flatten(sequence.step)) {
    if (node.task == "probe" && node.participant == "fluid") {
      EXPECT_EQ(iteration, probes++);
    } else if (node.kind == Node::Kind::solve) {
      EXPECT_EQ(iteration, 0);
    }
  }
  EXPECT_EQ(probes, 12);
}

TEST(Sequence, EveryTransferIsSentOnceAndReceivedOnce) {
  int sent = 0, received = 0;
  Routes routes{{{"a", "b", "f"}, 4}};
  const Nodes nodes{{Node::Kind::transfer, "a", "", "b", "f", 1, {}}};
  for (const auto &[who, command] : commands(nodes, routes, {})) {
    sent += who == "a" && command.kind == bus::Command::Kind::send && command.route == 4;
    received += who == "b" && command.kind == bus::Command::Kind::receive && command.route == 4;
  }
  EXPECT_EQ(sent, 1);
  EXPECT_EQ(received, 1);
}

TEST(Sequence, AllSchemesPassTheChecksWithTheirParticipants) {
  EXPECT_EQ(complaint(scheme("EFS1"), heart()), "");
  EXPECT_EQ(complaint(scheme("E1FS", 4), heart()), "");
  EXPECT_EQ(complaint(scheme("E1FS", 4, 1e-8), heart()), "");
  EXPECT_EQ(complaint(scheme("adaptive", 4), heart()), "");
  EXPECT_EQ(complaint(scheme("by_phase", 4), heart()), "");
  const auto fsi = participant("fsi", {"displacement"}, {"calcium", "mesh_motion"}, {"inflate", "start"});
  EXPECT_EQ(complaint(scheme("E1FSinf"), {heart()[0], heart()[2], fsi}), "");
  EXPECT_EQ(complaint(scheme("one_way"), without(without(heart(), "ale"), "fluid")), "");
}

TEST(Sequence, LinesOfAbsentParticipantsAreDropped) {
  const auto piston = without(heart(), "ep");
  EXPECT_EQ(complaint(scheme("EFS1"), piston), "");
  EXPECT_EQ(to_text(drop_absent(scheme("EFS1"), piston)).find("calcium"), std::string::npos);
  for (const auto &alone : heart()) {
    EXPECT_EQ(complaint(scheme("EFS1"), {alone}), "") << alone.name;
    EXPECT_EQ(to_text(drop_absent(scheme("EFS1"), {alone})).find("->"), std::string::npos);
  }
}

TEST(Sequence, WhatTheWallHoldsIsSentOnceAndOnlyIfBothKnowOfIt) {
  auto participants = heart();
  EXPECT_EQ(to_text(drop_absent(scheme("EFS1"), participants)).find("held"), std::string::npos)
      << "another program's wall";
  participants[1].fields.push_back({"held", "interface", "1", "always", 3, true});
  EXPECT_EQ(to_text(drop_absent(scheme("EFS1"), participants)).find("held"), std::string::npos)
      << "another program's blood";
  participants[3].fields.push_back({"held", "interface", "1", "", 3, false});
  participants[3].tasks.push_back("hold");
  for (const auto &name : {"EFS1", "E1FS", "adaptive", "by_phase"}) {
    const std::string text = to_text(drop_absent(scheme(name, 2), participants));
    EXPECT_NE(text.find("\n  once:  held mech->fluid if known; hold fluid\n  start: inflate mech"), std::string::npos)
        << text;
    EXPECT_EQ(count(text, "held mech->fluid"), 1) << text;
    EXPECT_EQ(complaint(scheme(name, 2), participants), "");
  }
}

TEST(Sequence, AWallThatKnowsNoProbesIsCoupledWithoutTheLimitOfAlpha) {
  auto participants = heart();
  participants[1] =
      participant("mech", {"displacement", "wall_velocity", "wall_force"}, {"calcium", "blood_force"}, {"inflate"});
  EXPECT_EQ(complaint(scheme("EFS1"), participants), "");
  EXPECT_EQ(to_text(drop_absent(scheme("EFS1"), participants)).find("probe"), std::string::npos);
  CouplingParameters follows;
  follows.automatic_alpha = true;
  EXPECT_NE(complaint(make_sequence(follows, 0.2e-3), participants).find("needs 'alpha_limit' from mech to fluid"),
            std::string::npos);
}

TEST(Sequence, AllThatASchemeNeedsAndSomebodyDoesNotKnowIsToldAtOnce) {
  auto participants = heart();
  participants[1] = participant("mech", {"displacement", "wall_velocity"}, {"blood_force"}, {"inflate"});
  participants[3] = participant("fluid", {}, {"mesh_motion", "wall_velocity", "wall_force"}, {"start"});
  EXPECT_EQ(
      complaint(scheme("EFS1"), participants),
      "the scheme EFS1 needs 'calcium' from ep to mech (mech declares no such input), 'wall_force' from mech to fluid "
      "(mech declares no such output), 'blood_force' from fluid to mech (fluid declares no such output)");
}

TEST(Sequence, TasksThatAParticipantDoesNotOfferAreDropped) {
  auto participants = heart();
  participants[1].tasks.clear();
  EXPECT_EQ(to_text(drop_absent(scheme("EFS1"), participants)).find("inflate"), std::string::npos);
}

TEST(Sequence, EachPhysicsRunsAlone) {
  auto wall = participant("mech", {"displacement"}, {"calcium"}, {"inflate"});
  const auto lifting = participant("ale", {"mesh_motion"}, {"displacement"}, {}),
             blood = participant("fluid", {}, {"mesh_motion"}, {"start"});
  for (const auto &alone : {heart()[0], wall, lifting, blood})
    EXPECT_EQ(complaint(scheme("one_way"), {alone}), "") << alone.name;
  EXPECT_EQ(complaint(scheme("one_way"), {heart()[0], wall, lifting, blood}), "");
  const std::string chain = to_text(drop_absent(scheme("one_way"), {wall, lifting, blood}));
  EXPECT_NE(chain.find("solve mech; displacement mech->ale if wanted; solve ale; mesh_motion ale->fluid if wanted; "
                       "solve fluid"),
            std::string::npos)
      << chain;
}

TEST(Sequence, WhatIsWantedOfWhoTakesPartMustBeThere) {
  const auto tissue = heart()[0], wall = participant("mech", {"displacement"}, {"calcium"}, {"inflate"}),
             passive = participant("mech", {"displacement"}, {}, {"inflate"});
  auto of_another_field = tissue;
  of_another_field.fields[0].name = "potential";
  EXPECT_EQ(complaint(scheme("one_way"), {of_another_field, wall}),
            "the scheme one_way needs 'calcium' from ep to mech (ep declares no such output)");
  EXPECT_EQ(complaint(scheme("one_way"), {of_another_field, passive}), "");
}

TEST(Sequence, AParticipantWithoutAPartIsRefused) {
  EXPECT_NE(complaint(scheme("E1FSinf"), heart()).find("'mech' must be solved and committed"), std::string::npos);
}

TEST(Sequence, AnInputReadBeforeItIsWrittenIsRefused) {
  Sequence sequence = scheme("EFS1");
  auto &step = sequence.step;
  for (auto at = step.begin(); at != step.end(); ++at)
    if (at->field == "blood_force") {
      step.erase(at);
      break;
    }
  EXPECT_NE(complaint(sequence, heart()).find("'mech' is solved before it has received 'blood_force'"),
            std::string::npos);
}

TEST(Sequence, AFieldSentBeforeItIsComputedIsRefused) {
  Sequence sequence = scheme("EFS1");
  const auto calcium = std::find_if(sequence.step.begin(), sequence.step.end(),
                                    [](const Node &node) { return node.field == "calcium"; });
  std::iter_swap(calcium, calcium - 1);
  EXPECT_NE(complaint(sequence, heart()).find("'calcium' is sent before 'ep' has computed it"), std::string::npos);
}

TEST(Sequence, OnlyThoseWhoReceiveNothingMayRunAhead) {
  CouplingParameters ahead;
  ahead.lookahead = 1;
  for (const auto &name : {"EFS1", "adaptive", "E1FSinf", "one_way"}) {
    ahead.scheme = name;
    EXPECT_EQ(source_participants(make_sequence(ahead, 0.2e-3).step), std::set<std::string>{"ep"}) << name;
    EXPECT_TRUE(source_participants(scheme(name).step).empty()) << name << ": they take turns";
  }
  ahead.scheme = "EFS1";
  EXPECT_TRUE(source_participants(drop_absent(make_sequence(ahead, 0.2e-3), without(heart(), "ep")).step).empty());
  EXPECT_EQ(complaint(make_sequence(ahead, 0.2e-3), heart()), "");
  // Somebody whose scalar decides waits for the decision.
  const Node solve{Node::Kind::solve, "a", "", "", "", 1, {}};
  EXPECT_EQ(source_participants({solve}), std::set<std::string>{"a"});
  EXPECT_TRUE(source_participants({{Node::Kind::until, "a", "", "", "residual", 9, {solve}, 1e-3}}).empty());
}

TEST(Sequence, ElectrophysiologyWaitsUntilTheFluidIsAssembled) {
  using Kind = bus::Command::Kind;
  Routes routes;
  for (const auto &[node, iteration] : flatten(scheme("EFS1").step))
    if (node.kind == Node::Kind::transfer)
      routes[{node.participant, node.receiver, node.field}] = 0;
  std::map<std::string, std::vector<Kind>> kinds;
  for (const auto &[who, command] : commands(scheme("EFS1").step, routes, {7, 0, 1.4e-3, 2e-4})) {
    EXPECT_EQ(command.step.number, 7);
    kinds[who].push_back(command.kind);
  }
  EXPECT_EQ(kinds["ep"], (std::vector<Kind>{Kind::wait, Kind::solve, Kind::send, Kind::commit, Kind::report}));
  const auto &fluid = kinds["fluid"];
  const auto turn = std::find(fluid.begin(), fluid.end(), Kind::notify);
  ASSERT_NE(turn, fluid.end());
  EXPECT_EQ(*(turn - 1), Kind::prepare);
}

TEST(Sequence, WhoWorksLastPassesTheTurnBeforeItReports) {
  using Kind = bus::Command::Kind;
  const auto last_kinds_of = [](const std::string &participant) {
    std::vector<Kind> kinds;
    for (const auto &[who, command] :
         commands(drop_absent(scheme("one_way"), without(without(heart(), "ale"), "fluid")).step,
                  {{{"ep", "mech", "calcium"}, 0}}, {}))
      if (who == participant)
        kinds.push_back(command.kind);
    return std::vector<Kind>(kinds.end() - 3, kinds.end());
  };
  EXPECT_EQ(last_kinds_of("ep"), (std::vector<Kind>{Kind::commit, Kind::report, Kind::wait}));
  EXPECT_EQ(last_kinds_of("mech"), (std::vector<Kind>{Kind::commit, Kind::notify, Kind::report}));
  EXPECT_EQ(to_text(drop_absent(scheme("EFS1"), without(heart(), "ep"))).find("goes on"), std::string::npos);
}

TEST(Sequence, RunningAheadEndsWhereAllIsDroppedThatIsNotInTheState) {
  TimeParameters parameters;
  parameters.end = 50 * parameters.step;
  const TimeControl time(parameters);
  EXPECT_EQ(time.next_refresh(1), 20);
  EXPECT_EQ(time.next_refresh(20), 20);
  EXPECT_EQ(time.next_refresh(21), 40);
  EXPECT_EQ(time.next_refresh(41), 50);
}

TEST(Sequence, WorkAfterTheCommitIsRefused) {
  Sequence sequence = scheme("EFS1");
  sequence.step.push_back({Node::Kind::solve, "ep", "", "", "", 1, {}});
  EXPECT_NE(complaint(sequence, heart()).find("'ep' is busy after its commit"), std::string::npos);
}

TEST(Sequence, AnInputOfATaskIsReceivedBeforeThatTask) {
  auto participants = heart();
  participants[1].fields.push_back({"blood_velocity", "interface", "m/s", "correct", 3, false});
  participants[1].fields.push_back({"unit_pressure_force", "interface", "m^2", "correct", 3, false});
  participants[1].fields.push_back({"pressure_correction", "interface", "Pa", "n+1", 1, true});
  participants[1].tasks.push_back("correct");
  participants[3].fields.push_back({"blood_velocity", "interface", "m/s", "n+1", 3, true});
  participants[3].fields.push_back({"unit_pressure_force", "interface", "m^2", "n+1", 3, true});
  participants[3].fields.push_back({"pressure_correction", "interface", "Pa", "correct", 1, false});
  participants[3].tasks.insert(participants[3].tasks.end(), {"begin_correction", "correct"});
  EXPECT_EQ(complaint(scheme("EFS1"), participants), "") << "nobody is told to correct";
  Sequence corrected = scheme("EFS1-corrected");
  EXPECT_EQ(complaint(corrected, participants), "");
  const auto at = [&](const std::string &field) {
    return std::find_if(corrected.step.begin(), corrected.step.end(), [&](const Node &n) { return n.field == field; });
  };
  std::iter_swap(at("pressure_correction"), at("pressure_correction") + 1);
  EXPECT_NE(
      complaint(corrected, participants).find("'fluid' does 'correct' before it has received 'pressure_correction'"),
      std::string::npos)
      << complaint(corrected, participants);
}

TEST(Sequence, BloodAndWallAreToldOfTheInterfaceInPlainTerms) {
  SceneParameters scene;
  scene.participants = {{"mech", {}}, {"fluid", {}}};
  using interface::BloodSettings, interface::WallSettings;
  const auto blood = [&] { return interface::blood_settings(interface_settings(scene).at("fluid")); };
  const auto wall = [&] { return interface::wall_settings(interface_settings(scene).at("mech")); };
  EXPECT_EQ(blood().condition, BloodSettings::Condition::robin);
  EXPECT_EQ(blood().alpha, 5000);
  EXPECT_EQ(blood().alternation, interface::Alternation::steps);
  EXPECT_EQ(wall().load, WallSettings::Load::blood_force);
  scene.coupling.scheme = "adaptive";
  scene.coupling.iterations = 2;
  scene.coupling.automatic_alpha = true;
  EXPECT_EQ(blood().alpha, 0) << "until it is known";
  EXPECT_EQ(blood().alternation, interface::Alternation::iterations);
  EXPECT_EQ(wall().alternation, interface::Alternation::iterations);
  scene.coupling = {};
  scene.coupling.scheme = "one_way";
  EXPECT_EQ(blood().condition, BloodSettings::Condition::motion);
  EXPECT_EQ(wall().load, WallSettings::Load::initial_pressure);
  scene.coupling = {};
  scene.participants = {{"mech", {}}};
  EXPECT_EQ(wall().load, WallSettings::Load::initial_pressure) << "no blood takes part";
  scene.participants = {{"mech", {}}, {"circulation", {}}};
  EXPECT_EQ(wall().load, WallSettings::Load::cavity_pressure);
}

TEST(InterfaceSettings, WhatIsNotKnownIsRefused) {
  EXPECT_EQ(interface::blood_settings({}).condition, interface::BloodSettings::Condition::merged);
  EXPECT_THROW(interface::blood_settings({{"condition", "slip"}}), Failure);
  EXPECT_THROW(interface::wall_settings({{"load", "5000"}}), Failure);
}
