#include "common/io/state_file.h"

#include "common/base/plausible.h"
#include "common/io/hdf5_object.h"
#include "common/mapping/conforming_map.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <sstream>

namespace heartbus::io {
namespace {

/// What saving and loading share: rows of a table go to rank 0 or come from there, rank after rank.
class StateFile : public State {
 public:
  StateFile(MPI_Comm communicator, const std::string &file_name) : communicator_(communicator), file_name_(file_name) {
    MPI_Comm_rank(communicator, &rank_);
    MPI_Comm_size(communicator, &size_);
  }

 protected:
  /// Runs on rank 0; its failure is everybody's, so that nobody is left waiting in a collective.
  void on_root(const std::function<void()> &action) const {
    int code = 0, length = 0;
    std::string message;
    if (rank_ == 0)
      try {
        action();
      } catch (const Failure &failure) {
        code = static_cast<int>(failure.code());
        message = failure.what();
        length = message.size();
      }
    MPI_Bcast(&code, 1, MPI_INT, 0, communicator_);
    if (code == 0)
      return;
    MPI_Bcast(&length, 1, MPI_INT, 0, communicator_);
    message.resize(length);
    MPI_Bcast(message.data(), length, MPI_CHAR, 0, communicator_);
    throw Failure(static_cast<ExitCode>(code), message);
  }

  void count_rows(int n_rows) {
    counts_.resize(size_);
    offsets_.resize(size_);
    MPI_Gather(&n_rows, 1, MPI_INT, counts_.data(), 1, MPI_INT, 0, communicator_);
    std::partial_sum(counts_.begin(), counts_.end() - 1, offsets_.begin() + 1);
    n_rows_ = n_rows;
    total_ = offsets_.back() + counts_.back(); // on rank 0
  }

  std::vector<double> gather(unsigned columns, const double *values) const {
    std::vector<double> all(std::size_t(total_) * columns);
    const Row row(columns);
    MPI_Gatherv(values, n_rows_, row.type, all.data(), counts_.data(), offsets_.data(), row.type, 0, communicator_);
    return all;
  }

  void scatter(unsigned columns, const std::vector<double> &all, double *values) const {
    const Row row(columns);
    MPI_Scatterv(all.data(), counts_.data(), offsets_.data(), row.type, values, n_rows_, row.type, 0, communicator_);
  }

  std::string in_file() const { return " in the state " + file_name_; }

  void require_plausible(const std::string &name, const std::vector<double> &values, unsigned columns) const {
    const auto odd =
        std::find_if(values.begin(), values.end(), [](double x) { return !(std::abs(x) <= largest_plausible); });
    if (odd == values.end())
      return;
    std::ostringstream message;
    message << name << in_file() << " is " << *odd << " at point " << (odd - values.begin()) / columns
            << ", where a finite number of a plausible size must be";
    throw Failure(ExitCode::not_finite, message.str());
  }

  /// A time that has not come may be infinite.
  void require_known(const std::string &name, double value) const {
    if (std::isnan(value))
      throw Failure(ExitCode::not_finite, name + in_file() + " is not a number");
  }

  MPI_Comm communicator_;
  const std::string file_name_;
  int rank_ = 0, size_ = 1, n_rows_ = 0, total_ = 0;
  std::vector<int> counts_, offsets_; ///< on rank 0: rows of each rank
  std::optional<Hdf5Object> file_;    ///< on rank 0
  std::string set_;                   ///< the point set of the fields that come

 private:
  struct Row {
    explicit Row(unsigned columns) {
      MPI_Type_contiguous(columns, MPI_DOUBLE, &type);
      MPI_Type_commit(&type);
    }
    ~Row() { MPI_Type_free(&type); }
    MPI_Datatype type;
  };
};

class Writer : public StateFile {
 public:
  Writer(MPI_Comm communicator, const std::string &file_name) : StateFile(communicator, file_name) {
    on_root([&] { file_.emplace(create_file(file_name, "create the state " + file_name + " (disk full?)")); });
  }

