#pragma once

#include "common/base/plausible.h"
#include "common/bus/channel.h"
#include "common/bus/protocol.h"
#include "common/bus/solver.h"
#include "common/bus/waiting.h"
#include "common/bus/world.h"

#include <string>
#include <vector>

namespace heartbus::bus {

/// The sending end of a route on one rank: a channel to each rank that needs some of its points. What goes through it
/// is a header (route, step, iteration, time, size) and the values at these points.
class Outgoing {
 public:
  Outgoing(const World &world, int route, unsigned components);
  void add(const Peer &peer);
  bool is_free(); ///< whether the next values may be sent: there is room for two messages in a channel
  void pack(const Step &step, const std::vector<double> &values); ///< needs is_free()
  bool is_plausible();                                            ///< what has been packed is below largest_plausible
  void send();                                                    ///< what has been packed; does not ring
  void add_receivers(std::vector<int> &ranks) const;              ///< of the world, unless they are there already
  std::string busy_with();   ///< "mech (rank 1), fluid (rank 0)": who has not taken what was sent before
  Doorbells::Ranks takers(); ///< the same as ranks of the world
  bool needs_help();         ///< see OutgoingChannel
  void close();

 private:
  const World &world_;
  int route_;
  unsigned components_;
  std::vector<OutgoingChannel> channels_;
};

/// The receiving end of a route on one rank, always ready for the next message.
class Incoming {
 public:
  Incoming(const World &world, int route, unsigned components, const std::vector<Peer> &peers);
  bool has_arrived();
  /// Unpacks what has arrived; Failure(handshake) when messages of different steps have met.
  Step take(std::vector<double> &values); ///< needs has_arrived()
  std::string missing();                  ///< "ep (rank 1)": whose message has not come yet
  Doorbells::Ranks callers();             ///< the same as ranks of the world
  std::string sender() const { return channels_.empty() ? "" : channels_.front().peer().participant; }
  void close();
  /// Of waiting for it: as long as at the same receipt of the step before, not as at the last one.
  WaitHistory &history(const Step &step);

 private:
  int route_;
  unsigned components_;
  SharedMemory memory_; ///< of all its buffers
  std::vector<IncomingChannel> channels_;
  std::vector<WaitHistory> histories_; ///< by receipt within a step
  int step_ = 0;
  std::size_t n_receipts_ = 0;
};

} // namespace heartbus::bus
