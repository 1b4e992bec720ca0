#include "common/bus/world.h"

#include "common/bus/packer.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <sstream>

namespace heartbus::bus {

const char *const build_id = "heartbus " HEARTBUS_VERSION ", compiler " __VERSION__;

std::string version_of(const std::string &program) {
  return program + " (" + build_id + "), protocol " + std::to_string(protocol_version);
}

World::World(const Member &self) {
  int initialised, provided;
  MPI_Initialized(&initialised);
  owns_mpi_ = !initialised;
  if (owns_mpi_)
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided);
  MPI_Comm_dup(MPI_COMM_WORLD, &control_);
  MPI_Comm_dup(MPI_COMM_WORLD, &data_);
  MPI_Comm_rank(control_, &rank_);
  gather_members(self);

  const std::string message = objection();
  if (!message.empty()) {
    if (rank_ == 0)
      std::fprintf(stderr, "heartbus: %s\n", message.c_str());
    finalize();
    throw Unmet(message);
  }
  const auto is_coupler = [](const Member &member) { return member.coupler; };
  coupler_ = std::find_if(members_.begin(), members_.end(), is_coupler) - members_.begin();
  MPI_Comm_split(control_, ranks_of(members_[rank_].name).front(), rank_, &own_);
  MPI_Comm_dup(own_, &local_);
  bells_.emplace(control_);
  pipes_.emplace(control_);
}

void World::gather_members(const Member &self) {
  Packer packer;
  packer << self.protocol << self.coupler << self.name << self.program << self.build;
  const Bytes mine = packer.take();
  int n_ranks, size = mine.size();
  MPI_Comm_size(control_, &n_ranks);
  std::vector<int> sizes(n_ranks), starts(n_ranks + 1, 0);
  MPI_Allgather(&size, 1, MPI_INT, sizes.data(), 1, MPI_INT, control_);
  for (int r = 0; r < n_ranks; ++r)
    starts[r + 1] = starts[r] + sizes[r];
  Bytes all(starts.back());
  MPI_Allgatherv(mine.data(), size, MPI_BYTE, all.data(), sizes.data(), starts.data(), MPI_BYTE, control_);
  for (int r = 0; r < n_ranks; ++r) {
    Unpacker unpacker(Bytes(all.begin() + starts[r], all.begin() + starts[r + 1]));
    Member member;
    unpacker >> member.protocol;
    if (member.protocol == protocol_version)
      unpacker >> member.coupler >> member.name >> member.program >> member.build;
    else
      member.name = "rank " + std::to_string(r);
    members_.push_back(member);
  }
}

std::string World::objection() const {
  std::ostringstream message;
  const auto came = [this] { return "\n  came: " + who_came(); };
  int n_couplers = 0;
  for (const Member &member : members_) {
    n_couplers += member.coupler;
    if (member.protocol != protocol_version)
      message << member.name << " speaks protocol " << member.protocol << " of the bus instead of " << protocol_version
              << ": build all programs from the same source";
    else if (const Member &first = members_[ranks_of(member.name).front()]; first.program != member.program)
      message << "two programs claim the name '" << member.name << "': " << first.program << " and " << member.program
              << "; give one of them another with --name";
    if (!message.str().empty())
      return message.str() + came();
  }
  if (n_couplers == 1)
    return "";
  if (n_couplers == 0)
    return "nobody in this launch is the coupler; start all programs in one mpirun, the coupler with -n 1" + came();
  return "the coupler needs exactly one rank, but has " + std::to_string(n_couplers) + came();
}

std::vector<int> World::ranks_of(const std::string &name) const {
  std::vector<int> ranks;
  for (std::size_t r = 0; r < members_.size(); ++r)
    if (members_[r].name == name)
      ranks.push_back(r);
  return ranks;
}

Pipe *World::pipe(int rank, bool outwards) const {
  const auto is_root_of = [this](int root, int other) { return ranks_of(members_[other].name).front() == root; };
  const auto end = [&](int owner, Pipe Pipes::*down, Pipe Pipes::*up) {
    return &(pipes_->of(owner)->*(outwards == (owner == rank) ? down : up));
  };
  if (rank == rank_ || !pipes_->of(rank))
    return nullptr;
  if (rank == coupler_ || rank_ == coupler_)
    return end(rank == coupler_ ? rank_ : rank, &Pipes::from_coupler, &Pipes::to_coupler);
  if (members_[rank].name != members_[rank_].name || (!is_root_of(rank, rank_) && !is_root_of(rank_, rank)))
    return nullptr;
  return end(is_root_of(rank, rank_) ? rank_ : rank, &Pipes::from_root, &Pipes::to_root);
}

std::string World::who_came() const {
  std::ostringstream text;
  for (std::size_t r = 0; r < members_.size(); ++r) {
    const auto ranks = ranks_of(members_[r].name);
    if (ranks.front() == static_cast<int>(r))
      text << (r ? ", " : "") << members_[r].name << " (" << members_[r].program << ", " << ranks.size()
           << (ranks.size() == 1 ? " rank)" : " ranks)");
  }
  return text.str();
}

void World::finalize() {
  if (bells_)
    bells_->free();
  if (pipes_)
    pipes_->free();
  for (MPI_Comm *communicator : {&control_, &data_, &own_, &local_})
    if (*communicator != MPI_COMM_NULL)
      MPI_Comm_free(communicator);
  if (owns_mpi_)
    MPI_Finalize();
}

void World::abort(int code) {
  MPI_Abort(MPI_COMM_WORLD, code);
  std::abort(); // MPI_Abort does not return
}

} // namespace heartbus::bus
