#include "common/bus/transfer.h"

#include "common/bus/failure.h"

#include <algorithm>

namespace heartbus::bus {
namespace {

constexpr int header_size = 5;

void write_header(int route, const Step &step, double *header) {
  header[0] = route;
  header[1] = step.number;
  header[2] = step.iteration;
  header[3] = step.time;
  header[4] = step.size;
}

Step read_header(const double *header) {
  return {static_cast<int>(header[1]), static_cast<int>(header[2]), header[3], header[4]};
}

/// Moves `n` numbers a point, scattered at `points`, to the packed ones (or back): with `n` known to the compiler there
/// is no call of memmove a point.
template <unsigned n, class Move>
void for_each_point(const std::vector<int> &points, unsigned components, const Move &move) {
  std::size_t packed = 0;
  for (const int point : points)
    for (unsigned c = 0; c < (n ? n : components); ++c)
      move(packed++, std::size_t(point) * (n ? n : components) + c);
}

template <class Move>
void for_each_value(const std::vector<int> &points, unsigned components, const Move &move) {
  if (components == 1)
    for_each_point<1>(points, 1, move);
  else if (components == 3)
    for_each_point<3>(points, 3, move);
  else
    for_each_point<0>(points, components, move);
}

std::string name_of(const Peer &peer) { return peer.participant + " (rank " + std::to_string(peer.rank) + ")"; }

} // namespace

Outgoing::Outgoing(const World &world, int route, unsigned components)
    : world_(world), route_(route), components_(components) {}

void Outgoing::add(const Peer &peer) {
  channels_.push_back({peer, std::vector<double>(header_size + components_ * peer.points.size())});
  auto &buffer = channels_.back().buffer;
  MPI_Send_init(buffer.data(), buffer.size(), MPI_DOUBLE, peer.world_rank, route_, world_.data(),
                &requests_.emplace_back());
}

bool Outgoing::idle() {
  int all = 0;
  MPI_Testall(requests_.size(), requests_.data(), &all, MPI_STATUSES_IGNORE);
  return all;
}

void Outgoing::send(const Step &step, const std::vector<double> &values) {
  for (std::size_t k = 0; k < channels_.size(); ++k) {
    Channel &channel = channels_[k];
    write_header(route_, step, channel.buffer.data());
    for_each_value(channel.peer.points, components_,
                   [packed = channel.buffer.data() + header_size,
                    source = values.data()](std::size_t k, std::size_t i) { packed[k] = source[i]; });
    MPI_Start(&requests_[k]);
  }
  for (const Channel &channel : channels_) // who wakes may take this core
    world_.bells().ring(channel.peer.world_rank);
}

std::string Outgoing::busy_with() const {
  std::string names;
  for (std::size_t k = 0; k < channels_.size(); ++k) {
    int complete = 0;
    MPI_Request_get_status(requests_[k], &complete, MPI_STATUS_IGNORE);
    if (!complete)
      names += (names.empty() ? "" : ", ") + name_of(channels_[k].peer);
  }
  return names;
}

void Outgoing::close() {
  for (MPI_Request &request : requests_)
    MPI_Request_free(&request);
}

Incoming::Incoming(MPI_Comm communicator, int route, unsigned components, const std::vector<Peer> &peers)
    : route_(route), components_(components), requests_(peers.size()), completed_(peers.size()) {
  for (const Peer &peer : peers)
    channels_.push_back({peer, std::vector<double>(header_size + components * peer.points.size())});
  for (std::size_t k = 0; k < channels_.size(); ++k) {
    auto &buffer = channels_[k].buffer;
    MPI_Recv_init(buffer.data(), buffer.size(), MPI_DOUBLE, peers[k].world_rank, route, communicator, &requests_[k]);
    listen(k);
  }
}

void Incoming::listen(int channel) {
  MPI_Start(&requests_[channel]);
  missing_.insert(channel);
}

bool Incoming::arrived() {
  for (int idle_looks = 0; idle_looks < 2 && !missing_.empty();) { // the second finds what the first has let in
    int n = 0;
    MPI_Testsome(requests_.size(), requests_.data(), &n, completed_.data(), MPI_STATUSES_IGNORE);
    idle_looks += n == 0;
    for (int k = 0; k < n; ++k)
      missing_.erase(completed_[k]);
  }
  return missing_.empty();
}

Step Incoming::take(std::vector<double> &values) {
  Step step;
  for (std::size_t k = 0; k < channels_.size(); ++k) {
    const Channel &channel = channels_[k];
    const double *packed = channel.buffer.data();
    const Step mine = read_header(packed);
    if (k == 0)
      step = mine;
    if (packed[0] != route_ || mine.number != step.number || mine.iteration != step.iteration)
      throw Failure(ExitCode::handshake, "messages of " + describe(step) + " and " + describe(mine) +
                                             " have met; the sequence does not pair its sends and receives");
    for_each_value(channel.peer.points, components_,
                   [packed = packed + header_size, target = values.data()](std::size_t k, std::size_t i) {
                     target[i] = packed[k];
                   });
    listen(k);
  }
  return step;
}

Habit &Incoming::habit(const Step &step) {
  if (step.number != step_)
    n_receipts_ = 0;
  step_ = step.number;
  if (habits_.size() == n_receipts_)
    habits_.push_back(first_habit());
  return habits_[n_receipts_++];
}

Habit Incoming::first_habit() const {
  Habit habit;
  for (const Channel &channel : channels_)
    habit.comes_in_parts |= channel.buffer.size() * sizeof(double) > World::whole_message;
  return habit;
}

std::string Incoming::missing() const {
  std::string names;
  for (const int channel : missing_)
    names += (names.empty() ? "" : ", ") + name_of(channels_[channel].peer);
  return names;
}

Doorbells::Ranks Incoming::callers() const {
  Doorbells::Ranks ranks = 0;
  for (const int channel : missing_)
    ranks |= Doorbells::only(channels_[channel].peer.world_rank);
  return ranks;
}

void Incoming::close() {
  for (MPI_Request &request : requests_) {
    MPI_Cancel(&request);
    MPI_Wait(&request, MPI_STATUS_IGNORE);
    MPI_Request_free(&request);
  }
}

} // namespace heartbus::bus
