#pragma once

#include "common/bus/link.h"
#include "common/bus/world.h"

#include <optional>
#include <set>
#include <string>

namespace heartbus::bus {

/// One process's part in a launch, up to the coupler's welcome. Leaves the process itself alone: neither exits nor
/// touches signals or variables, so that it can live in programs of others.
class Membership {
 public:
  explicit Membership(const Member &self); ///< Unmet

  /// The exit code when the launch ends before it has begun.
  std::optional<int> await_welcome();

  /// What the scene says under `participants.NAME.settings`, else what the coupling asks of this participant
  /// (common/interface/settings.h); null when neither says it.
  const std::string *setting(const std::string &key);
  /// Failure(scene) when there is a setting that nobody has asked for.
  void check_settings() const;
  /// All points of a set of another participant, once that has declared them; collective. Failure(handshake) when there
  /// is no such set.
  PartnerPoints partner(const std::string &participant, const std::string &point_set);

  const std::string &name() const { return world.members()[world.rank()].name; }
  std::string key(const std::string &setting) const; ///< "participants.ep.settings.file"

  World world;
  Link link;
  Welcome welcome;

 private:
  std::set<std::string> asked_; ///< settings
};

} // namespace heartbus::bus
