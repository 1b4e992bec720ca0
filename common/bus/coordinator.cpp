#include "common/bus/coordinator.h"

#include "common/base/failure.h"
#include "common/bus/handshake.h"
#include "common/bus/placement.h"
#include "common/bus/process.h"
#include "common/bus/progress_monitor.h"
#include "common/bus/protocol.h"
#include "common/bus/pulse.h"
#include "common/bus/recorders.h"
#include "common/bus/route_table.h"
#include "common/bus/waiting.h"
#include "common/bus/world.h"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <list>
#include <set>

namespace heartbus::bus {
namespace {

constexpr int unforeseen = 1;        ///< exit code of exceptions that are no Failure
constexpr double grace_to_leave = 2; ///< [s] for all ranks to follow the order, before MPI_Abort
constexpr double watch_margin = 0.5; ///< [s] beyond the deadline, so that those who wait speak first

volatile std::sig_atomic_t stop_signal = 0;

/// A rank has complained.
struct RemoteError {
  int code;
  std::string text;
};

} // namespace

struct Coordinator::Implementation {
  Implementation()
      : world({"coupler", "coupler", build_id, protocol_version, true}), mail(world),
        waiting([this] { poll(); }, [this] { return !mail.all_sent(); }, &world.bells()) {
    MPI_Comm_size(world.control(), &n_ranks);
    pulse.beat(stage, 0);
  }

  void poll();
  void count_progress();
  void open_letters();
  void open(Message received);
  void merge(Message declaration);
  [[noreturn]] void heed(Message received);
  std::pair<std::string, int> member(int world_rank) const; ///< its name and its rank within the participant
  std::string who(int world_rank) const;
  void collect_declarations();
  bool has_declared(const std::string &participant) const;
  void answer_questions();
  void post_rows(const RouteTable &table);
  void await_all_gone();
  void order_all_to_leave(int code);
  void send_off(int code);

