#include "coupler/indicators.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

using namespace heartbus::coupler;

namespace {

constexpr double mmHg = 133.322387415, period = 0.8;
enum { contraction, ejection, relaxation, filling, diastasis };

History empty_history() {
  History history;
  history.columns = {
      {"step", "", {}},
      {"time", "s", {}},
      {"volume", "m^3", {}},
      {"mean_pressure", "Pa", {}},
      {"phase", "", {"isovolumetric contraction", "ejection", "isovolumetric relaxation", "filling", "diastasis"}},
      {"activation_time", "s", {}}};
  return history;
}

/// One row after the others, a tenth of a second later.
void add(History &history, double mL, double pressure, double phase, double activation = 0.0875) {
  const double n = history.rows.size();
  history.rows.push_back({n, 0.1 * n, mL * 1e-6, pressure * mmHg, phase, activation});
}

// The first beat, in nine rows.
History heartbeat() {
  History history = empty_history();
  const double volume[] = {120, 119, 117, 80, 60, 59, 58.5, 90, 110}, pressure[] = {10, 40, 70, 120, 90, 40, 9, 8, 10};
  const int phase[] = {0, 0, 0, 1, 1, 2, 2, 3, 3};
  for (int n = 0; n < 9; ++n)
    add(history, volume[n], pressure[n], phase[n], n < 2 ? std::nan("") : 0.0875);
  return history;
}

// The second beat: filling goes on into it, both valves are closed from 115 mL on, and it ejects to 55 mL.
void add_second_beat(History &history) {
  const double volume[] = {115, 114, 112, 75, 55, 54, 80, 105}, pressure[] = {11, 50, 72, 118, 80, 9, 8, 10};
  const int phase[] = {filling, diastasis, contraction, ejection, ejection, relaxation, filling, filling};
  for (int n = 0; n < 8; ++n)
    add(history, volume[n], pressure[n], phase[n], n < 2 ? std::nan("") : 0.095);
}

void add_third_beat(History &history) {
  const double volume[] = {114, 113.5, 111, 74, 56, 55, 79, 106}, pressure[] = {11, 50, 72, 117, 80, 9, 8, 10};
  const int phase[] = {filling, contraction, contraction, ejection, ejection, relaxation, filling, filling};
  for (int n = 0; n < 8; ++n)
    add(history, volume[n], pressure[n], phase[n]);
}

void cut(History &history, std::size_t rows) { history.rows.resize(rows); }

} // namespace

TEST(Indicators, EjectionFractionAndPeakPressureFollowTheirDefinitions) {
  const auto result = indicators(heartbeat(), period);
  EXPECT_NEAR(result["EF_percent"], 100 * (120 - 58.5) / 120, 1e-10);
  EXPECT_NEAR(result["EDV_mL"], 120, 1e-10);
  EXPECT_NEAR(result["ESV_mL"], 58.5, 1e-10);
  EXPECT_NEAR(result["p_max_mmHg"], 120, 1e-10);
  EXPECT_NEAR(result["activation_time_ms"], 87.5, 1e-10);
}

TEST(Indicators, LossesCompareTheEndsOfTheIsovolumetricPhases) {
  const auto result = indicators(heartbeat(), period);
  EXPECT_NEAR(result["ILI_C_percent"], 100 * 3.0 / 120, 1e-10);
  EXPECT_NEAR(result["ILI_R_percent"], 100 * 1.5 / 60, 1e-10); // from the last volume of ejection
}

TEST(Indicators, ValvesSwitchWhenTheirPhasesBegin) {
  History history = heartbeat();
  add_second_beat(history);
  const auto beats = indicators(history, period)["beats"];
  EXPECT_FALSE(beats[0].contains("mitral_closes_ms")); // closed from the start
  EXPECT_NEAR(beats[0]["aortic_opens_ms"], 200, 1e-9);
  EXPECT_NEAR(beats[0]["aortic_closes_ms"], 400, 1e-9);
  EXPECT_NEAR(beats[0]["mitral_opens_ms"], 600, 1e-9);
  EXPECT_NEAR(beats[1]["mitral_closes_ms"], 100, 1e-9); // since the beat's beginning
  EXPECT_NEAR(beats[1]["aortic_opens_ms"], 300, 1e-9);
  EXPECT_NEAR(beats[1]["aortic_closes_ms"], 500, 1e-9);
  EXPECT_NEAR(beats[1]["mitral_opens_ms"], 600, 1e-9);
}

TEST(Indicators, PhasesShareTheirEnds) {
  const auto result = indicators(heartbeat(), period);
  ASSERT_EQ(result["phases"].size(), 4u);
  EXPECT_EQ(result["phases"][1]["name"], "ejection");
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(result["phases"][i]["end"], result["phases"][i + 1]["start"]);
  EXPECT_EQ(result["phases"][0]["start"], 0.0);
}

