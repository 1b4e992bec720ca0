#pragma once

#include "common/bus/coordinator.h"
#include "common/bus/solver.h"

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace heartbus::bus {

/// Collects what the solver of this rank declares and keeps the way to its data.
class LocalDeclaration : public Declaration {
 public:
  void point_set(const std::string &name, const std::vector<double> &coordinates, double spacing) override;
  void faces(const std::string &point_set, unsigned n_corners, const std::vector<double> &corners) override;
  void output(const std::string &name, const std::string &point_set, unsigned components, const std::string &unit,
              const std::string &level, const std::vector<double> &values) override;
  void input(const std::string &name, const std::string &point_set, unsigned components, const std::string &unit,
             std::vector<double> &values, const std::string &task = "") override;
  void task(const std::string &name, std::function<void(const Step &)> action) override;
  void scalar(const std::string &name, const std::string &unit, std::function<double()> value,
              Combine combine) override;
  void state(const std::string &name, const std::vector<std::string> &names, std::function<int()> value) override;

  struct Field {
    FieldInfo info;
    const std::vector<double> *source = nullptr; ///< of an output
    std::vector<double> *target = nullptr;       ///< of an input
    std::size_t size = 0;                        ///< of the values on this rank
  };
  const Field &field(const std::string &name, bool output) const;
  const std::vector<double> &coordinates(const std::string &point_set) const;
  /// How many values a field has on this rank.
  std::size_t n_values(const std::string &point_set, unsigned components) const;
  const ParticipantInfo &info() const { return info_; } ///< point sets hold this rank's points alone
  const std::map<std::string, std::function<void(const Step &)>> &tasks() const { return tasks_; }
  std::vector<double> scalars() const; ///< of this rank
  /// Takes another rank's scalars into `scalars`.
  void combine(const std::vector<double> &more, std::vector<double> &scalars) const;

 private:
  ParticipantInfo info_;
  std::vector<Field> fields_;
  std::map<std::string, std::function<void(const Step &)>> tasks_;
  struct Scalar {
    std::function<double()> value;
    Combine combine;
  };
  std::vector<Scalar> scalars_;
};

} // namespace heartbus::bus
