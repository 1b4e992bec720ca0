#include "common/bus/membership.h"

namespace heartbus::bus {

Membership::Membership(const Member &self) : world(self), link(world) {}

std::optional<int> Membership::await_welcome() {
  bool welcomed = false;
  const int code = link.guard([&] {
    welcome = unpack<Welcome>(link.receive_broadcast(1));
    welcomed = true;
  });
  if (!welcomed) {
    if (code == 0)
      world.finalize();
    return code;
  }
  link.set_deadline(welcome.deadline);
  return {};
}

std::string Membership::key(const std::string &setting) const {
  return "participants." + name() + ".settings." + setting;
}

const std::string *Membership::setting(const std::string &key) {
  asked_.insert(key);
  for (const auto *texts : {&welcome.settings, &welcome.coupling})
    if (const auto found = texts->find(key); found != texts->end())
      return &found->second;
  return nullptr;
}

void Membership::check_settings() const {
  std::string known;
  for (const std::string &name : asked_)
    known += (known.empty() ? "" : ", ") + name;
  for (const auto &[name, value] : welcome.settings)
    if (asked_.count(name) == 0)
      throw Failure(ExitCode::scene, "key '" + key(name) + "': this program takes no such setting; it takes " +
                                         (known.empty() ? "none" : known));
}

PartnerPoints Membership::partner(const std::string &participant, const std::string &point_set) {
  link.post(tag_question, Question{participant, point_set});
  return unpack<PartnerPoints>(
      link.receive(tag_partner, "the points '" + point_set + "' of " + participant, participant));
}

} // namespace heartbus::bus