  void points(const std::string &name, const std::vector<double> &coordinates, double) override {
    count_rows(coordinates.size() / 3);
    set_ = name;
    on_root([&] {
      const Hdf5Object group(H5Gcreate2(*file_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose,
                             "create " + name + in_file() + " (disk full?)");
    });
    write("points", 3, coordinates.data(), true);
  }

  void field(const std::string &name, unsigned components, double *values) override {
    write(name, components, values, true);
  }

  void partial_field(const std::string &name, unsigned components, double *values) override {
    write(name, components, values, false);
  }

  void number(const std::string &name, double &value) override {
    on_root([&] {
      require_known(name, value);
      const Hdf5Object space(H5Screate(H5S_SCALAR), H5Sclose, "describe " + name);
      const Hdf5Object attribute(H5Acreate2(*file_, name.c_str(), H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT),
                                 H5Aclose, "create " + name + in_file() + " (disk full?)");
      require(H5Awrite(attribute, H5T_NATIVE_DOUBLE, &value), "write " + name + in_file() + " (disk full?)");
    });
  }

  void finish() {
    on_root([&] { file_->close("finish the state " + file_name_ + " (disk full?)"); });
  }

 private:
  void write(const std::string &name, unsigned columns, const double *values, bool all_finite) const {
    const std::vector<double> all = gather(columns, values);
    on_root([&] {
      if (all_finite)
        require_plausible(set_ + "/" + name, all, columns);
      const hsize_t extent[2] = {hsize_t(total_), columns};
      const std::string path = set_ + "/" + name;
      const Hdf5Object space(H5Screate_simple(2, extent, nullptr), H5Sclose, "describe " + path);
      const Hdf5Object table(
          H5Dcreate2(*file_, path.c_str(), H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Dclose,
          "create " + path + in_file() + " (disk full?)");
      require(H5Dwrite(table, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()),
              "write " + path + in_file() + " (disk full?)");
    });
  }
};

class Reader : public StateFile {
 public:
  Reader(MPI_Comm communicator, const std::string &file_name) : StateFile(communicator, file_name) {
    on_root([&] {
      file_.emplace(open_file(file_name, "open the state " + file_name + ": does this checkpoint hold this physics?"));
    });
  }

  void points(const std::string &name, const std::vector<double> &coordinates, double spacing) override {
    count_rows(coordinates.size() / 3);
    set_ = name;
    const std::vector<double> here = gather(3, coordinates.data());
    on_root([&] {
      const std::vector<double> saved = read("points", 3);
      require_plausible(name + "/points", saved, 3);
      source_ =
          mapping::match_points({"the state's " + name, {saved}, spacing}, {"this mesh's " + name, {here}, spacing});
      if (saved.size() != here.size())
        throw Failure(ExitCode::map, std::to_string(saved.size() / 3) + " points of " + name + in_file() +
                                         ", but the mesh of this run has " + std::to_string(here.size() / 3) +
                                         " of them: a state fits only the mesh it was saved on");
    });
  }

  void field(const std::string &name, unsigned components, double *values) override {
    load(name, components, values, true);
  }

  void partial_field(const std::string &name, unsigned components, double *values) override {
    load(name, components, values, false);
  }

  void number(const std::string &name, double &value) override {
    on_root([&] {
      const Hdf5Object attribute(H5Aopen(*file_, name.c_str(), H5P_DEFAULT), H5Aclose, "find " + name + in_file());
      require(H5Aread(attribute, H5T_NATIVE_DOUBLE, &value), "read " + name + in_file());
      require_known(name, value);
    });
    MPI_Bcast(&value, 1, MPI_DOUBLE, 0, communicator_);
  }

 private:
  void load(const std::string &name, unsigned components, double *values, bool all_finite) {
    std::vector<double> sorted;
    on_root([&] {
      const std::vector<double> saved = read(name, components);
      if (all_finite)
        require_plausible(set_ + "/" + name, saved, components);
      for (const std::size_t row : source_)
        sorted.insert(sorted.end(), &saved[row * components], &saved[row * components] + components);
    });
    scatter(components, sorted, values);
  }

  std::vector<double> read(const std::string &name, unsigned columns) const {
    const std::string path = set_ + "/" + name;
    const Hdf5Object table(H5Dopen2(*file_, path.c_str(), H5P_DEFAULT), H5Dclose,
                           "find " + path + in_file() + ": does the scene ask for another model?");
    const Hdf5Object space(H5Dget_space(table), H5Sclose, "read the extent of " + path);
    hsize_t extent[2] = {0, 0};
    if (H5Sget_simple_extent_ndims(space) != 2 || H5Sget_simple_extent_dims(space, extent, nullptr) != 2 ||
        extent[1] != columns || (!source_.empty() && name != "points" && extent[0] != source_.size()))
      throw Failure(ExitCode::file, path + in_file() + " holds " + std::to_string(extent[0]) + " x " +
                                        std::to_string(extent[1]) + " values; this run's model has " +
                                        std::to_string(columns) + " at each of " + std::to_string(total_) + " points");
    std::vector<double> values(extent[0] * columns);
    require(H5Dread(table, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
            "read " + path + in_file());
    return values;
  }

  std::vector<std::size_t> source_; ///< on rank 0: the row of the file for each row of all ranks
};

} // namespace

void save_state(MPI_Comm communicator, const std::string &file_name, const std::function<void(State &)> &visit) {
  Writer writer(communicator, file_name);
  visit(writer);
  writer.finish();
}

void load_state(MPI_Comm communicator, const std::string &file_name, const std::function<void(State &)> &visit) {
  Reader reader(communicator, file_name);
  visit(reader);
}

} // namespace heartbus::io
