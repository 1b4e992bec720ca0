#include "api/heartbus.h"

#include "common/bus/membership.h"
#include "common/bus/server.h"
#include "common/units/units.h"

#include <cstdlib>
#include <deque>
#include <stdexcept>

using namespace heartbus;

/// One process's membership, and what it has declared: arrays and texts that stay where they are.
struct heartbus_bus {
  explicit heartbus_bus(const bus::Member &self) : membership(self), server(membership.link) {}

  /// False when the launch is over, or ends here because of `body`.
  template <class Body>
  bool does(const Body &body) {
    if (exit_code)
      return false;
    bool done = false;
    const int code = membership.link.guard([&] {
      body();
      done = true;
    });
    if (!done)
      exit_code = code;
    return done;
  }
  int code() const { return exit_code.value_or(0); }
  void open();
  std::vector<double> &array(const char *point_set, int components);

  bus::Membership membership;
  bus::Server server;
  bool is_open = false;
  std::optional<int> exit_code; ///< once the launch is over for this process
  std::deque<std::vector<double>> arrays;
  std::deque<double> numbers;
  std::deque<bus::PartnerPoints> partners;
};

void heartbus_bus::open() {
  if (is_open)
    return;
  membership.check_settings();
  server.open({});
  is_open = true;
}

/// Never without memory: its address is what the caller gets.
std::vector<double> &heartbus_bus::array(const char *point_set, int components) {
  if (components < 1)
    throw Failure(ExitCode::handshake, "a field needs at least one component, not " + std::to_string(components));
  const std::size_t n = server.declaration().n_values(point_set, components);
  std::vector<double> &values = arrays.emplace_back();
  values.reserve(n > 0 ? n : 1);
  values.resize(n);
  return values;
}

namespace {

void require_closed(const heartbus_bus *bus, const std::string &what) {
  if (bus->is_open)
    throw Failure(ExitCode::handshake, what + " is declared after the first order; declare everything before");
}

std::string text(const char *words) { return words ? words : ""; }

constexpr int unforeseen = 1;

int what(const bus::Command &command) {
  using Kind = bus::Command::Kind;
  switch (command.kind) {
  case Kind::prepare:
    return HEARTBUS_PREPARE;
  case Kind::solve:
    return HEARTBUS_SOLVE;
  case Kind::commit:
    return HEARTBUS_COMMIT;
  case Kind::task:
    return HEARTBUS_TASK;
  case Kind::save:
    return HEARTBUS_SAVE;
  case Kind::load:
    return HEARTBUS_LOAD;
  case Kind::refresh:
    return HEARTBUS_REFRESH;
  default:
    return HEARTBUS_FINISH;
  }
}

} // namespace

int heartbus_join(heartbus_bus **bus, const char *name, const char *program) {
  *bus = nullptr;
  const char *given = std::getenv("HEARTBUS_NAME");
  try {
    auto *joined = new heartbus_bus({given ? given : text(name), text(program), bus::build_id});
    if (const auto code = joined->membership.await_welcome())
      return *code; // others may still write into its memory: it is left to the end of the process
    *bus = joined;
    return 0;
  } catch (const bus::Unmet &unmet) {
    return static_cast<int>(unmet.code());
  }
}

int heartbus_communicator(heartbus_bus *bus) { return MPI_Comm_c2f(bus->membership.world.own()); }

int heartbus_setting(heartbus_bus *bus, const char *key, const char *unit, double *value) {
  bus->does([&] {
    const std::string *written = bus->membership.setting(key);
    try {
      if (written)
        *value = config::parse_quantity(*written, unit);
    } catch (const std::invalid_argument &error) {
      throw Failure(ExitCode::scene, "key '" + bus->membership.key(key) + "': " + error.what());
    }
  });
  return bus->code();
}

const char *heartbus_setting_text(heartbus_bus *bus, const char *key, const char *fallback) {
  const char *value = fallback;
  bus->does([&] {
    if (const std::string *written = bus->membership.setting(key))
      value = written->c_str();
  });
  return value;
}

const char *heartbus_scene(heartbus_bus *bus) { return bus->membership.welcome.scene.c_str(); }
const char *heartbus_folder(heartbus_bus *bus) { return bus->membership.welcome.output_folder.c_str(); }

