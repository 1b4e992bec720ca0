#include "common/bus/link.h"

#include <chrono>
#include <cstdio>
#include <thread>

namespace heartbus::bus {
namespace {

constexpr int unforeseen = 1; ///< exit code of exceptions that are no Failure
constexpr double grace = 3;   ///< [s] for the coupler to answer

} // namespace

Link::Link(World &world) : world_(world), mail_(world), waiting_([this] { poll(); }, &world.bells()) {
  MPI_Comm_rank(world.local(), &local_rank_);
  MPI_Comm_size(world.local(), &local_size_);
  own_ranks_ = world.ranks_of(world.members()[world.rank()].name);
  MPI_Irecv(&leave_code_, 1, MPI_INT, world.coupler(), tag_leave, world.control(), &leave_);
}

void Link::poll() {
  mail_.all_sent();
  int ordered = 0;
  MPI_Test(&leave_, &ordered, MPI_STATUS_IGNORE);
  if (ordered)
    throw LeaveOrder{leave_code_};
}

Bytes Link::receive_broadcast(double patience) {
  if (is_root()) {
    const auto came = [this] {
      auto letter = mail_.receive(world_.coupler(), tag_command);
      if (letter)
        bytes_ = std::move(letter->content);
      return letter.has_value();
    };
    waiting_.until(
        came,
        [] {
          return Awaited{"a command of the coupler", "coupler"};
        },
        patience, &commands_);
    size_ = bytes_.size();
  }
  broadcast(&size_, sizeof(size_), patience, is_root() ? nullptr : &commands_);
  bytes_.resize(size_);
  broadcast(bytes_.data(), size_, patience);
  return bytes_;
}

void Link::broadcast(void *data, std::size_t size, double patience, Habit *habit) {
  MPI_Request request;
  MPI_Ibcast(data, size, MPI_BYTE, 0, world_.local(), &request);
  if (is_root())
    ring_own_ranks();
  const auto done = [&request] {
    int complete = 0;
    MPI_Test(&request, &complete, MPI_STATUS_IGNORE);
    return complete != 0;
  };
  waiting_.until(
      done,
      [] {
        return Awaited{"its own rank 0 to pass on a command", ""};
      },
      patience, habit);
}

void Link::ring_own_ranks() const {
  for (std::size_t r = 1; r < own_ranks_.size(); ++r)
    world_.bells().ring(own_ranks_[r]);
}

Bytes Link::receive(Tag tag) {
  Bytes content;
  const auto came = [&] {
    auto letter = mail_.receive(world_.coupler(), tag);
    if (letter)
      content = std::move(letter->content);
    return letter.has_value();
  };
  waiting_.until(came, [] { return Awaited{"a routing table of the coupler", "coupler"}; });
  return content;
}

void Link::post_progress() {
  Packer nothing;
  if (is_root())
    mail_.send(world_.coupler(), tag_progress, nothing);
}

void Link::pass_turn(const std::string &to) {
  const auto ranks = world_.ranks_of(to);
  for (int r = local_rank_; r < static_cast<int>(ranks.size()); r += local_size_) {
    Packer nothing;
    mail_.send(ranks[r], tag_turn, nothing);
  }
}

void Link::take_turn(const std::string &from) {
  const auto ranks = world_.ranks_of(from);
  const int rank = ranks.at(local_rank_ % ranks.size());
  waiting_.until([&] { return mail_.receive(rank, tag_turn).has_value(); },
                 [&] {
                   return Awaited{"its turn, which " + from + " passes on", from};
                 },
                 1, &turns_);
}

std::vector<double> Link::sum(const std::vector<double> &values) {
  summands_ = values;
  sums_.assign(values.size(), 0.);
  MPI_Request request;
  MPI_Ireduce(summands_.data(), sums_.data(), values.size(), MPI_DOUBLE, MPI_SUM, 0, world_.local(), &request);
  if (!is_root())
    world_.bells().ring(own_ranks_.front());
  const auto done = [&request] {
    int complete = 0;
    MPI_Test(&request, &complete, MPI_STATUS_IGNORE);
    return complete != 0;
  };
  waiting_.until(done, [] { return Awaited{"its own ranks to add up their report", ""}; });
  return sums_;
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

void Link::complain(const Complaint &complaint) {
  post(tag_complaint, complaint);
  waiting_.within(grace, [] { return false; }); // left by the order to leave
  std::fprintf(stderr, "heartbus: %s (rank %d): %s\n", world_.members()[world_.rank()].name.c_str(), local_rank_,
               complaint.message.c_str());
  world_.abort(complaint.code);
}

void Link::wait_for_exit() {
  Packer nothing;
  mail_.send(world_.coupler(), tag_gone, nothing);
  const Waiting undisturbed([] {});
  undisturbed.within(grace, [this] {
    mail_.all_sent();
    return mail_.receive(world_.coupler(), tag_exit).has_value();
  });
}

void Link::wait_for_the_end() {
  Packer nothing;
  mail_.send(world_.coupler(), tag_gone, nothing);
  try {
    waiting_.until([] { return false; }, [] { return Awaited{"the end of all others", "coupler"}; }, 10);
  } catch (const LeaveOrder &order) {
    if (order.code != 0)
      throw;
  }
}

void Link::connect(const RouteRow &row, unsigned components) {
  if (!row.outgoing) {
    incoming.try_emplace(row.route, world_.data(), row.route, components, row.peers);
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
