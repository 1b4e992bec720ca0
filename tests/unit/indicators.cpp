#include "coupler/indicators.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

using namespace heartbus::coupler;

namespace {

// A heartbeat in nine rows: phases 0 contraction, 1 ejection, 2 relaxation, 3 filling.
History heartbeat() {
  History history;
  history.columns = {{"step", "", {}},
                     {"time", "s", {}},
                     {"volume", "m^3", {}},
                     {"mean_pressure", "Pa", {}},
                     {"phase", "", {"isovolumetric contraction", "ejection", "isovolumetric relaxation", "filling"}},
                     {"activation_time", "s", {}}};
  const double mL[] = {120, 119, 117, 80, 60, 59, 58.5, 90, 110};
  const double mmHg[] = {10, 40, 70, 120, 90, 40, 9, 8, 10};
  const int phase[] = {0, 0, 0, 1, 1, 2, 2, 3, 3};
  for (int n = 0; n < 9; ++n)
    history.rows.push_back(
        {double(n), 0.1 * n, mL[n] * 1e-6, mmHg[n] * 133.322387415, double(phase[n]), n < 2 ? std::nan("") : 0.0875});
  return history;
}

} // namespace

TEST(Indicators, EjectionFractionAndPeakPressureFollowTheirDefinitions) {
  const auto result = indicators(heartbeat());
  EXPECT_NEAR(result["EF_percent"], 100 * (120 - 58.5) / 120, 1e-10);
  EXPECT_NEAR(result["EDV_mL"], 120, 1e-10);
  EXPECT_NEAR(result["ESV_mL"], 58.5, 1e-10);
  EXPECT_NEAR(result["p_max_mmHg"], 120, 1e-10);
  EXPECT_NEAR(result["activation_time_ms"], 87.5, 1e-10);
}

TEST(Indicators, LossesCompareTheEndsOfTheIsovolumetricPhases) {
  const auto result = indicators(heartbeat());
  EXPECT_NEAR(result["ILI_C_percent"], 100 * 3.0 / 120, 1e-10);
  EXPECT_NEAR(result["ILI_R_percent"], 100 * 1.5 / 60, 1e-10); // from the last volume of ejection
}

TEST(Indicators, PhasesShareTheirEnds) {
  const auto result = indicators(heartbeat());
  ASSERT_EQ(result["phases"].size(), 4u);
  EXPECT_EQ(result["phases"][1]["name"], "ejection");
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(result["phases"][i]["end"], result["phases"][i + 1]["start"]);
  EXPECT_EQ(result["phases"][0]["start"], 0.0);
}

TEST(Indicators, WhatTheRunHasNotReachedIsLeftOut) {
  History history = heartbeat();
  history.rows.resize(3); // still contracting
  auto result = indicators(history);
  for (const char *key : {"EF_percent", "ILI_C_percent", "ILI_R_percent"})
    EXPECT_FALSE(result.contains(key)) << key;
  EXPECT_TRUE(result.contains("EDV_mL"));
  history.columns[2].name = "other";
  history.rows.resize(1);
  result = indicators(history);
  EXPECT_FALSE(result.contains("EDV_mL"));
  EXPECT_FALSE(result.contains("activation_time_ms"));
}

TEST(Indicators, RelaxationBeforeEjectionDoesNotCount) {
  History history = heartbeat();
  history.rows[1][4] = 2;
  EXPECT_NEAR(indicators(history)["ILI_R_percent"], 100 * 1.5 / 60, 1e-10);
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
