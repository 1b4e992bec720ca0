#include "fluid_solver/models/valves.h"

#include <gtest/gtest.h>

using heartbus::fluid::Valves;

namespace {

struct Script : testing::Test {
  heartbus::fluid::ValveRules rules;
  Valves valves{rules};
  const double flow = 1e-4; // m^3/s

  void expect_open(bool mitral, bool aortic) {
    EXPECT_EQ(valves.mitral_open(), mitral);
    EXPECT_EQ(valves.aortic_open(), aortic);
  }
};

TEST_F(Script, OfACavityThatIsMovedTheyFollowItsVolumeAndRestWithIt) {
  for (const auto &[rate, mitral] : {std::pair{-1e-14, true},
                                     {1e-14, true},
                                     {-1e-4, false},
                                     {1e-14, false},
                                     {-1e-14, false},
                                     {1e-4, true},
                                     {-1e-14, true}}) {
    valves.follow(rate);
    expect_open(mitral, !mitral);
  }
}

TEST_F(Script, RunsThroughTheFivePhasesOfABeat) {
  EXPECT_EQ(valves.phase(), Valves::isovolumetric_contraction);
  EXPECT_FALSE(valves.update(0.08, 8900, {8900, 0}, {8900, 0}));
  EXPECT_TRUE(valves.update(0.09, 9011, {9011, 0}, {9011, 0}));
  expect_open(false, true);
  EXPECT_FALSE(valves.update(0.20, 15000, {15000, 0}, {15000, 4 * flow}));
  EXPECT_TRUE(valves.update(0.35, 9500, {9500, 0}, {9500, -1e-9}));
  EXPECT_EQ(valves.phase(), Valves::isovolumetric_relaxation);
  expect_open(false, false);
  EXPECT_FALSE(valves.update(0.40, 5000, {5000, 0}, {5000, 0}));
  EXPECT_TRUE(valves.update(0.47, 1320, {1320, 0}, {1320, 0}));
  EXPECT_EQ(valves.phase(), Valves::filling);
  expect_open(true, false);
  EXPECT_FALSE(valves.update(0.60, 1200, {1200, 2 * flow}, {1200, 0}));
  EXPECT_TRUE(valves.update(0.70, 1340, {1340, 0}, {1340, 0}));
  EXPECT_EQ(valves.phase(), Valves::diastasis);
  expect_open(false, false);
  EXPECT_TRUE(valves.update(0.90, 9100, {9100, 0}, {9100, 0}));
  EXPECT_EQ(valves.phase(), Valves::ejection);
}

TEST_F(Script, ContractsAgainInTheNextBeat) {
  valves.update(0.09, 9011, {9011, 0}, {9011, 0});
  valves.update(0.20, 12000, {12000, 0}, {12000, 1e-4});
  valves.update(0.35, 9500, {9500, 0}, {9500, -1e-9});
  valves.update(0.47, 1320, {1320, 0}, {1320, 0});
  valves.update(0.60, 1200, {1200, 1e-4}, {1200, 0});
  valves.update(0.82, 1340, {1340, 0}, {1340, 0});
  ASSERT_EQ(valves.phase(), Valves::diastasis);
  EXPECT_FALSE(valves.update(0.83, rules.mitral_pressure + 9.9, {rules.mitral_pressure + 9.9, 0},
                             {rules.mitral_pressure + 9.9, 0}));
  EXPECT_EQ(valves.phase(), Valves::diastasis);
  EXPECT_FALSE(valves.update(0.84, rules.mitral_pressure + 10.1, {rules.mitral_pressure + 10.1, 0},
                             {rules.mitral_pressure + 10.1, 0})); // no valve switches
  EXPECT_EQ(valves.phase(), Valves::isovolumetric_contraction);
  expect_open(false, false);
  EXPECT_TRUE(valves.update(0.8401, rules.mitral_pressure - 10.1, {rules.mitral_pressure - 10.1, 0},
                            {rules.mitral_pressure - 10.1, 0})); // nor does that keep one from switching
  EXPECT_EQ(valves.phase(), Valves::filling);
}

TEST_F(Script, OpensOnlyBeyondTheHysteresis) {
  EXPECT_FALSE(valves.update(0.1, rules.aortic_pressure + 9.9, {rules.aortic_pressure + 9.9, 0},
                             {rules.aortic_pressure + 9.9, 0}));
  EXPECT_FALSE(valves.update(0.1, rules.mitral_pressure - 9.9, {rules.mitral_pressure - 9.9, 0},
                             {rules.mitral_pressure - 9.9, 0}));
  EXPECT_TRUE(valves.update(0.1, rules.mitral_pressure - 10.1, {rules.mitral_pressure - 10.1, 0},
                            {rules.mitral_pressure - 10.1, 0}));
}

TEST_F(Script, WithoutBlankingSwitchesAsSoonAsItsRuleSays) {
  EXPECT_EQ(rules.blanking, 0) << "as in the paper";
  ASSERT_TRUE(valves.update(0.1, 9011, {9011, 0}, {9011, 0}));
  EXPECT_FALSE(valves.update(0.1002, 8950, {8950, 0}, {8950, 1e-9})) << "it flows outwards";
  EXPECT_TRUE(valves.update(0.1004, 8950, {8950, 0}, {8950, 0})) << "it does not";
}

TEST_F(Script, OpensWhenBothTheCavityAndTheOrificeAreBeyondTheOtherSide) {
  EXPECT_FALSE(valves.update(0.1, 9100, {9100, 0}, {9009, 0})) << "the blood at the valve would run back";
  EXPECT_FALSE(valves.update(0.1002, 8990, {8990, 0}, {9040, 0})) << "a peak at the orifice";
  EXPECT_TRUE(valves.update(0.1004, 9100, {9100, 0}, {9011, 0}));
  EXPECT_TRUE(valves.update(0.3, 8000, {8000, 0}, {8000, -1e-9}));
  EXPECT_FALSE(valves.update(0.5, 1300, {1330, 0}, {1300, 0}));
  EXPECT_FALSE(valves.update(0.5002, 1330, {1300, 0}, {1330, 0}));
  EXPECT_TRUE(valves.update(0.5004, 1320, {1315, 0}, {1325, 0}));
}

TEST_F(Script, DoesNotSwitchTwiceWithinTheBlankingTime) {
  rules.blanking = 5e-3;
  Valves valves(rules);
  ASSERT_TRUE(valves.update(0.1, 9011, {9011, 0}, {9011, 0}));
  EXPECT_FALSE(valves.update(0.1049, 8000, {8000, 0}, {8000, -flow}));
  EXPECT_TRUE(valves.update(0.1051, 8000, {8000, 0}, {8000, -flow}));
}

TEST_F(Script, SwitchesAtMostOnceAStep) {
  ASSERT_TRUE(valves.update(0.1, 9011, {9011, 0}, {9011, 0}));
  ASSERT_TRUE(valves.update(0.2, 1000, {1000, 0}, {1000, -flow})); // closes, and does not open the other valve at once
  expect_open(false, false);
}

TEST_F(Script, KeepsTheMitralValveClosedAtTheStart) {
  EXPECT_FALSE(valves.update(0.0199, 1300, {1300, 0}, {1300, 0}));
  expect_open(false, false);
  EXPECT_TRUE(valves.update(0.0201, 1300, {1300, 0}, {1300, 0}));
}

TEST_F(Script, SaysWhichRuleFired) {
  EXPECT_NE(valves.update(0.1, 9011, {9011, 0}, {9011, 0})->find("aortic valve opens: pressure 9011 Pa"),
            std::string::npos);
  EXPECT_NE(valves.update(0.2, 8999, {8999, 0}, {8999, -flow})->find("aortic valve closes: its flow -100 mL/s"),
            std::string::npos);
}

TEST_F(Script, HasANameForEachPhase) { EXPECT_EQ(Valves::phase_names().size(), Valves::diastasis + 1u); }

} // namespace
