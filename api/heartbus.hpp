// C++17 on top of heartbus.h: no more than exceptions, strings and the end of scopes.
//
//     int main() {
//       return heartbus::participate("ep", "my_ep", [](heartbus::Bus &bus) {
//         ... bus.points, bus.output, bus.input, bus.task, bus.scalar ...
//         while (const heartbus::Order order = bus.next()) // or heartbus::serve(bus, solver)
//           if (order.what == HEARTBUS_SOLVE)
//             ...
//       });
//     }
#pragma once

#include "heartbus/heartbus.h"

#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

namespace heartbus {

/// Ends the launch with an exit code of its own, e.g. HEARTBUS_NOT_CONVERGED.
class Failed : public std::runtime_error {
 public:
  Failed(int code, const std::string &message) : std::runtime_error(message), code(code) {}
  const int code;
};

/// The launch is over, because of somebody else or of what has been said already.
class Over : public std::exception {};

struct Order : heartbus_order {
  explicit operator bool() const { return what != HEARTBUS_END; }
};

/// Values of a field: an array of the bus, which stays where it is.
struct Values {
  double *data = nullptr;
  std::size_t size = 0;
  double &operator[](std::size_t i) const { return data[i]; }
  double *begin() const { return data; }
  double *end() const { return data + size; }
};

/// Meaning, shapes and units: heartbus.h.
class Bus {
 public:
  explicit Bus(heartbus_bus *bus) : bus_(bus) {}

  int communicator() { return heartbus_communicator(bus_); } ///< for MPI_Comm_f2c
  std::string scene() { return heartbus_scene(bus_); }
  std::string folder() { return heartbus_folder(bus_); }
  double setting(const std::string &key, const std::string &unit, double value) {
    check(heartbus_setting(bus_, key.c_str(), unit.c_str(), &value));
    return value;
  }
  std::string text(const std::string &key, const std::string &fallback) {
    return heartbus_setting_text(bus_, key.c_str(), fallback.c_str());
  }
  heartbus_partner_points partner(const std::string &participant, const std::string &point_set) {
    heartbus_partner_points points;
    check(heartbus_partner(bus_, participant.c_str(), point_set.c_str(), &points));
    return points;
  }
  void points(const std::string &name, const std::vector<double> &points, double spacing) {
    check(heartbus_points(bus_, name.c_str(), int(points.size() / 3), points.data(), spacing));
    sets_.push_back({name, points.size() / 3});
  }
  Values output(const std::string &field, const std::string &set, int components, const std::string &unit) {
    return values(heartbus_output(bus_, field.c_str(), set.c_str(), components, unit.c_str()), set, components);
  }
  Values input(const std::string &field, const std::string &set, int components, const std::string &unit) {
    return values(heartbus_input(bus_, field.c_str(), set.c_str(), components, unit.c_str()), set, components);
  }
  double &scalar(const std::string &name, const std::string &unit, int combine = HEARTBUS_FIRST) {
    return *present(heartbus_scalar(bus_, name.c_str(), unit.c_str(), combine));
  }
  void task(const std::string &name) { check(heartbus_task(bus_, name.c_str())); }
  Order next() {
    Order order;
    heartbus_next(bus_, &order);
    return order;
  }

 private:
  struct Set {
    std::string name;
    std::size_t n_points;
  };
  static void check(int code) {
    if (code != 0)
      throw Over();
  }
  static double *present(double *values) {
    if (!values)
      throw Over();
    return values;
  }
  Values values(double *data, const std::string &name, int components) const {
    std::size_t n = 1;
    for (const Set &set : sets_)
      if (set.name == name)
        n = set.n_points;
    return {present(data), n * components};
  }
  heartbus_bus *bus_;
  std::vector<Set> sets_;
};

/// What is done at each order, for `serve`; what is not overridden is passed over.
class Solver {
 public:
  virtual ~Solver() = default;
  virtual void prepare(const Order &) {}
  virtual void solve(const Order &) = 0;
  virtual void commit(const Order &) {}
  virtual void task(const Order &) {}
  virtual void save(const Order &) {}
  virtual void load(const Order &) {}
  virtual void refresh(const Order &) {}
  virtual void finish(const Order &) {}
};

/// The loop over the orders, to the end of the run.
inline void serve(Bus &bus, Solver &solver) {
  while (const Order order = bus.next())
    switch (order.what) {
    case HEARTBUS_PREPARE: solver.prepare(order); break;
    case HEARTBUS_SOLVE: solver.solve(order); break;
    case HEARTBUS_COMMIT: solver.commit(order); break;
    case HEARTBUS_TASK: solver.task(order); break;
    case HEARTBUS_SAVE: solver.save(order); break;
    case HEARTBUS_LOAD: solver.load(order); break;
    case HEARTBUS_REFRESH: solver.refresh(order); break;
    case HEARTBUS_FINISH: solver.finish(order); break;
    }
}

/// Joins, runs `body` and leaves; an exception ends the launch with its message. Returns the exit code of the program.
template <class Body>
int participate(const std::string &name, const std::string &program, const Body &body) {
  heartbus_bus *joined = nullptr;
  if (const int code = heartbus_join(&joined, name.c_str(), program.c_str()))
    return code;
  Bus bus(joined);
  try {
    body(bus);
  } catch (const Over &) {
  } catch (const Failed &failed) {
    return heartbus_fail(joined, failed.code, failed.what());
  } catch (const std::exception &exception) {
    return heartbus_fail(joined, HEARTBUS_UNFORESEEN, exception.what());
  }
  return heartbus_leave(joined);
}

} // namespace heartbus
