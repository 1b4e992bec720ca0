#pragma once

#include "common/base/failure.h"
#include "common/bus/doorbell.h"
#include "common/bus/pipe.h"

#include <mpi.h>
#include <optional>
#include <string>
#include <vector>

namespace heartbus::bus {

constexpr int protocol_version = 9;                 ///< everyone in a launch must speak the same
extern const char *const build_id;                  ///< shown by --version and in the list of who came
std::string version_of(const std::string &program); ///< program, its build and the protocol: what --version prints

/// What every rank of the launch tells all others first.
struct Member {
  std::string name, program, build;
  int protocol = protocol_version;
  bool coupler = false;
};

/// Those who came cannot work together: one message, which lists them, has been printed.
class Unmet : public Failure {
 public:
  explicit Unmet(const std::string &message) : Failure(ExitCode::handshake, message) {}
};

/// The launch: initialises MPI unless the program has done so, learns who came and splits by declared name (MPI_APPNUM
/// is absent under some launchers). This is the only place that names MPI_COMM_WORLD. A launch without exactly one
/// coupler, with one name claimed by two programs or with different protocols ends here: Unmet.
class World {
 public:
  explicit World(const Member &self);

  int rank() const { return rank_; }
  int coupler() const { return coupler_; }
  const std::vector<Member> &members() const { return members_; } ///< by rank of the world
  std::vector<int> ranks_of(const std::string &name) const;
  std::string who_came() const;

  MPI_Comm control() const { return control_; } ///< everyone: commands, complaints, reports
  MPI_Comm data() const { return data_; }       ///< everyone: fields
  MPI_Comm own() const { return own_; }         ///< the participant's ranks: for the solver
  MPI_Comm local() const { return local_; }     ///< the participant's ranks: for the bus

  const Doorbells &bells() const { return *bells_; }
  /// To and from a rank of the same node, between the coupler and everybody and between the first rank of a participant
  /// and its others; null for all else.
  Pipe *pipe_to(int rank) const { return pipe(rank, true); }
  Pipe *pipe_from(int rank) const { return pipe(rank, false); }

  void finalize();                   ///< collective over the launch; MPI only if it has been initialised here
  [[noreturn]] void abort(int code); ///< when somebody cannot be reached any more

 private:
  void gather_members(const Member &self);
  std::string objection() const;
  Pipe *pipe(int rank, bool outwards) const;

  std::optional<Doorbells> bells_;
  std::optional<NodeArray<Pipes>> pipes_;
  bool owns_mpi_ = false;
  int rank_ = 0, coupler_ = -1;
  std::vector<Member> members_;
  MPI_Comm control_ = MPI_COMM_NULL, data_ = MPI_COMM_NULL, own_ = MPI_COMM_NULL, local_ = MPI_COMM_NULL;
};

} // namespace heartbus::bus
