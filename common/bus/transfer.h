#pragma once

#include "common/bus/protocol.h"
#include "common/bus/solver.h"
#include "common/bus/waiting.h"
#include "common/bus/world.h"

#include <mpi.h>
#include <set>
#include <string>
#include <vector>

namespace heartbus::bus {

/// What travels between one pair of ranks on one route: a header (route, step, iteration, time, size) and the values,
/// packed into a buffer that a persistent request owns.
struct Channel {
  Peer peer;
  std::vector<double> buffer;
};

/// The sending end of a route on one rank. A buffer stays busy until its receiver has taken it, which may be later:
/// whoever sends again waits for `idle` first.
class Outgoing {
 public:
  Outgoing(const World &world, int route, unsigned components);
  void add(const Peer &peer);
  bool idle();
  void send(const Step &step, const std::vector<double> &values); ///< needs idle()
  std::string busy_with() const; ///< "mech (rank 1), fluid (rank 0)": who has not taken the previous values
  void close();

 private:
  const World &world_;
  int route_;
  unsigned components_;
  std::vector<Channel> channels_;
  std::vector<MPI_Request> requests_; ///< of the channels
};

/// The receiving end of a route on one rank. Its buffers always wait for the next message, so that senders get rid of
/// it.
class Incoming {
 public:
  Incoming(MPI_Comm communicator, int route, unsigned components, const std::vector<Peer> &peers);
  bool arrived();
  /// Unpacks what has arrived; Failure(handshake) when messages of different steps have met.
  Step take(std::vector<double> &values); ///< needs arrived()
  std::string missing() const;            ///< "ep (rank 1)": whose message had not come yet at the last look
  Doorbells::Ranks callers() const;       ///< the same as ranks of the world
  std::string sender() const { return channels_.empty() ? "" : channels_.front().peer.participant; }
  void close();
  /// Of waiting for it: as long as at the same receipt of the step before, not as at the last one.
  Habit &habit(const Step &step);

 private:
  void listen(int channel);
  Habit first_habit() const;

  int route_;
  unsigned components_;
  std::vector<Channel> channels_;
  std::vector<MPI_Request> requests_; ///< of the channels
  std::vector<int> completed_;        ///< channels, by one look
  std::set<int> missing_;             ///< channels whose message had not come yet at the last look
  std::vector<Habit> habits_; ///< by receipt within a step
  int step_ = 0;
  std::size_t n_receipts_ = 0;
};

} // namespace heartbus::bus
