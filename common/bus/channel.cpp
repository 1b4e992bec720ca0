#include "common/bus/channel.h"

#include <utility>

namespace heartbus::bus {
namespace {

void cancel(MPI_Request &request) {
  MPI_Cancel(&request);
  MPI_Wait(&request, MPI_STATUS_IGNORE);
}

} // namespace

OutgoingChannel::OutgoingChannel(const World &world, int route, Peer peer, std::size_t n_numbers)
    : world_(&world), route_(route), peer_(std::move(peer)), n_numbers_(n_numbers) {
  if (!world.bells().reach(peer_.world_rank)) {
    use_own_buffer();
    return;
  }
  address_ = std::make_unique<BufferAddress>();
  MPI_Irecv(address_.get(), sizeof(BufferAddress), MPI_BYTE, peer_.world_rank, route, world.data(), &request_);
}

void OutgoingChannel::use_buffer_at(const BufferAddress &address) {
  memory_ = std::make_unique<SharedMemory>(address.memory);
  if (!memory_->begin())
    return use_own_buffer();
  buffer_ = reinterpret_cast<MessageBuffer *>(memory_->begin() + address.offset);
  buffer_->shared = 1;
  is_shared_ = true;
}

void OutgoingChannel::use_own_buffer() {
  memory_ = std::make_unique<SharedMemory>(MessageBuffer::bytes(n_numbers_));
  buffer_ = reinterpret_cast<MessageBuffer *>(memory_->begin());
  MPI_Send_init(buffer_->message(0, n_numbers_), n_numbers_, MPI_DOUBLE, peer_.world_rank, route_, world_->data(),
                &request_);
}

bool OutgoingChannel::is_free() {
  int complete = 0;
  if (!buffer_) {
    MPI_Test(&request_, &complete, MPI_STATUS_IGNORE);
    if (!complete)
      return false;
    use_buffer_at(*address_);
  }
  if (!is_shared_) {
    MPI_Test(&request_, &complete, MPI_STATUS_IGNORE);
    return complete;
  }
  const auto has_room = [this] { return buffer_->sent - buffer_->taken < MessageBuffer::n_messages; };
  if (has_room())
    return true;
  buffer_->wanted = 1;
  return has_room(); // otherwise the receiver sees in time that it is wanted
}

void OutgoingChannel::send() {
  if (is_shared_)
    ++buffer_->sent;
  else
    MPI_Start(&request_);
}

bool OutgoingChannel::needs_help() { return buffer_ && !is_shared_ && !is_free(); }

void OutgoingChannel::close() {
  if (!buffer_)
    cancel(request_);
  else if (!is_shared_)
    MPI_Request_free(&request_);
}

IncomingChannel::IncomingChannel(const World &world, int route, Peer peer, std::size_t n_numbers, MessageBuffer *buffer,
                                 const BufferAddress &address)
    : world_(&world), peer_(std::move(peer)), n_numbers_(n_numbers), buffer_(buffer) {
  MPI_Recv_init(buffer_->message(0, n_numbers), n_numbers, MPI_DOUBLE, peer_.world_rank, route, world.data(),
                &request_);
  MPI_Start(&request_);
  if (!world.bells().reach(peer_.world_rank))
    return;
  MPI_Send(&address, sizeof address, MPI_BYTE, peer_.world_rank, route, world.data());
  world.bells().ring(peer_.world_rank);
}

bool IncomingChannel::has_arrived() {
  if (buffer_->shared)
    return buffer_->sent != n_taken_;
  int complete = 0;
  for (int looks = 0; looks < 2 && !complete; ++looks) // the second finds what the first has let in
    MPI_Test(&request_, &complete, MPI_STATUS_IGNORE);
  return complete;
}

void IncomingChannel::take() {
  if (!buffer_->shared) {
    MPI_Start(&request_);
    return;
  }
  buffer_->taken = ++n_taken_;
  if (!buffer_->wanted)
    return;
  buffer_->wanted = 0;
  world_->bells().ring(peer_.world_rank);
}

void IncomingChannel::close() {
  cancel(request_);
  MPI_Request_free(&request_);
}

} // namespace heartbus::bus
