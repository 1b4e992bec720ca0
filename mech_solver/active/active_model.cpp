#include "mech_solver/active/active_model.h"

#include "common/base/failure.h"
#include "mech_solver/active/rdq18_ann.h"

namespace heartbus::mech {

std::unique_ptr<ActiveModel> make_active_model(const std::string &name) {
  if (name == "rdq18_ann")
    return std::make_unique<Rdq18Ann>();
  throw Failure(ExitCode::scene, "unknown active model '" + name + "'; there is: rdq18_ann");
}

} // namespace heartbus::mech