int heartbus_partner(heartbus_bus *bus, const char *participant, const char *point_set,
                     heartbus_partner_points *points) {
  *points = {};
  bus->does([&] {
    require_closed(bus, "what depends on the points of " + text(participant));
    const bus::PartnerPoints &got = bus->partners.emplace_back(bus->membership.partner(participant, point_set));
    const int n_faces = got.n_corners > 0 ? static_cast<int>(got.faces.size() / got.n_corners) : 0;
    *points = {static_cast<int>(got.coordinates.size() / 3),
               got.coordinates.data(),
               got.spacing,
               n_faces,
               static_cast<int>(got.n_corners),
               got.faces.data()};
  });
  return bus->code();
}

int heartbus_points(heartbus_bus *bus, const char *name, int n_points, const double *points, double spacing) {
  bus->does([&] {
    require_closed(bus, "point set '" + text(name) + "'");
    if (text(name).empty())
      throw Failure(ExitCode::handshake, "a point set needs a name: fields without one are global");
    if (n_points < 0 || (n_points > 0 && !(spacing > 0)))
      throw Failure(ExitCode::handshake, "point set '" + text(name) + "' needs a positive spacing [m]");
    bus->server.declaration().point_set(name, std::vector<double>(points, points + 3 * std::size_t(n_points)), spacing);
  });
  return bus->code();
}

double *heartbus_output(heartbus_bus *bus, const char *field, const char *point_set, int components, const char *unit) {
  double *values = nullptr;
  bus->does([&] {
    require_closed(bus, "field '" + text(field) + "'");
    std::vector<double> &array = bus->array(point_set, components);
    bus->server.declaration().output(field, text(point_set), components, unit, "", array);
    values = array.data();
  });
  return values;
}

double *heartbus_input(heartbus_bus *bus, const char *field, const char *point_set, int components, const char *unit) {
  double *values = nullptr;
  bus->does([&] {
    require_closed(bus, "field '" + text(field) + "'");
    std::vector<double> &array = bus->array(point_set, components);
    bus->server.declaration().input(field, text(point_set), components, unit, array);
    values = array.data();
  });
  return values;
}

double *heartbus_scalar(heartbus_bus *bus, const char *name, const char *unit, int combine) {
  double *place = nullptr;
  bus->does([&] {
    require_closed(bus, "scalar '" + text(name) + "'");
    if (combine < HEARTBUS_FIRST || combine > HEARTBUS_SUM)
      throw Failure(ExitCode::handshake, "scalar '" + text(name) + "': " + std::to_string(combine) +
                                             " is no way to combine the values of ranks");
    double *number = &bus->numbers.emplace_back(0);
    const auto how = static_cast<bus::Combine>(combine);
    bus->server.declaration().scalar(
        name, unit, [number] { return *number; }, how);
    place = number;
  });
  return place;
}

int heartbus_task(heartbus_bus *bus, const char *name) {
  bus->does([&] {
    require_closed(bus, "task '" + text(name) + "'");
    bus->server.declaration().task(name, nullptr);
  });
  return bus->code();
}

int heartbus_next(heartbus_bus *bus, heartbus_order *order) {
  *order = {HEARTBUS_END, 0, 0, 0, 0, ""};
  bus->does([&] {
    bus->open();
    if (const bus::Command *command = bus->server.next())
      *order = {what(*command),     command->step.number, command->step.iteration,
                command->step.time, command->step.size,   command->task.c_str()};
  });
  return order->what;
}

int heartbus_fail(heartbus_bus *bus, int code, const char *message) {
  bus->does([&] {
    const bool known = code > HEARTBUS_UNFORESEEN && code <= HEARTBUS_FILE;
    throw Failure(static_cast<ExitCode>(known ? code : unforeseen), message);
  });
  return bus->code();
}

int heartbus_leave(heartbus_bus *bus) {
  bus->does([&] {
    if (!bus->server.has_finished())
      throw Failure(ExitCode::handshake,
                    "it leaves before the end of the run, when heartbus_next has not returned HEARTBUS_END yet");
    bus->membership.link.wait_for_the_end();
  });
  if (const int code = bus->code())
    return code; // others may still write into its memory: it is left to the end of the process
  bus->membership.link.close();
  bus->membership.world.finalize();
  delete bus;
  return 0;
}

int heartbus_protocol(void) { return bus::protocol_version; }
