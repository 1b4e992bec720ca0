#include "common/bus/participant.h"

#include "common/bus/server.h"

#include <cstdio>
#include <cstdlib>

namespace heartbus::bus {
namespace {

/// The command line of every participant: nothing but a name; all settings come with the scene.
std::string name_from(int argc, char **argv, const std::string &default_name, const std::string &program) {
  if (argc == 1)
    return default_name;
  const std::string option = argv[1];
  if (argc == 2 && option == "--version") {
    std::printf("%s (%s), protocol %d\n", program.c_str(), build_id, protocol_version);
    std::exit(0);
  }
  if (argc == 3 && option == "--name")
    return argv[2];
  std::fprintf(stderr, "heartbus: %s takes --name NAME or --version only; settings are in the scene\n",
               program.c_str());
  std::exit(static_cast<int>(ExitCode::scene));
}

} // namespace

struct Participant::Implementation {
  Implementation(int &argc, char **&argv, const std::string &name, const std::string &program)
      : name(name), world(argc, argv, {name, program, build_id}), link(world) {}

  std::string name;
  World world;
  Link link;
  Welcome welcome;
  bool ended_well = false;
};

Participant::Participant(int &argc, char **&argv, const std::string &default_name, const std::string &program)
    : implementation_(
          std::make_unique<Implementation>(argc, argv, name_from(argc, argv, default_name, program), program)) {
  Link &link = implementation_->link;
  bool welcomed = false;
  const int code = link.guard([&] {
    implementation_->welcome = unpack<Welcome>(link.receive_broadcast(1));
    welcomed = true;
  });
  if (!welcomed) { // the launch ends before it has begun
    if (code == 0)
      implementation_->world.finalize();
    std::exit(code);
  }
  link.set_deadline(implementation_->welcome.deadline);
}

Participant::~Participant() {
  if (implementation_->ended_well) {
    implementation_->link.close();
    implementation_->world.finalize();
  } else {
    // Others may still write into buffers of messages that nobody waits for any more, and not everybody may come to
    // finalize: leave everything to the end of the process, which is next.
    implementation_.release();
  }
}

const std::string &Participant::name() const { return implementation_->name; }
MPI_Comm Participant::communicator() const { return implementation_->world.own(); }
const std::string &Participant::scene_text() const { return implementation_->welcome.scene; }
const std::string &Participant::output_folder() const { return implementation_->welcome.output_folder; }

int Participant::run(const std::function<void()> &body) {
  Link &link = implementation_->link;
  const int code = link.guard([&] {
    body();
    link.wait_for_the_end();
  });
  implementation_->ended_well = code == 0;
  return code;
}

void Participant::serve(Solver &solver) {
  Link &link = implementation_->link;
  link.tell_failures([&] { Server(solver, link).run(); });
}

} // namespace heartbus::bus
