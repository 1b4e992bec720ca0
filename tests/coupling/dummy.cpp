// A participant of the simplest kind. It owns a slice of a row of points (every rank a part, in an order of its own),
// sends "signal" and receives it; the first line of the scene says what is done wrong, and by whom: "# nan a".
#include "common/base/failure.h"
#include "common/bus/participant.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <limits>
#include <sstream>
#include <thread>

namespace {

using namespace heartbus;

constexpr int n_points = 30;
constexpr double spacing = 0.001;

class Dummy : public bus::Solver {
 public:
  Dummy(const bus::Participant &participant) : communicator_(participant.communicator()), name_(participant.name()) {
    std::istringstream scene(participant.scene_text());
    std::string comment, who;
    scene >> comment >> mischief_ >> who;
    MPI_Comm_rank(communicator_, &rank_);
    MPI_Comm_size(communicator_, &size_);
    if (who != name_ && who != "all")
      mischief_ = "none";
    if (mischief_ == "fail_early" && rank_ == 0)
      throw Failure(ExitCode::file, "cannot read the mesh");
  }

  ~Dummy() override { std::printf("%s has closed its files\n", name_.c_str()); }

  void declare(bus::Declaration &bus) override {
    // Both participants share the points, in different orders: "b" counts backwards.
    const double scale = mischief_ == "millimetres" ? 1000 : 1;
    for (int i = 0; i < n_points; ++i)
      if (i % size_ == rank_) {
        const int p = name_ == "b" ? n_points - 1 - i : i;
        const double shift = mischief_ == "shifted" && p == 17 ? 0.3 * spacing : 0;
        const double point[3] = {scale * (p * spacing + shift), scale * 0.01 * std::sin(p), scale * 0.002};
        points_.insert(points_.end(), point, point + 3);
      }
    signal_.resize(points_.size() / 3 * 2);
    bus.point_set("points", points_, scale * spacing);
    bus.output("signal", "points", 2, mischief_ == "other_unit" ? "kPa" : "Pa", "n+1", signal_);
    bus.input("signal", "points", 2, "Pa", received_);
    bus.task("check", [this](const bus::Step &step) { check(step); });
    bus.scalar("prepared", "1", [this] { return prepared_; });
    bus.state("phase", {"filling", "ejection"}, [this] { return committed_ % 2; });
    const double unknown = std::numeric_limits<double>::quiet_NaN();
    bus.scalar(
        "lowest", "1", [this] { return -rank_; }, bus::Combine::min);
    bus.scalar(
        "highest", "1", [this] { return 10 + rank_; }, bus::Combine::max);
    bus.scalar(
        "unknown", "1", [this, unknown] { return rank_ == 0 ? 1. : unknown; }, bus::Combine::max);
    bus.scalar(
        "ranks", "1", [] { return 1; }, bus::Combine::sum);
  }

  void prepare_step(const bus::Step &) override { ++prepared_; }

  void solve_step(const bus::Step &step) override {
    for (std::size_t i = 0; i < points_.size() / 3; ++i) {
      signal_[2 * i] = points_[3 * i] + step.number;
      signal_[2 * i + 1] = points_[3 * i + 1] + step.iteration;
    }
    if (mischief_ == "chatter")
      chatter();
    if (rank_ == size_ - 1)
      misbehave();
    else if (mischief_ == "fail_in_collective")
      MPI_Barrier(communicator_); // nobody comes
    if (mischief_ == "slow" || mischief_ == "hang")
      std::this_thread::sleep_for(std::chrono::seconds(mischief_ == "slow" ? 3 : 60));
  }

  void commit_step(const bus::Step &) override { ++committed_; }
  void finish() override {
    MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
    if (rank_ == 0)
      std::printf("%s has finished after %d steps\n", name_.c_str(), committed_);
  }

 private:
  void misbehave() {
    if (mischief_ == "nan")
      signal_[1] = std::numeric_limits<double>::quiet_NaN();
    if (mischief_ == "huge")
      signal_[1] = 1e300;
    if (mischief_ == "fail" || mischief_ == "fail_in_collective")
      throw Failure(ExitCode::not_converged, "CG has not converged in 7 iterations");
    if (mischief_ == "exception")
      throw std::runtime_error("something else went wrong");
    if (mischief_ == "crash")
      std::raise(SIGSEGV);
  }

  /// Fills the buffers of the transport, as solvers do: something large for each other rank, which takes it in the next
  /// solve only.
  void chatter() {
    constexpr int size = 4000;
    MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
    words_.resize(size);
    heard_.resize(std::size_t(size) * size_);
    requests_.assign(2 * size_, MPI_REQUEST_NULL);
    for (int r = 0; r < size_; ++r)
      MPI_Isend(words_.data(), size, MPI_DOUBLE, r, 0, communicator_, &requests_[2 * r]);
    for (int r = 0; r < size_; ++r)
      MPI_Irecv(&heard_[std::size_t(r) * size], size, MPI_DOUBLE, r, 0, communicator_, &requests_[2 * r + 1]);
  }

  /// The received values must be those of the sender at the same points.
  void check(const bus::Step &step) {
    for (std::size_t i = 0; i < points_.size() / 3; ++i)
      if (std::abs(received_[2 * i] - (points_[3 * i] + step.number)) > 1e-9 ||
          std::abs(received_[2 * i + 1] - (points_[3 * i + 1] + step.iteration)) > 1e-9)
        throw Failure(ExitCode::map, "a wrong value has arrived");
  }

  MPI_Comm communicator_;
  std::string name_, mischief_ = "none";
  int rank_ = 0, size_ = 1, prepared_ = 0, committed_ = 0;
  std::vector<double> points_, signal_, received_, words_, heard_; ///< the last two of chatter
  std::vector<MPI_Request> requests_;
};

} // namespace

int main(int argc, char **argv) {
  bus::Participant participant(argc, argv, "a", "coupling_dummy");
  return participant.run([&] {
    Dummy dummy(participant);
    participant.serve(dummy);
  });
}
