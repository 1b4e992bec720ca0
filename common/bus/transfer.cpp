#include "common/bus/transfer.h"

#include "common/base/failure.h"

#include <algorithm>
#include <limits>
#include <numeric>

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

/// Several at a time: beyond the limit, and then only, the first product is not finite, and the second not zero.
bool all_plausible(const double *numbers, std::size_t n) {
  constexpr std::size_t width = 8;
  constexpr double scale = std::numeric_limits<double>::max() / largest_plausible;
  double zeros[width] = {};
  std::size_t i = 0;
  for (; i + width <= n; i += width)
    for (std::size_t k = 0; k < width; ++k)
      zeros[k] += 0. * (scale * numbers[i + k]);
  for (; i < n; ++i)
    zeros[0] += 0. * (scale * numbers[i]);
  return std::accumulate(zeros, zeros + width, 0.) == 0;
}

std::size_t size_of(const Peer &peer, unsigned components) { return header_size + components * peer.points.size(); }

std::size_t bytes_of_buffers(const std::vector<Peer> &peers, unsigned components) {
  std::size_t bytes = 0;
  for (const Peer &peer : peers)
    bytes += MessageBuffer::bytes(size_of(peer, components));
  return bytes;
}

template <class Channels, class Condition>
std::string names_of(Channels &channels, const Condition &condition) {
  std::string names;
  for (auto &channel : channels)
    if (condition(channel))
      names += (names.empty() ? "" : ", ") + name_of(channel.peer());
  return names;
}

template <class Channels, class Condition>
Doorbells::Ranks ranks_of(Channels &channels, const Condition &condition) {
  Doorbells::Ranks ranks = 0;
  for (auto &channel : channels)
    if (condition(channel))
      ranks |= Doorbells::only(channel.peer().world_rank);
  return ranks;
}

const auto is_busy = [](OutgoingChannel &channel) { return !channel.is_free(); };
const auto is_missing = [](IncomingChannel &channel) { return !channel.has_arrived(); };

} // namespace

Outgoing::Outgoing(const World &world, int route, unsigned components)
    : world_(world), route_(route), components_(components) {}

void Outgoing::add(const Peer &peer) { channels_.emplace_back(world_, route_, peer, size_of(peer, components_)); }

bool Outgoing::is_free() { return std::none_of(channels_.begin(), channels_.end(), is_busy); }

void Outgoing::pack(const Step &step, const std::vector<double> &values) {
  for (OutgoingChannel &channel : channels_) {
    double *message = channel.message();
    write_header(route_, step, message);
    for_each_value(channel.peer().points, components_,
                   [packed = message + header_size, source = values.data()](std::size_t k, std::size_t i) {
                     packed[k] = source[i];
                   });
  }
}

bool Outgoing::is_plausible() {
  return std::all_of(channels_.begin(), channels_.end(), [this](OutgoingChannel &channel) {
    return all_plausible(channel.message(), size_of(channel.peer(), components_));
  });
}

void Outgoing::send() {
  for (OutgoingChannel &channel : channels_)
    channel.send();
}

void Outgoing::add_receivers(std::vector<int> &ranks) const {
  for (const OutgoingChannel &channel : channels_)
    if (const int rank = channel.peer().world_rank; std::find(ranks.begin(), ranks.end(), rank) == ranks.end())
      ranks.push_back(rank);
}

std::string Outgoing::busy_with() { return names_of(channels_, is_busy); }
Doorbells::Ranks Outgoing::takers() { return ranks_of(channels_, is_busy); }

bool Outgoing::needs_help() {
  return std::any_of(channels_.begin(), channels_.end(), [](OutgoingChannel &channel) { return channel.needs_help(); });
}

void Outgoing::close() {
  for (OutgoingChannel &channel : channels_)
    channel.close();
}

Incoming::Incoming(const World &world, int route, unsigned components, const std::vector<Peer> &peers)
    : route_(route), components_(components), memory_(bytes_of_buffers(peers, components)) {
  std::size_t offset = 0;
  for (const Peer &peer : peers) {
    const std::size_t n_numbers = size_of(peer, components);
    channels_.emplace_back(world, route, peer, n_numbers, reinterpret_cast<MessageBuffer *>(memory_.begin() + offset),
                           BufferAddress{memory_.ticket(), offset});
    offset += MessageBuffer::bytes(n_numbers);
  }
}

bool Incoming::has_arrived() { return std::none_of(channels_.begin(), channels_.end(), is_missing); }

Step Incoming::take(std::vector<double> &values) {
  Step step;
  for (std::size_t k = 0; k < channels_.size(); ++k) {
    const double *packed = channels_[k].message();
    const Step mine = read_header(packed);
    if (k == 0)
      step = mine;
    if (packed[0] != route_ || mine.number != step.number || mine.iteration != step.iteration)
      throw Failure(ExitCode::handshake, "messages of " + describe(step) + " and " + describe(mine) +
                                             " have met; the sequence does not pair its sends and receives");
    for_each_value(channels_[k].peer().points, components_,
                   [packed = packed + header_size, target = values.data()](std::size_t k, std::size_t i) {
                     target[i] = packed[k];
                   });
    channels_[k].take();
  }
  return step;
}

WaitHistory &Incoming::history(const Step &step) {
  if (step.number != step_)
    n_receipts_ = 0;
  step_ = step.number;
  if (histories_.size() == n_receipts_)
    histories_.emplace_back();
  return histories_[n_receipts_++];
}

std::string Incoming::missing() { return names_of(channels_, is_missing); }
Doorbells::Ranks Incoming::callers() { return ranks_of(channels_, is_missing); }

void Incoming::close() {
  for (IncomingChannel &channel : channels_)
    channel.close();
}

} // namespace heartbus::bus
