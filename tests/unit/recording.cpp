#include "common/io/recording.h"

#include "common/base/failure.h"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <sstream>
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

TEST_F(RecordingFile, IsNotThereBeforeItsFirstValues) {
  { RecordingWriter writer(name_, field); }
  EXPECT_THROW(RecordingReader{name_}, Failure);
}

TEST_F(RecordingFile, RefusesAWrongNumberOfValues) {
  RecordingWriter writer(name_, field);
  EXPECT_THROW(writer.append(1, 0.1, {1, 2, 3}), Failure);
}

namespace {

/// A recording as somebody else might write it, a row a chunk, in the format whose headers have no checksums.
void write_table(hid_t file, const char *name, const std::vector<hsize_t> &size, const std::vector<double> &values) {
  const hid_t space = H5Screate_simple(size.size(), size.data(), nullptr);
  const hid_t chunks = H5Pcreate(H5P_DATASET_CREATE);
  std::vector<hsize_t> row = size;
  row[0] = 1;
  H5Pset_chunk(chunks, row.size(), row.data());
  const hid_t table = H5Dcreate2(file, name, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, chunks, H5P_DEFAULT);
  H5Pclose(chunks);
  H5Dwrite(table, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  const hid_t type = H5Tcopy(H5T_C_S1), one = H5Screate(H5S_SCALAR);
  for (const char *attribute : {"field", "unit"}) {
    const hid_t text = H5Acreate2(table, attribute, type, one, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(text, type, "a");
    H5Aclose(text);
  }
  H5Tclose(type);
  H5Sclose(one);
  H5Dclose(table);
  H5Sclose(space);
}

/// Two transfers at two points, but for what is given.
std::string complaint(const std::string &name, std::vector<hsize_t> size, std::vector<double> values,
                      std::vector<double> times = {0.1, 0.2}, std::vector<double> points = {0, 0, 0, 1, 0, 0}) {
  const hid_t file = H5Fcreate(name.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  write_table(file, "values", size, values);
  write_table(file, "step", {2}, {1, 2});
  write_table(file, "time", {times.size()}, times);
  write_table(file, "points", {points.size() / 3, 3}, points);
  H5Fclose(file);
  try {
    RecordingReader(name).values_at(0.2, 0);
  } catch (const Failure &failure) {
    return failure.what();
  }
  return "";
}

std::string bytes_of(const std::string &name) {
  std::stringstream bytes;
  bytes << std::ifstream(name, std::ios::binary).rdbuf();
  return bytes.str();
}

} // namespace

TEST_F(RecordingFile, WhatCannotBeIsRefused) {
  const double nan = std::nan(""), inf = INFINITY;
  EXPECT_EQ(complaint(name_, {2, 2, 1}, {1, 2, 3, 4}), "");
  EXPECT_NE(complaint(name_, {2, 1, 1}, {1, 2}).find("has values for 1 points, but 6 coordinates"), std::string::npos);
  EXPECT_NE(complaint(name_, {2, 3, 1}, {1, 2, 3, 4, 5, 6}).find("has values for 3 points"), std::string::npos);
  EXPECT_NE(complaint(name_, {4}, {1, 2, 3, 4}).find("no table of values"), std::string::npos);
  EXPECT_NE(complaint(name_, {2, 2, 1}, {1, 2, 3, nan}).find("holds nan at point 1, t = 0.2"), std::string::npos);
  EXPECT_NE(complaint(name_, {2, 2, 1}, {1, 2, -inf, 4}).find("holds -inf at point 0"), std::string::npos);
  EXPECT_NE(complaint(name_, {2, 2, 1}, {1, 2, 3, 4}, {0.2, 0.1}).find("do not ascend"), std::string::npos);
  EXPECT_NE(complaint(name_, {2, 2, 1}, {1, 2, 3, 4}, {0.1, nan}).find("do not ascend"), std::string::npos);
  EXPECT_NE(complaint(name_, {2, 2, 1}, {1, 2, 3, 4}, {0.1, 0.2}, {0, 0, 0, nan, 0, 0}).find("not finite"),
            std::string::npos);
  EXPECT_NE(complaint(name_, {1, 2, 1}, {1, 2}).find("ends at t = 0.1"), std::string::npos); // what is whole counts
}

/// As damage to its header would have it: HDF5 reads beyond the end of chunks that are smaller than it claims.
TEST_F(RecordingFile, ChunksThatAreSmallerThanTheyClaimAreRefused) {
  ASSERT_EQ(complaint(name_, {2, 2, 1}, {1, 2, 3, 4}), "");
  const std::string whole = bytes_of(name_);
  int n_tables = 0;
  for (std::size_t at = 0; (at = whole.find("\3\2", at)) != std::string::npos; ++at) { // layout 3, in chunks
    const std::size_t rank = whole[at + 2], first = at + 3 + 8; // behind the address of the tree of chunks
    if (rank < 2 || rank > 4 || whole.substr(first, 4) != std::string("\1\0\0\0", 4))
      continue;
    std::string damaged = whole;
    damaged[first] = 2; // rows a chunk
    std::ofstream(name_, std::ios::binary) << damaged;
    EXPECT_THROW(RecordingReader{name_}, Failure) << rank;
    ++n_tables;
  }
  EXPECT_EQ(n_tables, 4);
}

TEST_F(RecordingFile, NoDamagedByteChangesWhatIsRead) {
  const std::vector<double> first{1, 2, 3, 4, 5, 6}, second{7, 8, 9, 10, 11, 12};
  {
    RecordingWriter writer(name_, field);
    writer.append(1, 0.1, first);
    writer.append(2, 0.2, second);
  }
  const std::string whole = bytes_of(name_);
  int n_refused = 0;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    if (at > 16 && whole.find_first_not_of('\0', at - 16) > at + 16)
      continue; // zeros among zeros: hardly anything there is used
    for (const char bit : {2, 16}) {
      std::string damaged = whole;
      damaged[at] ^= bit;
      std::ofstream(name_, std::ios::binary) << damaged;
      try {
        const RecordingReader reader(name_);
        EXPECT_EQ(reader.values(0), first) << "byte " << at;
        EXPECT_EQ(reader.values(1), second) << "byte " << at;
        EXPECT_EQ(reader.field().name + reader.field().unit, field.name + field.unit) << "byte " << at;
        EXPECT_EQ(reader.field().coordinates, field.coordinates) << "byte " << at;
        EXPECT_EQ(reader.steps(), (std::vector<int>{1, 2})) << "byte " << at;
        EXPECT_EQ(reader.times(), (std::vector<double>{0.1, 0.2})) << "byte " << at;
      } catch (const Failure &) {
        ++n_refused;
      }
    }
  }
  std::cout << n_refused << " of " << 2 * whole.size() << " damages are noticed, the others are to what is not read\n";
  EXPECT_GT(n_refused, 2000);
}

TEST_F(RecordingFile, GoesOnFromWhatWasRecordedBefore) {
  const std::vector<double> row{1, 2, 3, 4, 5, 6};
  {
    RecordingWriter writer(name_, field);
    for (int step = 1; step <= 4; ++step)
      writer.append(step, 0.1 * step, row);
  }
  {
    RecordingWriter writer(name_, field);
    writer.keep(RecordingReader(name_), field, 0.2);
    EXPECT_EQ(RecordingReader(name_).steps().size(), 4u); // the old one, as long as nothing new comes
    writer.append(3, 0.3, {6, 5, 4, 3, 2, 1});
  }
  const RecordingReader reader(name_);
  EXPECT_EQ(reader.steps(), (std::vector<int>{1, 2, 3}));
  EXPECT_EQ(reader.values(1), row);
  EXPECT_EQ(reader.values(2)[0], 6);
  RecordedField moved = field;
  moved.coordinates[0] = 1;
  EXPECT_THROW(RecordingWriter(name_, moved).keep(reader, moved, 0.2), Failure);
  EXPECT_THROW(RecordingWriter(name_, field).keep(reader, field, 0.5), Failure); // there would be a gap
  EXPECT_EQ(RecordingReader(name_).steps().size(), 3u);
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
