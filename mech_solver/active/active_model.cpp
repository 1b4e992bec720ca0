#include "mech_solver/active/active_model.h"

#include "common/base/failure.h"
#include "common/units/nearest.h"
#include "mech_solver/active/force_models.h"

namespace heartbus::mech {

#define HEARTBUS_DECLARE(name, make) std::unique_ptr<ActiveModel> make();
HEARTBUS_FORCE_MODELS(HEARTBUS_DECLARE)
#undef HEARTBUS_DECLARE

std::unique_ptr<ActiveModel> make_active_model(const std::string &name) {
#define HEARTBUS_MAKE(known_name, make)                                                                                \
  if (name == known_name)                                                                                              \
    return make();
  HEARTBUS_FORCE_MODELS(HEARTBUS_MAKE)
#undef HEARTBUS_MAKE
  throw Failure(ExitCode::scene,
                "there is no force model '" + name + "'; there are " + config::joined(force_model_names()));
}

} // namespace heartbus::mech
