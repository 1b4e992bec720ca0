#include "common/bus/participant.h"

#include "common/bus/membership.h"
#include "common/bus/placement.h"
#include "common/bus/process.h"
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
    std::printf("%s\n", version_of(program).c_str());
    std::exit(0);
  }
  if (argc == 3 && option == "--name")
    return argv[2];
  std::fprintf(stderr, "heartbus: %s takes --name NAME or --version only; settings are in the scene\n",
               program.c_str());
  std::exit(static_cast<int>(ExitCode::scene));
}

std::unique_ptr<Membership> join(const Member &self) {
  settle_process(false);
  try {
    return std::make_unique<Membership>(self);
  } catch (const Unmet &unmet) {
    std::exit(static_cast<int>(unmet.code()));
  }
}

void execute(const Command &command, Solver &solver, const LocalDeclaration &declared) {
  const Step &step = command.step;
  switch (command.kind) {
  case Command::Kind::prepare:
    return solver.prepare_step(step);
  case Command::Kind::solve:
    return solver.solve_step(step);
  case Command::Kind::commit:
    return solver.commit_step(step);
  case Command::Kind::task:
    return declared.tasks().at(command.task)(step);
  case Command::Kind::save:
    return solver.save_state(command.task, step);
  case Command::Kind::load:
    return solver.load_state(command.task, step);
  case Command::Kind::refresh:
    return solver.refresh();
  case Command::Kind::finish:
    return solver.finish();
  default:
    return; // the server's own
  }
}

} // namespace

struct Participant::Implementation {
  std::unique_ptr<Membership> membership;
  bool ended_well = false;
};

Participant::Participant(int argc, char **argv, const std::string &default_name, const std::string &program)
    : implementation_(std::make_unique<Implementation>()) {
  implementation_->membership = join({name_from(argc, argv, default_name, program), program, build_id});
  keep_to_own_core(communicator());
  if (const auto code = implementation_->membership->await_welcome())
    std::exit(*code);
}

Participant::~Participant() {
  if (implementation_->ended_well) {
    implementation_->membership->link.close();
    implementation_->membership->world.finalize();
  } else {
    // Others may still write into buffers of messages that nobody waits for any more, and not everybody may come to
    // finalize: leave everything to the end of the process, which is next.
    implementation_.release();
  }
}

const std::string &Participant::name() const { return implementation_->membership->name(); }
MPI_Comm Participant::communicator() const { return implementation_->membership->world.own(); }
const std::string &Participant::scene_text() const { return implementation_->membership->welcome.scene; }
const std::string &Participant::output_folder() const { return implementation_->membership->welcome.output_folder; }

const std::string &Participant::setting(const std::string &key, const std::string &meaning) {
  Membership &membership = *implementation_->membership;
  if (const std::string *value = membership.setting(key))
    return *value;
  throw Failure(ExitCode::scene, "key '" + membership.key(key) + "' is missing: " + meaning);
}

const std::map<std::string, std::string> &Participant::coupling() const {
  return implementation_->membership->welcome.coupling;
}

const std::string *Participant::setting(const std::string &key) { return implementation_->membership->setting(key); }

int Participant::run(const std::function<void()> &body) {
  Link &link = implementation_->membership->link;
  const int code = link.guard([&] {
    body();
    link.wait_for_the_end();
  });
  implementation_->ended_well = code == 0;
  return code;
}

void Participant::serve(Solver &solver, Sends sends) {
  Membership &membership = *implementation_->membership;
  membership.link.tell_failures([&] {
    membership.check_settings();
    Server server(membership.link);
    server.sends_anything = sends == Sends::anything;
    solver.declare(server.declaration());
    server.open(solver.stopwatches());
    while (const Command *command = server.next())
      execute(*command, solver, server.declaration());
  });
}

} // namespace heartbus::bus
