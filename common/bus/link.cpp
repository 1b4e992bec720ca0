#include "common/bus/link.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>

namespace heartbus::bus {
namespace {

constexpr int unforeseen = 1; ///< exit code of exceptions that are no Failure
constexpr double grace = 3;   ///< [s] for the coupler to answer

} // namespace

Link::Link(World &world)
    : world_(world), mail_(world), waiting_([this] { poll(); }, [this] { return is_sending(); }, &world.bells()) {
  MPI_Comm_rank(world.local(), &local_rank_);
  MPI_Comm_size(world.local(), &local_size_);
  own_ranks_ = world.ranks_of(world.members()[world.rank()].name);
  commands_.callers = Doorbells::only(is_root() ? world.coupler() : own_ranks_.front());
  if (!world.bells().reach(world.coupler()))
    MPI_Irecv(&leave_code_, 1, MPI_INT, world.coupler(), tag_leave, world.control(), &leave_);
}

bool Link::is_sending() {
  return !mail_.all_sent() ||
         std::any_of(outgoing.begin(), outgoing.end(), [](auto &route) { return route.second.needs_help(); });
}

void Link::poll() {
  mail_.all_sent();
  mail_.make_progress();
  if (world_.bells().reach(world_.coupler())) {
    if (const std::uint32_t order = world_.bells().counters(world_.rank()).leave)
      throw LeaveOrder{static_cast<int>(order) - 1};
    return;
  }
  int ordered = 0;
  MPI_Test(&leave_, &ordered, MPI_STATUS_IGNORE);
  if (ordered)
    throw LeaveOrder{leave_code_};
}

Bytes Link::receive_broadcast(double patience) {
  if (!is_root())
    return receive_from(own_ranks_.front(), tag_command, {"its own rank 0 to pass on a command", ""}, patience,
                        &commands_);
  const Bytes bytes =
      receive_from(world_.coupler(), tag_command, {"a command of the coupler", "coupler"}, patience, &commands_);
  for (std::size_t r = 1; r < own_ranks_.size(); ++r)
    mail_.send(own_ranks_[r], tag_command, bytes);
  return bytes;
}

Bytes Link::receive(Tag tag, const std::string &what, const std::string &from) {
  return receive_from(world_.coupler(), tag, {what, from});
}

Bytes Link::receive_from(int world_rank, Tag tag, const Awaited &awaited, double patience, WaitHistory *history) {
  std::optional<Message> received;
  const auto came = [&] {
    received = mail_.receive(world_rank, tag);
    return received.has_value();
  };
  waiting_.until(
      came, [&] { return awaited; }, patience, history);
  return std::move(received->content);
}

void Link::post_progress() {
  if (!is_root())
    return;
  if (world_.bells().reach(world_.coupler()))
    ++world_.bells().counters(world_.rank()).progress;
  else
    mail_.send(world_.coupler(), tag_progress, {});
}

void Link::notify(const std::string &to, std::vector<int> &to_be_rung) {
  const auto ranks = world_.ranks_of(to);
  const Doorbells &bells = world_.bells();
  for (int r = local_rank_; r < static_cast<int>(ranks.size()); r += local_size_)
    if (bells.reach(ranks[r])) {
      ++bells.counters(ranks[r]).turns;
      to_be_rung.push_back(ranks[r]);
    } else
      mail_.send(ranks[r], tag_turn, {});
}

void Link::wait(const std::string &from) {
  const auto ranks = world_.ranks_of(from);
  const int rank = ranks.at(local_rank_ % ranks.size());
  const Awaited awaited{"its turn, which " + from + " passes on", from};
  turns_.callers = Doorbells::only(rank);
  if (!world_.bells().reach(rank)) {
    receive_from(rank, tag_turn, awaited, 1, &turns_);
    return;
  }
  const auto &passed = world_.bells().counters(world_.rank()).turns;
  waiting_.until([&] { return passed != n_turns_taken_; }, [&] { return awaited; }, 1, &turns_);
  ++n_turns_taken_;
}

std::vector<Report> Link::receive_shares() {
  std::vector<Report> shares;
  for (std::size_t r = 1; r < own_ranks_.size(); ++r)
    shares.push_back(unpack<Report>(
        receive_from(own_ranks_[r], tag_share, {"its own rank " + std::to_string(r) + " to report", ""})));
  return shares;
}

void Link::tell_failures(const std::function<void()> &body) {
  try {
    body();
  } catch (const LeaveOrder &) {
    throw;
  } catch (const Late &late) {
    complain({static_cast<int>(late.code()), late.what(), late.waits_for});
  } catch (const Failure &failure) {
    complain({static_cast<int>(failure.code()), failure.what(), ""});
  } catch (const std::exception &exception) {
    complain({unforeseen, exception.what(), ""});
  } catch (...) {
    complain({unforeseen, "an exception of unknown type", ""});
  }
}

int Link::guard(const std::function<void()> &body) {
  try {
    tell_failures(body);
  } catch (const LeaveOrder &order) {
    if (order.code != 0)
      wait_for_exit();
    return order.code;
  }
  return 0;
}

void Link::complain(const ErrorReport &error) {
  post(tag_complaint, error);
  waiting_.within(grace, [] { return false; }); // left by the order to leave
  std::fprintf(stderr, "heartbus: %s (rank %d): %s\n", world_.members()[world_.rank()].name.c_str(), local_rank_,
               error.message.c_str());
  world_.abort(error.code);
}

void Link::wait_for_exit() {
  mail_.send(world_.coupler(), tag_gone, {});
  const Waiting undisturbed([] {}, [] { return true; }, nullptr);
  undisturbed.within(grace, [this] {
    mail_.all_sent();
    return mail_.receive(world_.coupler(), tag_exit).has_value();
  });
}

void Link::wait_for_the_end() {
  mail_.send(world_.coupler(), tag_gone, {});
  try {
    waiting_.until([] { return false; }, [] { return Awaited{"the end of all others", "coupler"}; }, 10);
  } catch (const LeaveOrder &order) {
    if (order.code != 0)
      throw;
  }
}

void Link::connect(const RouteRow &row, unsigned components) {
  if (!row.outgoing) {
    incoming.try_emplace(row.route, world_, row.route, components, row.peers);
    return;
  }
  Outgoing &ends = outgoing.try_emplace(row.route, world_, row.route, components).first->second;
  for (const Peer &peer : row.peers)
    ends.add(peer);
}

void Link::close() {
  for (auto &[route, ends] : outgoing)
    ends.close();
  for (auto &[route, ends] : incoming)
    ends.close();
}

} // namespace heartbus::bus
