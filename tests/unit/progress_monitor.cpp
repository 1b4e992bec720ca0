#include "common/bus/progress_monitor.h"

#include "common/bus/waiting.h"

#include <gtest/gtest.h>
#include <thread>

using namespace heartbus::bus;

namespace {

using Kind = Command::Kind;

const std::vector<RouteName> routes{{"ep", "mech", "calcium"}};
const Step step{3, 0, 6e-4, 2e-4};

} // namespace

TEST(ProgressMonitor, FollowsWhoWaitsForWhomToTheOneToBlame) {
  ProgressMonitor crew;
  crew.sent("mech", {{Kind::receive, "", 0, step}});
  crew.sent("ep", {{Kind::wait, "fluid", -1, step}, {Kind::solve, "", -1, step}});
  crew.sent("fluid", {{Kind::prepare, "", -1, step}});
  EXPECT_EQ(crew.why_late("mech", routes),
            "; mech itself waits for 'calcium' from ep; ep itself waits for its turn from fluid; fluid is busy with "
            "prepare, step 3, iteration 0");
  crew.executed_one("ep");
  EXPECT_EQ(crew.why_late("mech", routes),
            "; mech itself waits for 'calcium' from ep; ep is busy with solve, step 3, iteration 0");
  crew.executed_one("ep");
  EXPECT_TRUE(crew.idle("ep"));
  EXPECT_EQ(crew.why_late("ep", routes), "; ep has not been ordered to do anything more");
}

TEST(ProgressMonitor, RecognisesThoseWhoWaitForEachOther) {
  ProgressMonitor crew;
  crew.sent("mech", {{Kind::receive, "", 0, step}});
  crew.sent("ep", {{Kind::wait, "mech", -1, step}});
  EXPECT_EQ(crew.why_late("ep", routes),
            "; ep itself waits for its turn from mech; mech itself waits for 'calcium' from ep; ep itself waits for "
            "its turn from mech: they wait for each other");
}

TEST(ProgressMonitor, BlamesWhoDoesNotTakeWhatHasBeenSent) {
  ProgressMonitor crew;
  const std::vector<RouteName> both{{"ep", "mech", "calcium"}, {"mech", "ep", "stretch"}};
  crew.sent("ep", {{Kind::send, "", 0, step}, {Kind::receive, "", 1, step}});
  crew.sent("mech", {{Kind::receive, "", 0, step}, {Kind::send, "", 1, step}});
  crew.executed_one("ep");
  const std::string chain = "; ep itself waits for 'stretch' from mech; ";
  EXPECT_EQ(crew.why_late("ep", both), chain + "mech does not take 'calcium', which ep has sent: its rank 0 is stopped "
                                               "or stuck");
  EXPECT_EQ(crew.why_late("ep", both, "mech"), chain + "rank 0 of ep has sent 'calcium' to mech: its ranks that are "
                                                       "missing are stopped or stuck");
  EXPECT_EQ(crew.step(), 3);
  crew.executed_one("mech");
  EXPECT_EQ(crew.why_late("ep", both), chain + "mech is busy with send, step 3, iteration 0");
}

TEST(ProgressMonitor, BlamesWhoDoesNotTakeItsTurn) {
  ProgressMonitor crew;
  crew.sent("mech", {{Kind::notify, "ep", -1, step}, {Kind::receive, "", 0, step}});
  crew.sent("ep", {{Kind::wait, "mech", -1, step}});
  crew.executed_one("mech");
  EXPECT_EQ(crew.why_late("ep", routes), "; ep does not take its turn, which mech has sent: its rank 0 is stopped or "
                                         "stuck");
}

TEST(ProgressMonitor, IsLateWithACommandButNotWithAWait) {
  ProgressMonitor crew;
  crew.sent("mech", {{Kind::receive, "", 0, step}, {Kind::solve, "", -1, step}});
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_NO_THROW(crew.watch(0.01, routes)) << "it waits for others";
  crew.executed_one("mech");
  EXPECT_NO_THROW(crew.watch(0.01, routes)) << "it has only just begun to solve";
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_THROW(crew.watch(0.01, routes), Late);
}
