#include "common/bus/protocol.h"

namespace heartbus::bus {

Packer &operator<<(Packer &packer, const Welcome &welcome) {
  packer << welcome.scene << welcome.output_folder << welcome.deadline;
  for (const auto *texts : {&welcome.settings, &welcome.coupling}) {
    packer << texts->size();
    for (const auto &[key, value] : *texts)
      packer << key << value;
  }
  return packer;
}
Unpacker &operator>>(Unpacker &unpacker, Welcome &welcome) {
  unpacker >> welcome.scene >> welcome.output_folder >> welcome.deadline;
  for (auto *texts : {&welcome.settings, &welcome.coupling})
    for (auto n = unpacker.read<std::size_t>(); n > 0; --n) {
      const auto key = unpacker.read<std::string>();
      unpacker >> (*texts)[key];
    }
  return unpacker;
}

Packer &operator<<(Packer &packer, const Question &question) {
  return packer << question.participant << question.point_set;
}
Unpacker &operator>>(Unpacker &unpacker, Question &question) {
  return unpacker >> question.participant >> question.point_set;
}

Packer &operator<<(Packer &packer, const PartnerPoints &points) {
  return packer << points.coordinates << points.spacing << points.n_corners << points.faces;
}
Unpacker &operator>>(Unpacker &unpacker, PartnerPoints &points) {
  return unpacker >> points.coordinates >> points.spacing >> points.n_corners >> points.faces;
}

Packer &operator<<(Packer &packer, const Peer &peer) {
  return packer << peer.world_rank << peer.participant << peer.rank << peer.points;
}
Unpacker &operator>>(Unpacker &unpacker, Peer &peer) {
  return unpacker >> peer.world_rank >> peer.participant >> peer.rank >> peer.points;
}

Packer &operator<<(Packer &packer, const RouteRow &row) {
  return packer << row.route << row.outgoing << row.field << row.peers;
}
Unpacker &operator>>(Unpacker &unpacker, RouteRow &row) {
  return unpacker >> row.route >> row.outgoing >> row.field >> row.peers;
}

Packer &operator<<(Packer &packer, const ErrorReport &error) {
  return packer << error.code << error.message << error.waits_for;
}
Unpacker &operator>>(Unpacker &unpacker, ErrorReport &error) {
  return unpacker >> error.code >> error.message >> error.waits_for;
}

Packer &operator<<(Packer &packer, const Command &command) {
  return packer << command.kind << command.task << command.route << command.step;
}
Unpacker &operator>>(Unpacker &unpacker, Command &command) {
  return unpacker >> command.kind >> command.task >> command.route >> command.step;
}

Packer &operator<<(Packer &packer, const Seconds &seconds) {
  packer << seconds.size();
  for (const auto &[name, value] : seconds)
    packer << name << value;
  return packer;
}
Unpacker &operator>>(Unpacker &unpacker, Seconds &seconds) {
  for (auto n = unpacker.read<std::size_t>(); n > 0; --n) {
    const auto name = unpacker.read<std::string>();
    unpacker >> seconds[name];
  }
  return unpacker;
}

Packer &operator<<(Packer &packer, const Report &report) {
  return packer << report.scalars << report.times.commands << report.times.parts << report.cpu_seconds
                << report.peak_memory << report.n_overslept;
}
Unpacker &operator>>(Unpacker &unpacker, Report &report) {
  return unpacker >> report.scalars >> report.times.commands >> report.times.parts >> report.cpu_seconds >>
         report.peak_memory >> report.n_overslept;
}

Packer &operator<<(Packer &packer, const PointSetInfo &set) {
  return packer << set.name << set.spacing << set.coordinates << set.n_corners << set.faces;
}
Unpacker &operator>>(Unpacker &unpacker, PointSetInfo &set) {
  return unpacker >> set.name >> set.spacing >> set.coordinates >> set.n_corners >> set.faces;
}

Packer &operator<<(Packer &packer, const FieldInfo &field) {
  return packer << field.name << field.point_set << field.unit << field.level << field.components << field.output;
}
Unpacker &operator>>(Unpacker &unpacker, FieldInfo &field) {
  return unpacker >> field.name >> field.point_set >> field.unit >> field.level >> field.components >> field.output;
}

Packer &operator<<(Packer &packer, const ScalarInfo &scalar) {
  return packer << scalar.name << scalar.unit << scalar.states;
}
Unpacker &operator>>(Unpacker &unpacker, ScalarInfo &scalar) {
  return unpacker >> scalar.name >> scalar.unit >> scalar.states;
}

Packer &operator<<(Packer &packer, const ParticipantInfo &info) {
  return packer << info.point_sets << info.fields << info.tasks << info.scalars;
}
Unpacker &operator>>(Unpacker &unpacker, ParticipantInfo &info) {
  return unpacker >> info.point_sets >> info.fields >> info.tasks >> info.scalars;
}

std::string describe(const Step &step) {
  return "step " + std::to_string(step.number) + ", iteration " + std::to_string(step.iteration);
}

std::string kind_of_work(const Command &command) {
  switch (command.kind) {
  case Command::Kind::prepare:
    return "prepare";
  case Command::Kind::solve:
    return "solve";
  case Command::Kind::commit:
    return "commit";
  case Command::Kind::task:
    return "task:" + command.task;
  case Command::Kind::send:
    return "send";
  case Command::Kind::receive:
    return "receive";
  case Command::Kind::report:
    return "report";
  case Command::Kind::connect:
    return "connect";
  case Command::Kind::finish:
    return "finish";
  case Command::Kind::save:
    return "save";
  case Command::Kind::load:
    return "load";
  case Command::Kind::refresh:
    return "refresh";
  case Command::Kind::trace:
    return "trace";
  case Command::Kind::notify:
    return "notify";
  case Command::Kind::wait:
    return "wait";
  }
  return "";
}

Mailbox::Mailbox(const World &world) : world_(world) {
  for (int rank = 0; rank < static_cast<int>(world.members().size()); ++rank) {
    if (Pipe *pipe = world.pipe_to(rank))
      writers_.emplace(rank, *pipe);
    if (Pipe *pipe = world.pipe_from(rank))
      readers_.emplace(rank, *pipe);
  }
}

void Mailbox::send(int rank, Tag tag, Bytes bytes) {
  if (const auto pipe = writers_.find(rank); pipe != writers_.end()) {
    pipe->second.post(tag, std::move(bytes));
    return push(rank, pipe->second);
  }
  Outbound &outbound = outbound_.emplace_back(Outbound{std::move(bytes), MPI_REQUEST_NULL});
  MPI_Isend(outbound.bytes.data(), outbound.bytes.size(), MPI_BYTE, rank, tag, world_.control(), &outbound.request);
}

void Mailbox::push(int rank, PipeWriter &pipe) {
  if (pipe.push())
    world_.bells().ring(rank);
}

std::optional<Message> Mailbox::receive(int rank, int tag) {
  for (auto &[sender, pipe] : readers_) {
    while (auto received = pipe.next()) {
      received->sender = sender;
      arrived_.push_back(std::move(*received));
    }
    if (pipe.room_was_wanted())
      world_.bells().ring(sender);
  }
  for (auto received = arrived_.begin(); received != arrived_.end(); ++received)
    if ((rank == MPI_ANY_SOURCE || rank == received->sender) && (tag == MPI_ANY_TAG || tag == received->tag)) {
      std::optional<Message> found = std::move(*received);
      arrived_.erase(received);
      return found;
    }
  return world_.bells().reach_everybody() ? std::nullopt : receive_by_mpi(rank, tag);
}

std::optional<Message> Mailbox::receive_by_mpi(int rank, int tag) {
  int arrived = 0, size = 0;
  MPI_Message message;
  MPI_Status status;
  for (int looks = 0; looks < 2 && !arrived; ++looks) // the second finds what the first has let in
    MPI_Improbe(rank, tag, world_.control(), &arrived, &message, &status);
  if (!arrived)
    return {};
  MPI_Get_count(&status, MPI_BYTE, &size);
  Bytes bytes(size);
  MPI_Mrecv(bytes.data(), size, MPI_BYTE, &message, MPI_STATUS_IGNORE);
  return Message{status.MPI_SOURCE, status.MPI_TAG, std::move(bytes)};
}

void Mailbox::make_progress() const {
  int arrived;
  MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, world_.data(), &arrived, MPI_STATUS_IGNORE);
}

bool Mailbox::all_sent() {
  bool all = true;
  for (auto &[rank, pipe] : writers_)
    if (!pipe.empty()) {
      push(rank, pipe);
      all = all && pipe.empty();
    }
  for (auto outbound = outbound_.begin(); outbound != outbound_.end();) {
    int sent = 0;
    MPI_Test(&outbound->request, &sent, MPI_STATUS_IGNORE);
    outbound = sent ? outbound_.erase(outbound) : std::next(outbound);
  }
  return all && outbound_.empty();
}

} // namespace heartbus::bus
