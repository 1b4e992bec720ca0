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

bool all_complete(std::vector<Channel> &channels) {
  for (Channel &channel : channels) {
    int complete = 0;
    MPI_Test(&channel.request, &complete, MPI_STATUS_IGNORE);
    if (!complete)
      return false;
  }
  return true;
}

std::string incomplete(const std::vector<Channel> &channels) {
  std::string names;
  for (const Channel &channel : channels) {
    int complete = 0;
    MPI_Request_get_status(channel.request, &complete, MPI_STATUS_IGNORE);
    if (!complete)
      names +=
          (names.empty() ? "" : ", ") + channel.peer.participant + " (rank " + std::to_string(channel.peer.rank) + ")";
  }
  return names;
}

} // namespace

Outgoing::Outgoing(const World &world, int route, unsigned components)
    : world_(world), route_(route), components_(components) {}

void Outgoing::add(const Peer &peer) {
  Channel channel{peer, std::vector<double>(header_size + components_ * peer.points.size()), MPI_REQUEST_NULL};
  MPI_Send_init(channel.buffer.data(), channel.buffer.size(), MPI_DOUBLE, peer.world_rank, route_, world_.data(),
                &channel.request);
  channels_.push_back(std::move(channel));
}

bool Outgoing::idle() { return all_complete(channels_); }

void Outgoing::send(const Step &step, const std::vector<double> &values) {
  for (Channel &channel : channels_) {
    write_header(route_, step, channel.buffer.data());
    double *packed = channel.buffer.data() + header_size;
    for (const int point : channel.peer.points)
      packed = std::copy_n(values.data() + std::size_t(point) * components_, components_, packed);
    MPI_Start(&channel.request);
  }
  for (const Channel &channel : channels_) // who wakes may take this core
    world_.bells().ring(channel.peer.world_rank);
}

std::string Outgoing::busy_with() const { return incomplete(channels_); }

void Outgoing::close() {
  for (Channel &channel : channels_)
    MPI_Request_free(&channel.request);
}

Incoming::Incoming(MPI_Comm communicator, int route, unsigned components, const std::vector<Peer> &peers)
    : route_(route), components_(components) {
  for (const Peer &peer : peers) {
    Channel channel{peer, std::vector<double>(header_size + components * peer.points.size()), MPI_REQUEST_NULL};
    MPI_Recv_init(channel.buffer.data(), channel.buffer.size(), MPI_DOUBLE, peer.world_rank, route, communicator,
                  &channel.request);
    MPI_Start(&channel.request);
    channels_.push_back(std::move(channel));
  }
}

bool Incoming::arrived() { return all_complete(channels_); }

Step Incoming::take(std::vector<double> &values) {
  Step step;
  for (Channel &channel : channels_) {
    const double *packed = channel.buffer.data();
    const Step mine = read_header(packed);
    if (&channel == &channels_.front())
      step = mine;
    if (packed[0] != route_ || mine.number != step.number || mine.iteration != step.iteration)
      throw Failure(ExitCode::handshake, "messages of " + describe(step) + " and " + describe(mine) +
                                             " have met; the sequence does not pair its sends and receives");
    packed += header_size;
    for (const int point : channel.peer.points) {
      std::copy_n(packed, components_, values.data() + std::size_t(point) * components_);
      packed += components_;
    }
    MPI_Start(&channel.request);
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
  for (const Channel &channel : channels_) {
    habit.caller = channel.peer.world_rank;
    habit.comes_in_parts |= channel.buffer.size() * sizeof(double) > World::whole_message;
  }
  return habit;
}

std::string Incoming::missing() const { return incomplete(channels_); }

void Incoming::close() {
  for (Channel &channel : channels_) {
    MPI_Cancel(&channel.request);
    MPI_Wait(&channel.request, MPI_STATUS_IGNORE);
    MPI_Request_free(&channel.request);
  }
}

} // namespace heartbus::bus