TEST(Indicators, EachBeatHasItsOwn) {
  History history = heartbeat();
  add_second_beat(history);
  const auto result = indicators(history, period);
  ASSERT_EQ(result["beats"].size(), 2u);
  const auto &first = result["beats"][0], &second = result["beats"][1];
  EXPECT_NEAR(first["EF_percent"], 100 * (120 - 58.5) / 120, 1e-10);
  EXPECT_NEAR(second["EDV_mL"], 115, 1e-10); // filled in this beat
  EXPECT_NEAR(second["ESV_mL"], 54, 1e-10);
  EXPECT_NEAR(second["EF_percent"], 100 * (115 - 54.) / 115, 1e-10);
  EXPECT_NEAR(second["p_max_mmHg"], 118, 1e-10);
  EXPECT_NEAR(second["ILI_C_percent"], 100 * 3. / 115,
              1e-10); // from the closing of the mitral valve, diastasis included
  EXPECT_NEAR(second["ILI_R_percent"], 100 * 1. / 55, 1e-10);
  EXPECT_NEAR(second["activation_time_ms"], 95, 1e-10);
  EXPECT_EQ(second["phases"][0]["name"], "filling");
  EXPECT_EQ(second["phases"][0]["start"], first["phases"].back()["end"]);
  for (const auto &[key, value] : second.items())
    if (key != "start" && key != "end" && key != "complete") {
      EXPECT_EQ(result[key], value) << "at the top, the last complete beat's: " << key;
    }
}

TEST(Indicators, AnIncompleteLastBeatDoesNotCountAtTheTop) {
  History history = heartbeat();
  add_second_beat(history);
  add_third_beat(history);
  EXPECT_EQ(indicators(history, period)["beats"].size(), 3u);
  cut(history, 9 + 8 + 4); // the third is ejecting
  const auto result = indicators(history, period), third = result["beats"][2];
  EXPECT_EQ(result["beat"], 2);
  EXPECT_FALSE(third["complete"]);
  EXPECT_NEAR(third["EDV_mL"], 114, 1e-10);
  EXPECT_NEAR(third["ILI_C_percent"], 100 * 3. / 114, 1e-10);
  for (const char *key : {"EF_percent", "ESV_mL", "ILI_R_percent", "change_percent", "mitral_opens_ms"})
    EXPECT_FALSE(third.contains(key)) << key;
}

TEST(Indicators, ChangesFromBeatToBeatTellWhetherTheyArePeriodic) {
  History history = heartbeat();
  EXPECT_FALSE(are_below(last_changes(history, period), 1));
  add_second_beat(history);
  add_third_beat(history);
  const auto changes = last_changes(history, period);
  EXPECT_NEAR(changes["EDV"], 100 * 1. / 115, 1e-10);
  EXPECT_NEAR(changes["ESV"], 100 * 1. / 54, 1e-10);
  EXPECT_NEAR(changes["p_max"], 100 * 1. / 118, 1e-10);
  EXPECT_TRUE(are_below(changes, 0.02));
  EXPECT_FALSE(are_below(changes, 0.015)); // ESV changes by 1.85 %
  cut(history, 9 + 8 + 7);                 // an incomplete beat is not compared
  EXPECT_NEAR(last_changes(history, period)["ESV"], 100 * 4.5 / 58.5, 1e-10);
}

TEST(Indicators, AValveThatChattersIsOpenFromFirstToLast) {
  History history = empty_history();
  const int phase[] = {0, ejection, relaxation, ejection, relaxation, filling, diastasis, filling, filling};
  const double volume[] = {120, 118, 117, 60, 59, 70, 71, 90, 100};
  for (int n = 0; n < 9; ++n)
    add(history, volume[n], 50, phase[n]);
  const auto result = indicators(history, period);
  EXPECT_NEAR(result["aortic_opens_ms"], 0, 1e-9);
  EXPECT_NEAR(result["aortic_closes_ms"], 300, 1e-9);
  EXPECT_NEAR(result["mitral_opens_ms"], 400, 1e-9);
  EXPECT_NEAR(result["ILI_R_percent"], 100 * 1. / 60, 1e-10);
  EXPECT_NEAR(result["ESV_mL"], 59, 1e-10);
}

TEST(Indicators, DiastasisThatFillsAgainIsNoContraction) {
  History history = heartbeat();
  const double volume[] = {112, 112, 116, 115, 70, 56, 55, 90};
  const int phase[] = {diastasis, contraction, filling, diastasis, ejection, ejection, relaxation, filling};
  for (int n = 0; n < 8; ++n)
    add(history, volume[n], 50, phase[n]);
  const auto beat = indicators(history, period)["beats"][1];
  EXPECT_NEAR(beat["mitral_closes_ms"], 300, 1e-9); // the last time
  EXPECT_NEAR(beat["ILI_C_percent"], 100 * 1. / 116, 1e-10);
  EXPECT_NEAR(beat["EDV_mL"], 116, 1e-10);
}

