#pragma once

#include "common/bus/coordinator.h"
#include "common/bus/packer.h"
#include "common/bus/pipe.h"
#include "common/bus/world.h"

#include <list>
#include <map>
#include <mpi.h>
#include <optional>
#include <string>
#include <vector>

namespace heartbus::bus {

/// Tags of the control communicator.
enum Tag {
  tag_command,     ///< coupler -> root -> other ranks: the welcome, then batches of commands
  tag_declaration, ///< every rank -> coupler
  tag_route,       ///< coupler -> rank: its row of a routing table
  tag_progress,    ///< root -> coupler: one command has been executed
  tag_report,      ///< root -> coupler
  tag_complaint,   ///< any rank -> coupler: it has failed
  tag_leave,       ///< coupler -> every rank: the exit code; 0 after a good end
  tag_gone,        ///< every rank -> coupler: its work is done or unwound
  tag_trace,       ///< every rank -> coupler: what it has done when, if it was ordered to note that
  tag_exit,        ///< coupler -> every rank, after a failure: all have gone, the processes may end
  tag_turn,        ///< from one participant's ranks to those of another: go on
  tag_share,       ///< rank -> root: its part of a report
  tag_question,    ///< rank -> coupler, before its declaration: it wants to know another participant's points
  tag_partner      ///< coupler -> rank: the points it has asked for
};

/// First message to a participant.
struct Welcome {
  std::string scene, output_folder;
  double deadline = 0;
  std::map<std::string, std::string> settings; ///< free keys of the scene, for this participant
  std::map<std::string, std::string> coupling; ///< what the coupling asks of it; it may pass over them
};

struct Question {
  std::string participant, point_set;
};

/// A point set of another participant: all points, in the order of its ranks, and faces between them.
struct PartnerPoints {
  std::vector<double> coordinates; ///< [3 * point]
  double spacing = 0;
  unsigned n_corners = 0; ///< of a face
  std::vector<int> faces; ///< [n_corners * face]: points
};

/// Which points of this rank travel to, or come from, one other rank.
struct Peer {
  int world_rank = 0;
  std::string participant;
  int rank = 0; ///< within that participant
  std::vector<int> points;
};

/// One rank's row of a routing table.
struct RouteRow {
  int route = 0;
  bool outgoing = false;
  std::string field;
  std::vector<Peer> peers;
};

/// Why a rank has failed. A deadline names the participant that was waited for.
struct ErrorReport {
  int code = 0;
  std::string message, waits_for;
};

Packer &operator<<(Packer &packer, const Welcome &welcome);
Unpacker &operator>>(Unpacker &unpacker, Welcome &welcome);
Packer &operator<<(Packer &packer, const Question &question);
Unpacker &operator>>(Unpacker &unpacker, Question &question);
Packer &operator<<(Packer &packer, const PartnerPoints &points);
Unpacker &operator>>(Unpacker &unpacker, PartnerPoints &points);
Packer &operator<<(Packer &packer, const RouteRow &row);
Unpacker &operator>>(Unpacker &unpacker, RouteRow &row);
Packer &operator<<(Packer &packer, const ErrorReport &error);
Unpacker &operator>>(Unpacker &unpacker, ErrorReport &error);
Packer &operator<<(Packer &packer, const Command &command);
Unpacker &operator>>(Unpacker &unpacker, Command &command);
Packer &operator<<(Packer &packer, const Report &report);
Unpacker &operator>>(Unpacker &unpacker, Report &report);
/// One rank's declarations: `info.point_sets[i].coordinates` holds this rank's points alone.
Packer &operator<<(Packer &packer, const ParticipantInfo &info);
Unpacker &operator>>(Unpacker &unpacker, ParticipantInfo &info);

/// "step 3, iteration 0"
std::string describe(const Step &step);
/// "solve", "task inflate", "send": also the kinds of work in a Report.
std::string kind_of_work(const Command &command);

/// Sends and receives messages of any length without ever blocking: on one node through pipes, else by MPI, whose
/// buffers may hold a message back until its sender calls MPI again.
class Mailbox {
 public:
  explicit Mailbox(const World &world);

  /// Rings the receiver's bell if it can be reached.
  void send(int rank, Tag tag, Bytes bytes);
  template <class T>
  void post(int rank, Tag tag, const T &message) {
    Packer packer;
    packer << message;
    send(rank, tag, packer.take());
  }

  std::optional<Message> receive(int rank, int tag); ///< rank may be MPI_ANY_SOURCE, tag MPI_ANY_TAG
  bool all_sent();                                   ///< lets messages progress and frees those that have left
  /// Lets MPI take in what solvers have sent to this rank: who sleeps with it unread keeps their buffers from them.
  void make_progress() const;

 private:
  struct Outbound {
    Bytes bytes;
    MPI_Request request;
  };
  void push(int rank, PipeWriter &pipe);
  std::optional<Message> receive_by_mpi(int rank, int tag);

  const World &world_;
  std::map<int, PipeWriter> writers_; ///< by rank of the world
  std::map<int, PipeReader> readers_;
  std::list<Message> arrived_; ///< through pipes, and nobody has asked for them yet
  std::list<Outbound> outbound_;
};

} // namespace heartbus::bus
