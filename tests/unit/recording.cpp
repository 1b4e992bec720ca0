#include "common/io/recording.h"

#include "common/bus/failure.h"

#include <cstdio>
#include <gtest/gtest.h>
#include <unistd.h>

namespace heartbus::io {
namespace {

const RecordedField field{"calcium", "uM", 2, {0., 0., 0., 0.1, 0.2, 0.3, -1., 1., 1e-9}};

class RecordingFile : public testing::Test {
 protected:
  void TearDown() override { std::remove(name_.c_str()); }
  const std::string name_ = testing::TempDir() + "heartbus_recording_" + std::to_string(getpid()) + ".h5";
};

TEST_F(RecordingFile, ReadsBackEveryBitThatWasWritten) {
  const std::vector<double> first{1, 2, 3, 4, 5, 1. / 3}, second{0, -1, 1e300, 1e-300, 5, 6};
  {
    RecordingWriter writer(name_, field);
    writer.append(1, 0.1, first);
    writer.append(2, 0.2, second);
  }
  const RecordingReader reader(name_);
  EXPECT_EQ(reader.field().name, "calcium");
  EXPECT_EQ(reader.field().unit, "uM");
  EXPECT_EQ(reader.field().components, 2u);
  EXPECT_EQ(reader.field().coordinates, field.coordinates);
  EXPECT_EQ(reader.steps(), (std::vector<int>{1, 2}));
  EXPECT_EQ(reader.times(), (std::vector<double>{0.1, 0.2}));
  EXPECT_EQ(reader.values(0), first);
  EXPECT_EQ(reader.values(1), second);
}

TEST_F(RecordingFile, IsLinearInTimeBetweenItsSteps) {
  {
    RecordingWriter writer(name_, field);
    writer.append(1, 0.2, {1, 1, 1, 1, 1, 1});
    writer.append(2, 0.4, {2, 4, 1, 0, -1, 1});
    writer.append(2, 0.4, {7, 7, 7, 7, 7, 7}); // a second transfer of the step
  }
  const RecordingReader reader(name_);
  EXPECT_EQ(reader.values_at(0.4 * (1 + 1e-12), 0), reader.values(1)); // to the bit
  EXPECT_EQ(reader.values_at(0.4, 1), reader.values(2));
  const std::vector<double> between = reader.values_at(0.25, 0), expected{1.25, 1.75, 1, 0.75, 0.5, 1};
  for (int i = 0; i < 6; ++i)
    EXPECT_NEAR(between[i], expected[i], 1e-14);
  EXPECT_EQ(reader.values_at(0.1, 0), reader.values(0)); // within the first step
  EXPECT_THROW(reader.values_at(0.25, 1), Failure);      // step 1 has no second transfer
  EXPECT_THROW(reader.values_at(0.41, 0), Failure);
  EXPECT_THROW(reader.values_at(-0.01, 0), Failure);
}

TEST_F(RecordingFile, CanBeEmpty) {
  { RecordingWriter writer(name_, field); }
  EXPECT_TRUE(RecordingReader(name_).steps().empty());
  EXPECT_THROW(RecordingReader(name_).values_at(0.1, 0), Failure);
}

TEST_F(RecordingFile, RefusesAWrongNumberOfValues) {
  RecordingWriter writer(name_, field);
  EXPECT_THROW(writer.append(1, 0.1, {1, 2, 3}), Failure);
}

TEST(Recording, AMissingFileIsAFailureThatNamesIt) {
  try {
    RecordingReader reader("/nowhere/at_all.h5");
    FAIL();
  } catch (const Failure &failure) {
    EXPECT_EQ(failure.code(), ExitCode::file);
    EXPECT_NE(std::string(failure.what()).find("/nowhere/at_all.h5"), std::string::npos);
  }
}

TEST(Recording, AFolderThatDoesNotExistIsAFailure) {
  EXPECT_THROW(RecordingWriter("/nowhere/at_all.h5", field), Failure);
}

} // namespace
} // namespace heartbus::io