  World world;
  Mailbox mail;
  Waiting waiting;
  ProgressMonitor progress;
  Pulse pulse;
  const char *stage = "meeting";
  int n_ranks = 0, n_gone = 0;
  int leave_code = 0; ///< buffer of the orders to leave
  bool welcomed = false, ended_well = false;
  std::vector<ParticipantInfo> participants;
  std::list<RouteTable> tables;
  std::vector<RouteName> route_names;
  Recorders recorders;
  std::map<std::string, std::uint32_t> n_executed; ///< commands, as counted by those of this node
  std::deque<Message> errors;
  std::set<int> silent;              ///< ranks that have not declared anything yet
  std::map<int, Question> questions; ///< by the rank that waits for the answer
  std::map<std::string, std::deque<Report>> reports;
  std::map<std::string, WaitHistory> histories; ///< of waiting for the reports of each participant
  std::map<std::string, std::vector<Command>> queue;
  std::set<std::string> finished;
  std::size_t n_traced = 0; ///< ranks that will hand over a trace
  std::vector<RankTrace> traces;
};

std::pair<std::string, int> Coordinator::Implementation::member(int world_rank) const {
  const std::string &name = world.members()[world_rank].name;
  const auto ranks = world.ranks_of(name);
  return {name, std::find(ranks.begin(), ranks.end(), world_rank) - ranks.begin()};
}

std::string Coordinator::Implementation::who(int world_rank) const {
  const auto [name, rank] = member(world_rank);
  return name + " (rank " + std::to_string(rank) + ")";
}

void Coordinator::Implementation::poll() {
  mail.all_sent();
  mail.make_progress();
  open_letters();
  recorders.take_arrived();
  pulse.beat(stage, progress.step());
  progress.watch(waiting.deadline + watch_margin, route_names);
}

void Coordinator::Implementation::count_progress() {
  for (const ParticipantInfo &participant : participants)
    if (const int root = world.ranks_of(participant.name).front(); world.bells().reach(root))
      for (std::uint32_t &n = n_executed[participant.name]; n != world.bells().counters(root).progress; ++n)
        progress.executed_one(participant.name);
}

/// Of all kinds in one go: each look that finds nothing leaves the core to others. Complaints come last, when it is
/// known who is busy with what.
void Coordinator::Implementation::open_letters() {
  while (auto received = mail.receive(MPI_ANY_SOURCE, MPI_ANY_TAG))
    open(std::move(*received));
  count_progress();
  if (!errors.empty())
    heed(std::move(errors.front()));
}

void Coordinator::Implementation::open(Message received) {
  const auto [name, rank] = member(received.sender);
  switch (received.tag) {
  case tag_progress:
    return progress.executed_one(name);
  case tag_report:
    return reports[name].push_back(unpack<Report>(std::move(received.content)));
  case tag_declaration:
    return merge(std::move(received));
  case tag_question:
    questions[received.sender] = unpack<Question>(std::move(received.content));
    return;
  case tag_complaint:
    return errors.push_back(std::move(received));
  case tag_trace:
    return traces.push_back({name, rank, unpack<Trace>(std::move(received.content))});
  case tag_gone:
    ++n_gone;
  }
}

void Coordinator::Implementation::heed(Message received) {
  auto error = unpack<ErrorReport>(std::move(received.content));
  const auto [name, rank] = member(received.sender);
  for (const ParticipantInfo &participant : participants)
    if (participant.name == error.waits_for)
      error.message += progress.why_late(error.waits_for, route_names, rank == 0 ? name : "");
  throw RemoteError{error.code, who(received.sender) + ": " + error.message};
}

void Coordinator::Implementation::merge(Message declaration) {
  const auto [name, rank] = member(declaration.sender);
  for (ParticipantInfo &participant : participants)
    if (participant.name == name)
      merge_declaration(participant, rank, unpack<ParticipantInfo>(std::move(declaration.content)));
  silent.erase(declaration.sender);
}

bool Coordinator::Implementation::has_declared(const std::string &participant) const {
  const auto ranks = world.ranks_of(participant);
  return std::none_of(ranks.begin(), ranks.end(), [this](int rank) { return silent.count(rank) > 0; });
}

/// Of those who want to know the points of somebody who has declared them.
void Coordinator::Implementation::answer_questions() {
  for (auto question = questions.begin(); question != questions.end();) {
    const auto &[rank, wanted] = *question;
    const ParticipantInfo &partner = find_partner(participants, member(rank).first, wanted);
    if (has_declared(partner.name)) {
      mail.post(rank, tag_partner, points_for_others(partner, wanted.point_set));
      question = questions.erase(question);
    } else
      ++question;
  }
  if (!questions.empty() && questions.size() == silent.size())
    throw Failure(ExitCode::handshake, "nobody can declare anything: " + who_asks_whom(world, questions));
}

void Coordinator::Implementation::collect_declarations() {
  for (int r = 0; r < n_ranks; ++r)
    if (r != world.rank())
      silent.insert(r);
  const auto all_came = [&] {
    open_letters();
    answer_questions();
    return silent.empty();
  };
  waiting.until(all_came, [&] { return Awaited{"the declaration of " + who(*silent.begin()), ""}; });
}

void Coordinator::Implementation::post_rows(const RouteTable &table) {
  const auto sources = world.ranks_of(table.from), targets = world.ranks_of(table.to);
  for (std::size_t r = 0; r < sources.size(); ++r)
    mail.post(sources[r], tag_route, table.row_of_source(world, r));
  for (std::size_t r = 0; r < targets.size(); ++r)
    mail.post(targets[r], tag_route, table.row_of_target(world, r));
}

void Coordinator::Implementation::await_all_gone() {
  const auto done = [this] {
    open_letters();
    return n_gone == n_ranks - 1 && recorders.have_all() && traces.size() == n_traced;
  };
  waiting.until(done, [] { return Awaited{"all participants to end", ""}; });
}

void Coordinator::Implementation::order_all_to_leave(int code) {
  leave_code = code;
  for (int r = 0; r < n_ranks; ++r)
    if (r != world.rank() && world.bells().reach(r)) {
      world.bells().counters(r).leave = static_cast<std::uint32_t>(code) + 1;
      world.bells().wake(r);
    } else if (r != world.rank()) {
      MPI_Request request;
      MPI_Isend(&leave_code, 1, MPI_INT, r, tag_leave, world.control(), &request);
      MPI_Request_free(&request);
    }
}

/// After a failure: everybody gets the code and a moment to unwind, i.e. to close files; then all may end.
void Coordinator::Implementation::send_off(int code) {
  order_all_to_leave(code);
  pulse.beat("ending", progress.step());
  const Waiting undisturbed([] {}, [] { return true; }, nullptr);
  const auto all_gone = [this] {
    mail.all_sent();
    while (mail.receive(MPI_ANY_SOURCE, tag_gone))
      ++n_gone;
    return n_gone == n_ranks - 1;
  };
  if (!undisturbed.within(grace_to_leave, all_gone))
    world.abort(code);
  for (int r = 0; r < n_ranks; ++r) {
    if (r != world.rank())
      mail.send(r, tag_exit, {});
  }
  undisturbed.within(grace_to_leave, [this] { return mail.all_sent(); });
}

Coordinator::Coordinator() {
  settle_process(true);
  std::signal(SIGUSR1, [](int) { stop_signal = 1; });
  try {
    implementation_ = std::make_unique<Implementation>();
  } catch (const Unmet &unmet) {
    std::exit(static_cast<int>(unmet.code()));
  }
  keep_to_own_core(implementation_->world.own());
}

Coordinator::~Coordinator() {
  if (implementation_->ended_well) {
    implementation_->recorders.close();
    implementation_->world.finalize();
  } else {
    implementation_.release(); // others may still write into its buffers; the process ends next
  }
}

int Coordinator::run(const std::function<void()> &body) {
  Implementation &all = *implementation_;
  RemoteError remote{0, ""};
  try {
    body();
    if (all.welcomed)
      finish();
  } catch (const RemoteError &other) {
    remote = other;
  } catch (const Failure &failure) {
    remote = {static_cast<int>(failure.code()), std::string("coupler: ") + failure.what()};
  } catch (const std::exception &exception) {
    remote = {unforeseen, std::string("coupler: ") + exception.what()};
  }
  if (remote.code != 0) {
    std::fprintf(stderr, "heartbus: %s\n", remote.text.c_str());
    all.send_off(remote.code);
    return remote.code;
  }
  all.pulse.beat("ending", all.progress.step());
  all.order_all_to_leave(0);
  all.ended_well = true;
  return 0;
}

void Coordinator::handshake(const std::map<std::string, Expected> &expected, const std::string &scene_text,
                            const std::string &output_folder, double deadline_seconds) {
  Implementation &all = *implementation_;
  compare_members(all.world, expected);
  all.waiting.deadline = deadline_seconds;
  for (const auto &[name, who] : expected) {
    const auto ranks = all.world.ranks_of(name);
    ParticipantInfo participant;
    participant.name = name;
    participant.program = who.program;
    participant.n_ranks = ranks.size();
    all.participants.push_back(participant);
    all.mail.post(ranks.front(), tag_command,
                  Welcome{scene_text, output_folder, deadline_seconds, who.settings, who.coupling});
  }
  all.welcomed = true;
  all.collect_declarations();
  all.stage = "working";
}

void Coordinator::trace() {
  for (const ParticipantInfo &participant : implementation_->participants) {
    order(participant.name, {Command::Kind::trace, "", -1, {}});
    implementation_->n_traced += participant.n_ranks;
  }
}

std::vector<Coordinator::RankTrace> Coordinator::finish() {
  Implementation &all = *implementation_;
  for (const ParticipantInfo &participant : all.participants)
    if (all.finished.count(participant.name) == 0)
      order(participant.name, {Command::Kind::finish, "", -1, {}});
  flush();
  all.await_all_gone();
  all.n_traced = 0;
  return std::move(all.traces);
}

const std::vector<ParticipantInfo> &Coordinator::participants() const { return implementation_->participants; }

const ParticipantInfo &Coordinator::participant(const std::string &name) const {
  for (const ParticipantInfo &participant : implementation_->participants)
    if (participant.name == name)
      return participant;
  throw Failure(ExitCode::handshake, "there is no participant '" + name + "'");
}

int Coordinator::connect(const std::string &from, const std::string &to, const std::string &field) {
  Implementation &all = *implementation_;
  const int number = all.tables.size();
  const RouteTable &table = all.tables.emplace_back(number, participant(from), participant(to), field);
  all.route_names.push_back({from, to, field});
  all.post_rows(table);
  order(from, {Command::Kind::connect, "", number, {}});
  order(to, {Command::Kind::connect, "", number, {}});
  return number;
}

Coordinator::Recording Coordinator::record(int route,
                                           std::function<void(const Step &, const std::vector<double> &)> on_values) {
  Implementation &all = *implementation_;
  const RouteTable &table = *std::next(all.tables.begin(), route);
  if (table.field.is_global())
    throw Failure(ExitCode::scene, "field '" + table.field.name + "' belongs to no points and cannot be recorded");
  const auto sources = all.world.ranks_of(table.from);
  for (std::size_t r = 0; r < sources.size(); ++r)
    all.mail.post(sources[r], tag_route, table.row_of_source_to_coupler(all.world, r));
  order(table.from, {Command::Kind::connect, "", route, {}});
  all.recorders.add(all.world, table, std::move(on_values));
  return {table.target_coordinates(), table.field.components, table.field.unit};
}

void Coordinator::order(const std::string &participant, const Command &command) {
  Implementation &all = *implementation_;
  all.queue[this->participant(participant).name].push_back(command);
  all.recorders.ordered(participant, command);
  if (command.kind == Command::Kind::finish)
    all.finished.insert(participant);
}

void Coordinator::flush() {
  Implementation &all = *implementation_;
  for (auto &[name, commands] : all.queue) {
    all.mail.post(all.world.ranks_of(name).front(), tag_command, commands);
    all.progress.sent(name, commands);
  }
  all.queue.clear();
  all.poll();
}

Report Coordinator::wait_report(const std::string &participant) {
  Implementation &all = *implementation_;
  std::deque<Report> &reports = all.reports[participant];
  const auto came = [&] {
    if (reports.empty())
      all.open_letters();
    all.recorders.take_arrived();
    return !reports.empty();
  };
  WaitHistory &history = all.histories[participant];
  const int root = all.world.ranks_of(participant).front();
  history.callers = all.recorders.empty() ? Doorbells::only(root) : Doorbells::anybody;
  // Slow participants are found by the monitor of their progress, command by command.
  constexpr double patience = 100;
  all.waiting.until(
      came,
      [&] {
        return Awaited{"the report of " + participant, ""};
      },
      patience, &history);
  all.waiting.until([&] { return all.recorders.have_what_comes_before_report(participant); },
                    [&] {
                      return Awaited{"what " + participant + " has sent to be recorded", ""};
                    });
  all.recorders.forget_report(participant);
  Report report = std::move(reports.front());
  reports.pop_front();
  return report;
}

std::size_t PointSetInfo::n_points() const {
  std::size_t n = 0;
  for (const auto &of_rank : coordinates)
    n += of_rank.size() / 3;
  return n;
}

Times &Times::operator+=(const Times &more) {
  add(more.commands, commands);
  add(more.parts, parts);
  return *this;
}

int Coordinator::n_overslept() const { return implementation_->waiting.n_overslept(); }

bool Coordinator::stop_requested() const { return stop_signal != 0; }

} // namespace heartbus::bus