TEST(Indicators, WithoutValvesVolumesAreTheExtremeOnes) {
  History history = heartbeat();
  history.columns[4] = {"other", "", {}};
  const auto result = indicators(history, period);
  EXPECT_NEAR(result["V_max_mL"], 120, 1e-10);
  EXPECT_NEAR(result["V_min_mL"], 58.5, 1e-10);
  for (const char *key :
       {"EF_percent", "EDV_mL", "ESV_mL", "ILI_C_percent", "ILI_R_percent", "phases", "aortic_opens_ms"})
    EXPECT_FALSE(result.contains(key)) << key;
}

TEST(Indicators, TheWallsWorstIsOfTheBeat) {
  History history = heartbeat();
  add_second_beat(history);
  for (const char *name : {"min_J", "wall_volume", "clamped_share", "activated_share"})
    history.columns.push_back({name, "1", {}});
  for (auto &row : history.rows)
    row.insert(row.end(), {row[0] == 4 ? 0.4 : 0.9, row[0] == 5 ? 0.88 : 0.99, row[0] == 12 ? 0.7 : 0.1, 0.75});
  history.rows.back()[5] = std::nan(""); // some node was not activated in the second beat
  const auto beats = indicators(history, period)["beats"];
  EXPECT_EQ(beats[0]["J_min"], 0.4);
  EXPECT_EQ(beats[1]["J_min"], 0.9);
  EXPECT_NEAR(beats[0]["wall_volume_min_percent"], 88, 1e-10);
  EXPECT_NEAR(beats[1]["wall_volume_min_percent"], 99, 1e-10);
  EXPECT_NEAR(beats[0]["clamped_share_max_percent"], 10, 1e-10);
  EXPECT_NEAR(beats[1]["clamped_share_max_percent"], 70, 1e-10);
  EXPECT_FALSE(beats[0].contains("activated_percent"));
  EXPECT_FALSE(beats[1].contains("activation_time_ms"));
  EXPECT_NEAR(beats[1]["activated_percent"], 75, 1e-10);
}

TEST(Indicators, WhatTheRunHasNotReachedIsLeftOut) {
  History history = heartbeat();
  cut(history, 3); // still contracting
  auto result = indicators(history, period);
  for (const char *key : {"EF_percent", "ESV_mL", "ILI_C_percent", "ILI_R_percent"})
    EXPECT_FALSE(result.contains(key)) << key;
  EXPECT_TRUE(result.contains("EDV_mL"));
  history.columns[2].name = "other";
  cut(history, 1);
  result = indicators(history, period);
  EXPECT_FALSE(result.contains("EDV_mL"));
  EXPECT_FALSE(result.contains("activation_time_ms"));
}

TEST(Indicators, RelaxationBeforeEjectionDoesNotCount) {
  History history = heartbeat();
  history.rows[1][4] = relaxation;
  EXPECT_NEAR(indicators(history, period)["ILI_R_percent"], 100 * 1.5 / 60, 1e-10);
}

TEST(History, TheFileKeepsEveryBitAndNamesStatesAndUnits) {
  const auto file = std::filesystem::temp_directory_path() / ("heartbus_history_" + std::to_string(getpid()) + ".csv");
  History history = heartbeat();
  history.rows.clear();
  HistoryFile csv(file.string(), history);
  history.rows.push_back({0, 0, 0.00012, 1.0 / 3, 0, std::nan("")});
  csv.append(history);
  std::ifstream in(file);
  std::string header, row;
  std::getline(in, header);
  std::getline(in, row);
  std::filesystem::remove(file);
  EXPECT_EQ(header, "step,time [s],volume [m^3],mean_pressure [Pa],phase,activation_time [s]");
  EXPECT_EQ(row, "0,0,0.00012,0.3333333333333333,isovolumetric contraction,nan");
}

TEST(Indicators, OfAWallThatIsOnlyLoadedAreOfTheWholeRun) {
  History history;
  history.columns = {{"step", "", {}}, {"time", "s", {}}, {"min_J", "1", {}}};
  for (int n = 0; n < 12; ++n) // longer than a period
    history.rows.push_back({double(n), 0.1 * n, 1 - 0.01 * n});
  const auto found = indicators(history, period);
  ASSERT_EQ(found["beats"].size(), 1u);
  EXPECT_FALSE(found["beats"][0].contains("beat"));
  EXPECT_TRUE(found["beats"][0]["complete"]);
  EXPECT_NEAR(found["J_min"], 0.89, 1e-12);
}
