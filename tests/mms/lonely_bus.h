#pragma once

#include "common/bus/solver.h"

#include <map>

namespace heartbus::test {

/// A bus for one: keeps what a solver declares.
struct LonelyBus : bus::Declaration {
  std::map<std::string, std::vector<double>> points;
  std::map<std::string, const std::vector<double> *> outputs;
  std::map<std::string, std::vector<double> *> inputs;
  std::map<std::string, std::function<void(const bus::Step &)>> tasks;
  std::map<std::string, std::function<double()>> scalars;
  std::map<std::string, std::function<int()>> states;

  void point_set(const std::string &name, const std::vector<double> &coordinates, double) override {
    points[name] = coordinates;
  }
  void faces(const std::string &, unsigned, const std::vector<double> &) override {}
  void output(const std::string &name, const std::string &, unsigned, const std::string &, const std::string &,
              const std::vector<double> &values) override {
    outputs[name] = &values;
  }
  void input(const std::string &name, const std::string &, unsigned, const std::string &, std::vector<double> &values,
             const std::string &) override {
    inputs[name] = &values;
  }
  void task(const std::string &name, std::function<void(const bus::Step &)> action) override { tasks[name] = action; }
  void scalar(const std::string &name, const std::string &, std::function<double()> value, bus::Combine) override {
    scalars[name] = value;
  }
  void state(const std::string &name, const std::vector<std::string> &, std::function<int()> value) override {
    states[name] = value;
  }
};

} // namespace heartbus::test
