#pragma once

#include "common/base/failure.h"
#include "common/bus/solver.h"

#include <functional>
#include <map>
#include <memory>
#include <mpi.h>
#include <string>

namespace heartbus::bus {

/// One program's membership of the launch. `main` of every physics reads:
///
///     int main(int argc, char **argv) {
///       bus::Participant participant(argc, argv, "mech", "mech_solver");
///       return participant.run([&] {
///         ... build the runtime and the solver from participant.scene_text() ...
///         participant.serve(solver);
///       });
///     }
///
/// The constructor initialises MPI, splits the world by declared name and receives the scene from the coupler (which
/// has validated all of it). `run` turns exceptions into one message and the exit code for the whole launch.
class Participant {
 public:
  /// `default_name` can be replaced by `--name NAME` on the command line.
  Participant(int argc, char **argv, const std::string &default_name, const std::string &program);
  ~Participant();

  const std::string &name() const;
  MPI_Comm communicator() const;
  const std::string &scene_text() const;    ///< the resolved scene, YAML
  const std::string &output_folder() const; ///< exists already
  /// What the scene says under `participants.NAME.settings`, as written there. Failure(scene), which tells the meaning,
  /// when it says nothing.
  const std::string &setting(const std::string &key, const std::string &meaning);
  const std::string *setting(const std::string &key); ///< null when it says nothing
  /// What the coupling asks of this participant, in plain terms: common/interface/settings.h.
  const std::map<std::string, std::string> &coupling() const;

  int run(const std::function<void()> &body);
  /// Handshake, then execute the coupler's commands until the end of the run.
  enum class Sends { finite_numbers, anything }; ///< the latter to test what others do with it
  void serve(Solver &solver, Sends sends = Sends::finite_numbers);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace heartbus::bus
