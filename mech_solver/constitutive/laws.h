#pragma once

#include "mech_solver/constitutive/headers.h" // made by CMake: the headers of this folder

#include <string>
#include <variant>
#include <vector>

/// The constitutive laws there are: the struct, and its name in the scene, which is that of its header. One line a law.
#define HEARTBUS_LAWS(law)                                                                                             \
  law(Guccione, guccione) law(HolzapfelOgden, holzapfel_ogden) law(NeoHookean, neo_hookean)                            \
      law(SaintVenantKirchhoff, saint_venant_kirchhoff) /* by name */

namespace heartbus::mech {

template <class, class... Laws>
struct OneOf {
  using type = std::variant<Laws...>;
};
#define HEARTBUS_TYPE(Law, name) , Law
using Law = OneOf<void HEARTBUS_LAWS(HEARTBUS_TYPE)>::type;
#undef HEARTBUS_TYPE

/// In the order of the list.
inline std::vector<std::string> law_names() {
  std::vector<std::string> names;
#define HEARTBUS_NAME(Law, name) names.emplace_back(#name);
  HEARTBUS_LAWS(HEARTBUS_NAME)
#undef HEARTBUS_NAME
  return names;
}

} // namespace heartbus::mech
