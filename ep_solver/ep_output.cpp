#include "ep_solver/ep_output.h"

#include "common/fem/output_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace heartbus::ep {

void EPOutput::write_to(const std::string &folder, const OutputParameters &output) {
  folder_ = folder;
  output_ = output;
  if (output_.every > 0)
    writer_ = std::make_unique<io::FieldWriter>(space_.communicator(), folder, "ep", fem::output_mesh(space_));
}

void EPOutput::go_on_from(double time) {
  if (writer_)
    writer_->go_on_from(time);
}

void EPOutput::write(double time, const double *potential, const double *calcium) {
  writer_->begin(time);
  writer_->nodal("potential", "V", 1, potential);
  writer_->nodal("calcium", "uM", 1, calcium);
  writer_->end();
}

void EPOutput::write_maps(const double *activation, const double *repolarisation) {
  if (folder_.empty())
    return;
  io::FieldWriter map(space_.communicator(), folder_, "activation", fem::output_mesh(space_));
  map.begin(0);
  map.nodal("activation_time", "s", 1, activation);
  map.nodal("repolarisation_time", "s", 1, repolarisation);
  map.end();
}

double last_activation(const std::vector<double> &activation, double now) {
  constexpr double never = std::numeric_limits<double>::infinity();
  double latest = 0;
  for (const double time : activation)
    latest = std::max(latest, time <= now ? time : never);
  return latest == never ? std::numeric_limits<double>::quiet_NaN() : latest;
}

double n_activated(const std::vector<double> &activation, double now) {
  return std::count_if(activation.begin(), activation.end(), [now](double time) { return time <= now; });
}

void declare_activation(bus::Declaration &declaration, const fem::LagrangeSpace &space,
                        const std::vector<double> &activation, const double &now) {
  const double n_nodes = dealii::Utilities::MPI::sum(double(space.n_owned_nodes()), space.communicator());
  declaration.scalar(
      "activation_time", "s", [&] { return last_activation(activation, now); }, bus::Combine::max);
  declaration.scalar(
      "activated_share", "1", [&, n_nodes] { return n_activated(activation, now) / n_nodes; }, bus::Combine::sum);
}

} // namespace heartbus::ep
