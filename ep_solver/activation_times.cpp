#include "ep_solver/activation_times.h"

#include "common/fem/on_root.h"
#include "common/fem/owned_points.h"
#include "common/io/hdf5_object.h"
#include "common/mapping/conforming_map.h"
#include "ep_solver/conductivity.h"
#include "ep_solver/eikonal.h"
#include "ep_solver/ionic/transient.h"

#include <algorithm>
#include <cmath>

namespace heartbus::ep {

namespace {

/// Those of the file at the points of all ranks, one rank after the other.
std::vector<double> matched(const std::string &file_name, const std::vector<std::vector<double>> &points,
                            double spacing) {
  const io::Hdf5Object file = io::open_file(file_name, "open the activation times " + file_name);
  std::vector<double> there, times;
  try {
    there = io::read_all<double>(file, "mesh/points", H5T_NATIVE_DOUBLE);
    times = io::read_all<double>(file, "000000/activation_time", H5T_NATIVE_DOUBLE);
  } catch (const Failure &failure) {
    throw Failure(ExitCode::file,
                  file_name + ": " + failure.what() + ": a run leaves such a file as fields/activation.h5");
  }
  if (there.size() != 3 * times.size())
    throw Failure(ExitCode::file, file_name + " has " + std::to_string(times.size()) + " times for " +
                                      std::to_string(there.size() / 3) + " points");
  std::vector<double> result;
  for (const std::size_t k :
       mapping::match_points({"the mesh of " + file_name, {there}, spacing}, {"the mesh of this run", points, spacing}))
    result.push_back(times[k]);
  for (std::size_t k = 0; k < result.size(); ++k)
    if (std::isinf(result[k]) || result[k] < 0)
      throw Failure(ExitCode::file, file_name + ": a time of activation is " + std::to_string(result[k]) +
                                        " s; it must be 0 s at least, or not a number where there is none");
  return result;
}

std::vector<double> eikonal_times(const fem::LagrangeSpace &space, const fem::Fibres &fibres, const IonicModel &model,
                                  const Parameters &parameters) {
  const ConductivityParameters &sigma = parameters.conductivity;
  const double front_speed =
      parameters.eikonal.automatic_speed ? model.front_speed() : parameters.eikonal.speed / std::sqrt(sigma.fibre);
  const double start =
      latency(model, parameters.initial_state, parameters.stimulus.amplitude, parameters.stimulus.duration);
  std::vector<double> times =
      eikonal(space, conductivity(space, fibres, sigma), front_speed, parameters.stimulus.sites, start);
  for (double &time : times)
    if (std::isinf(time)) // a part of the wall without a site
      time = std::nan("");
  return times;
}

} // namespace

std::vector<double> activation_times_of_file(const fem::LagrangeSpace &space, const std::string &file_name) {
  const auto points = dealii::Utilities::MPI::gather(space.communicator(), fem::owned_points(space));
  std::vector<double> all(space.n_global_nodes());
  fem::on_root(space.communicator(), [&] { all = matched(file_name, points, space.smallest_cell_size()); });
  MPI_Bcast(all.data(), int(all.size()), MPI_DOUBLE, 0, space.communicator());
  const auto first = all.begin() + space.first_owned_node();
  return {first, first + space.n_owned_nodes()};
}

std::vector<double> activation_times(const fem::LagrangeSpace &space, const fem::Fibres &fibres,
                                     const IonicModel &model, const Parameters &parameters) {
  if (parameters.model == "eikonal")
    return eikonal_times(space, fibres, model, parameters);
  if (!parameters.prescribed.activation.empty())
    return activation_times_of_file(space, parameters.prescribed.activation);
  return std::vector<double>(space.n_owned_nodes(), 0);
}

} // namespace heartbus::ep
