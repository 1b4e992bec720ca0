#include "common/interface/settings.h"

#include "common/base/failure.h"
#include "common/units/units.h"

#include <algorithm>
#include <vector>

namespace heartbus::interface {
namespace {

const std::vector<std::string> conditions{"merged", "robin", "motion"},
    loads{"merged", "blood_force", "initial_pressure", "cavity_pressure"}, alternations{"steps", "iterations"};
const char unit_of_alpha[] = "kg/(m^2 s)";

template <class Enum>
std::string name_of(Enum value, const std::vector<std::string> &names) {
  return names.at(static_cast<std::size_t>(value));
}

template <class Enum>
void read(const Texts &texts, const std::string &key, const std::vector<std::string> &names, Enum &value) {
  const auto text = texts.find(key);
  if (text == texts.end())
    return;
  const auto name = std::find(names.begin(), names.end(), text->second);
  if (name == names.end())
    throw Failure(ExitCode::handshake, "the coupler asks for the " + key + " '" + text->second +
                                           "' of the interface, which this program does not know: are coupler and "
                                           "programs of the same build?");
  value = static_cast<Enum>(name - names.begin());
}

} // namespace

Texts to_texts(const BloodSettings &settings) {
  return {{"condition", name_of(settings.condition, conditions)},
          {"alpha", config::shortest(settings.alpha) + " " + unit_of_alpha},
          {"alternation", name_of(settings.alternation, alternations)}};
}

Texts to_texts(const WallSettings &settings) {
  return {{"load", name_of(settings.load, loads)}, {"alternation", name_of(settings.alternation, alternations)}};
}

BloodSettings blood_settings(const Texts &texts) {
  BloodSettings settings;
  read(texts, "condition", conditions, settings.condition);
  read(texts, "alternation", alternations, settings.alternation);
  if (const auto alpha = texts.find("alpha"); alpha != texts.end())
    settings.alpha = config::parse_quantity(alpha->second, unit_of_alpha);
  return settings;
}

WallSettings wall_settings(const Texts &texts) {
  WallSettings settings;
  read(texts, "load", loads, settings.load);
  read(texts, "alternation", alternations, settings.alternation);
  return settings;
}

} // namespace heartbus::interface
