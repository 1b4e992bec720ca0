#pragma once

#include "common/base/failure.h"
#include "common/bus/solver.h"
#include "common/bus/trace.h"

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace heartbus::bus {

/// What a participant has declared, as the coupler sees it.
struct FieldInfo {
  std::string name, point_set, unit; ///< point_set: see Declaration::global
  std::string level;                 ///< of an output; of an input the task that reads it, or nothing
  unsigned components = 1;
  bool output = false;
  bool is_global() const { return point_set == Declaration::global; }
};
struct PointSetInfo {
  std::string name;
  double spacing = 0;                           ///< smallest of all ranks [m]
  std::vector<std::vector<double>> coordinates; ///< [rank of the participant][3 * point]
  unsigned n_corners = 0;                       ///< of a face
  std::vector<double> faces;                    ///< of all ranks, [3 * n_corners * face]: where their corners are
  std::size_t n_points() const;                 ///< of all ranks
};
struct ScalarInfo {
  std::string name, unit;
  std::vector<std::string> states; ///< names of a state's values; empty for a number
};
struct ParticipantInfo {
  std::string name, program;
  int n_ranks = 0;
  std::vector<PointSetInfo> point_sets;
  std::vector<FieldInfo> fields;
  std::vector<std::string> tasks;
  std::vector<ScalarInfo> scalars;
  const FieldInfo *field(const std::string &name) const; ///< null when there is none
};

/// Something a participant is told to do; executed in the order received.
struct Command {
  static constexpr char scalars_only[] = "scalars";
  /// connect: take over a row of a routing table; ordered by Coordinator::connect and record themselves.
  /// trace: note from now on what is done when, and hand it over in the end; ordered by Coordinator::trace.
  /// notify, wait: like send and receive, without a field; for those who share cores.
  enum class Kind {
    prepare,
    solve,
    commit,
    task,
    send,
    receive,
    report,
    finish,
    connect,
    save,
    load,
    refresh,
    trace,
    notify,
    wait
  };
  Kind kind = Kind::solve;
  std::string task; ///< of Kind::task; of save and load the folder; of notify and wait the other participant;
                    ///< of report `scalars_only` when times may follow with a later one
  int route = -1;   ///< of send and receive
  Step step;
};

/// Where the wall time of a participant has gone, told in two ways; means of its ranks.
struct Times {
  Seconds commands; ///< "prepare", "solve", "commit", "task:NAME", "send", "receive", "save", ..., "idle"
  Seconds parts;    ///< the sections of the solver's stopwatches, "other", "bus", "checkpoint",
                    ///< "waiting"
  Times &operator+=(const Times &more);
};

/// A participant's answer to Command::report: scalars in declared order, times since the last report with times.
struct Report {
  std::vector<double> scalars;
  Times times;
  double cpu_seconds = 0; ///< sum over ranks, since the start
  double peak_memory = 0; ///< sum over ranks [byte]
  double n_overslept = 0; ///< sum over ranks: see Waiting
};

/// The coupler's end of the bus: it owns the handshake, the routes, the streams of commands, deadlines and the abort of
/// the whole launch. It knows neither schemes nor physics.
class Coordinator {
 public:
  Coordinator();
  ~Coordinator();

  /// Runs `body`; a Failure (its own or one that a participant reports) is printed once, ordered to every rank, and its
  /// code returned.
  int run(const std::function<void()> &body);

  /// Compares who came with who is expected (name -> {program, ranks; 0 = any}), sends everyone the scene, collects the
  /// declarations. Failure(handshake) lists what was expected and what came.
  struct Expected {
    std::string program; ///< empty: any
    int ranks = 0;
    std::map<std::string, std::string> settings{}; ///< of the scene, handed on to the participant
    std::map<std::string, std::string> coupling{}; ///< what the coupling asks of it, likewise
  };
  void handshake(const std::map<std::string, Expected> &expected, const std::string &scene_text,
                 const std::string &output_folder, double deadline_seconds);
  const std::vector<ParticipantInfo> &participants() const;
  const ParticipantInfo &participant(const std::string &name) const;

  /// Matches the points of `field` as `from` sends it and `to` receives it and distributes the routing tables. Returns
  /// the route's number. Failure(handshake) on unknown fields, unit or component mismatch, Failure(map) on points that
  /// do not match (worst node named).
  int connect(const std::string &from, const std::string &to, const std::string &field);
  /// Lets the coupler itself receive what travels on a route: `on_values(step, values)` gets the field at the target's
  /// points (coordinates in `coordinates`, both in the order of target ranks and their points) after each transfer.
  struct Recording {
    std::vector<double> coordinates;
    unsigned components = 1;
    std::string unit;
  };
  Recording record(int route, std::function<void(const Step &, const std::vector<double> &)> on_values);

  /// Queues a command for one participant; `flush` sends all that is queued, one message to each participant's root.
  void order(const std::string &participant, const Command &command);
  void flush();
  /// Waits (asleep) for the participant's next report, i.e. its answer to a Command::report ordered before, and for the
  /// recordings of all that it was ordered to send before that.
  Report wait_report(const std::string &participant);
  /// From now on every rank notes what it does when.
  void trace();
  struct RankTrace {
    std::string participant;
    int rank = 0;
    Trace trace;
  };
  /// Ends all participants, waits for them and returns what they have noted. `run` does it when its body has not.
  std::vector<RankTrace> finish();
  /// The coupler's own waits that ended late: see Waiting.
  int n_overslept() const;
  /// True when SIGUSR1 has arrived (only the coupler acts on it).
  bool stop_requested() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace heartbus::bus
