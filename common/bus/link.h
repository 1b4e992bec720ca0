#pragma once

#include "common/bus/protocol.h"
#include "common/bus/transfer.h"
#include "common/bus/waiting.h"
#include "common/bus/world.h"

#include <functional>
#include <map>
#include <vector>

namespace heartbus::bus {

/// The coupler has ordered this rank to leave. Not an error of this rank: it is not reported.
struct LeaveOrder {
  int code = 0;
};

/// One rank's connection with the coupler and with the other ranks of its participant. Every wait listens for the order
/// to leave, which the coupler sends to every rank. Buffers of messages under way live here, so that they outlast the
/// unwinding after a failure.
class Link {
 public:
  explicit Link(World &world);

  const Waiting &waiting() const { return waiting_; }
  const Doorbells &bells() const { return world_.bells(); }
  void set_deadline(double seconds) { waiting_.deadline = seconds; }
  bool is_root() const { return local_rank_ == 0; }
  int local_size() const { return local_size_; }

  /// The coupler's next message to this participant, on every rank of it.
  Bytes receive_broadcast(double patience);
  /// The coupler's next message to this very rank.
  Bytes receive(Tag tag, const std::string &what, const std::string &from);
  template <class T>
  void post(Tag tag, const T &message) {
    mail_.post(world_.coupler(), tag, message);
  }
  void post_progress();
  /// Lets another participant go on: each of its ranks is told by one rank of this one. Those of this node are to be
  /// rung.
  void notify(const std::string &to, std::vector<int> &to_be_rung);
  /// Waits until another participant has passed its turn on.
  void wait(const std::string &from);
  /// From the other ranks to the root, which passes a report of all on. Who posts does not wait.
  void post_share(const Report &share) { mail_.post(own_ranks_.front(), tag_share, share); }
  std::vector<Report> receive_shares();

  /// Runs `body`; an exception becomes a complaint, answered by the order to leave. Returns the exit code.
  int guard(const std::function<void()> &body);
  /// Like guard, but passes the order on to the caller's guard: for failures that must be told before the stack
  /// unwinds, because destructors of a solver may be collective.
  void tell_failures(const std::function<void()> &body);
  /// Nothing more to do: waits until everybody has come that far.
  void wait_for_the_end();
  void close();

  /// Takes over a row of a routing table; a later row of the same route adds receivers.
  void connect(const RouteRow &row, unsigned components);
  std::map<int, Outgoing> outgoing; ///< by route
  std::map<int, Incoming> incoming;

 private:
  void poll();
  bool is_sending(); ///< whether messages of its own are under way
  [[noreturn]] void complain(const ErrorReport &error);
  /// The launcher kills everybody as soon as one process ends with a code, so nobody ends before all have unwound, i.e.
  /// closed their files.
  void wait_for_exit();
  Bytes receive_from(int world_rank, Tag tag, const Awaited &awaited, double patience = 1,
                     WaitHistory *history = nullptr);

  World &world_;
  Mailbox mail_;
  Waiting waiting_;
  WaitHistory commands_, turns_;    ///< of waiting for them
  std::uint32_t n_turns_taken_ = 0; ///< that ranks of this node have passed on
  int local_rank_ = 0, local_size_ = 1;
  std::vector<int> own_ranks_; ///< of the world, in the order of local ranks
  int leave_code_ = 0;
  MPI_Request leave_ = MPI_REQUEST_NULL;
};

} // namespace heartbus::bus
