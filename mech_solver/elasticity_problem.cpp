#include "mech_solver/elasticity_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace heartbus::mech {

using fem::n_lanes;

/// Aligned, so that no access crosses a cache line.
struct ElasticityProblem::CellData {
  alignas(64) std::array<VectorizedDouble, 3 * max_nodes_per_cell> displacement, inertia;
  alignas(64) std::array<VectorizedDouble, max_nodes_per_cell> tension;
};

namespace {

/// What is wrong with a cell, given its centre at rest and its displacement [m], and where to look for the cause.
std::string complaint(bool crushed, double value, const std::array<double, 6> &cell, double time) {
  std::ostringstream text;
  text.precision(4);
  const auto show_point = [&](double x, double y, double z) {
    text << "(" << 1e3 * x << ", " << 1e3 * y << ", " << 1e3 * z << ") mm";
  };
  text << "t = " << time << " s: the wall is " << (crushed ? "crushed" : "overstretched") << " in the cell around ";
  show_point(cell[0], cell[1], cell[2]);
  text << " at rest, ";
  show_point(cell[0] + cell[3], cell[1] + cell[4], cell[2] + cell[5]);
  text.precision(6);
  if (crushed)
    text
        << " now: J = det F = " << value << ", the least allowed is " << smallest_J
        << ". Look at the tension (mechanics.active: tension_max, and sarcomere_length, beyond 1.7 to 2.3 um the force "
           "model clamps it), at kappa, at the fibres there (at the apex their direction is singular), at time.step";
  else
    text << " now: the exponent of its law is " << value << ", the largest allowed is " << largest_exponent
         << ". Look at the pressures, at the stiffness of the law, at time.step";
  return text.str();
}

ActiveFibres::Tension kind_of_tension(const ActiveParameters &active) {
  using Tension = ActiveFibres::Tension;
  return active.model != "prescribed"  ? Tension::of_force_model
         : active.measure == "nominal" ? Tension::nominal
                                       : Tension::second_piola;
}

} // namespace

ElasticityProblem::ElasticityProblem(const fem::LagrangeSpace &space, const fem::Fibres &fibres,
                                     const Parameters &parameters)
    : past(4, space.make_vector(3)), tension(space.make_vector(1)), load(past[0]), space_(space), fibres_(fibres),
      solver_(parameters.solver), gravity_{parameters.gravity[0], parameters.gravity[1], parameters.gravity[2]},
      mean_dilatation_(parameters.volume == "mean_dilatation"), active_fibres_{parameters.active.sarcomere_length,
                                                                               kind_of_tension(parameters.active)},
      regions_(material_regions(space, parameters)), pericardium_(space, parameters.pericardium), acceleration_(load),
      velocity_(load), tangent_(space, 3), rounded_tangent_(tangent_.pattern(), 3), tangent_solver_(parameters.solver) {
  if (mean_dilatation_ && space.nodes_per_cell() == 4)
    throw Failure(ExitCode::scene,
                  "mechanics.volume: mean_dilatation has no effect on linear tetrahedra, in which J is "
                  "constant and which lock for large kappa; take hexahedra, or 'penalty'");
  constrain(parameters);
  // What a strain of 1e-5 makes on a face of a cell: below, round-off of the stresses would be what is compared.
  const double kappa = std::visit([](const auto &law) { return law.kappa; }, regions_[0].law);
  negligible_force_ = 1e-5 * kappa * std::pow(space.smallest_cell_size(), 2);
  if (space.has_label("interface"))
    interface_.emplace_back(space, "interface");
  for (const auto &[name, load] : parameters.loads)
    loads_.push_back({load, LoadedSurface(space, load.label)});
}

void ElasticityProblem::constrain(const Parameters &parameters) {
  constrained_.assign(3 * space_.n_local_nodes(), 0);
  for (const auto &label : parameters.fixed)
    fem::fix_vector(space_, 3, label, constrained_);
  for (const auto &label : parameters.rollers)
    fem::fix_normal(space_, 3, label, constrained_);
  tangent_.set_constraints(constrained_);
}

void ElasticityProblem::forget_tangent() {
  has_tangent_ = false;
  tangent_solver_.forget_preconditioner();
}

std::array<double, 6> ElasticityProblem::centre(unsigned slot, const fem::Vector &d) const {
  std::array<double, 6> place{};
  const unsigned *nodes = space_.cell_nodes(slot), n = space_.nodes_per_cell();
  for (unsigned a = 0; a < n; ++a)
    for (unsigned i = 0; i < 3; ++i) {
      place[i] += space_.points()[nodes[a]][i] / n;
      place[3 + i] += d.begin()[3 * nodes[a] + i] / n;
    }
  return place;
}

void ElasticityProblem::refuse() const {
  const MPI_Comm communicator = space_.communicator();
  // not a number is worse than any
  const double own_J = std::isfinite(smallest_J_) ? smallest_J_ : -std::numeric_limits<double>::max();
  const double J = dealii::Utilities::MPI::min(own_J, communicator),
               exponent = dealii::Utilities::MPI::max(largest_exponent_, communicator);
  const bool crushed = !(J > mech::smallest_J);
  if (!crushed && exponent < mech::largest_exponent)
    return;
  const bool mine = crushed ? own_J == J : largest_exponent_ == exponent;
  const unsigned rank = dealii::Utilities::MPI::this_mpi_process(communicator),
                 owner = dealii::Utilities::MPI::min(mine ? rank : ~0u, communicator);
  std::array<double, 6> cell = crushed ? crushed_cell_ : stretched_cell_;
  MPI_Bcast(cell.data(), 6, MPI_DOUBLE, owner, communicator);
  throw Failure(ExitCode::not_finite, complaint(crushed, crushed ? J : exponent, cell, time));
}

void ElasticityProblem::set_mode(double dt) {
  if (dt != dt_)
    forget_tangent();
  dt_ = dt;
  tangent_solver_.is_static = dt == 0;
}

fem::NewtonSettings ElasticityProblem::newton_settings() const {
  fem::NewtonSettings settings;
  settings.residual_tolerance = solver_.residual_tolerance;
  settings.update_tolerance = solver_.update_tolerance * space_.smallest_cell_size();
  settings.max_iterations = solver_.max_iterations;
  return settings;
}

void ElasticityProblem::begin_dynamic(double dt) {
  set_mode(dt);
  past[0].update_ghost_values();
  past[1].update_ghost_values();
  tension.update_ghost_values();
}

fem::NewtonStatistics ElasticityProblem::solve_dynamic(double dt, fem::Vector &d) {
  begin_dynamic(dt);
  return fem::newton("elastodynamics", *this, d, newton_settings(), &past[0]);
}

/// Without inertia the tangent changes a lot from one iterate to the next, and steps must be kept short.
fem::NewtonStatistics ElasticityProblem::solve_static(fem::Vector &d) {
  set_mode(0);
  has_tangent_ = false;
  tension.update_ghost_values();
  fem::NewtonSettings settings = newton_settings();
  settings.contraction = 0;
  settings.largest_update = 5e-3;
  // What bends strains in second order first, and the stiff part of the residual grows before it falls: backtracking
  // would creep. Who loads in steps takes a shorter one where this does not converge.
  settings.growth = 1e4;
  return fem::newton("quasi-static elasticity", *this, d, settings);
}

double ElasticityProblem::own_volume_at_rest() const {
  double volume = 0;
  for (unsigned slot = 0; slot < space_.n_slots(); ++slot)
    for (unsigned q = 0; q < space_.n_q() && space_.slot_owned(slot); ++q)
      volume += space_.JxW(slot / n_lanes)[q][slot % n_lanes];
  return volume;
}

void ElasticityProblem::solid_forces(const fem::Vector &d, fem::Vector &r) {
  const double dt = dt_;
  dt_ = 0;
  const fem::GhostValues ghosts(d), ghosts_of_tension(tension);
  r = 0;
  add_cells(d, r);
  pericardium_.add_force(d, nullptr, r);
  add_loads(d, r);
  r.zero_out_ghost_values();
  fem::zero_constrained(r, constrained_);
  dt_ = dt;
}

void ElasticityProblem::active_forces(const fem::Vector &d, const fem::Vector &tension_change, fem::Vector &r) const {
  const fem::GhostValues ghosts(d), ghosts_of_tension(tension_change);
  r = 0;
  CellData data;
  alignas(64) std::array<VectorizedDouble, 3 * max_nodes_per_cell> forces;
  for (const MaterialRegion &region : regions_)
    for (unsigned batch = 0; batch < space_.n_batches() && region.contracts; ++batch)
      if (region.in_batch[batch]) {
        forces.fill(VectorizedDouble{});
        add_active_force(gather(batch, region, d, tension_change, data), forces.data());
        scatter(batch, forces.data(), 3, r);
      }
  r.zero_out_ghost_values();
  fem::zero_constrained(r, constrained_);
}

fem::Vector ElasticityProblem::interface_area(const fem::Vector &d) const {
  const fem::GhostValues ghosts(d);
  fem::Vector area = space_.make_vector(3);
  for (const auto &surface : interface_)
    surface.add_force(1, d, area);
  area.zero_out_ghost_values();
  return area;
}

fem::Vector ElasticityProblem::unit_pressure_force() const {
  fem::Vector b = space_.make_vector(3);
  for (const auto &surface : interface_)
    surface.add_force(1, past[0], b);
  b.zero_out_ghost_values();
  fem::zero_constrained(b, constrained_);
  return b;
}

void ElasticityProblem::fibre_stretch(const fem::Vector &d, fem::Vector &stretch) const {
  const fem::GhostValues ghosts(d);
  fem::Vector weight(stretch);
  stretch = 0;
  weight = 0;
  CellData data;
  alignas(64) std::array<VectorizedDouble, max_nodes_per_cell> numerators, weights;
  for (const MaterialRegion &region : regions_)
    for (unsigned batch = 0; batch < space_.n_batches() && region.contracts; ++batch)
      if (region.in_batch[batch]) {
        numerators.fill(VectorizedDouble{});
        weights.fill(VectorizedDouble{});
        add_stretch_projection(gather(batch, region, d, tension, data), numerators.data(), weights.data());
        scatter(batch, numerators.data(), 1, stretch);
        scatter(batch, weights.data(), 1, weight);
      }
  for (unsigned node = 0; node < space_.n_owned_nodes(); ++node)
    stretch.begin()[node] = weight.begin()[node] > 0 ? std::sqrt(stretch.begin()[node] / weight.begin()[node]) : 1.0;
  stretch.zero_out_ghost_values();
}

void ElasticityProblem::update_time_terms(const fem::Vector &d) {
  const double *now = d.begin(), *n = past[0].begin(), *nm1 = past[1].begin();
  for (unsigned i = 0; i < 3 * space_.n_local_nodes(); ++i) {
    acceleration_.begin()[i] = dt_ > 0 ? (now[i] - 2 * n[i] + nm1[i]) / (dt_ * dt_) : 0;
    velocity_.begin()[i] = dt_ > 0 ? (now[i] - n[i]) / dt_ : 0;
  }
}

ElasticityCells ElasticityProblem::gather(unsigned batch, const MaterialRegion &region, const fem::Vector &d,
                                          const fem::Vector &tension, CellData &data) const {
  const unsigned n = space_.nodes_per_cell();
  for (unsigned lane = 0; lane < n_lanes; ++lane) {
    const unsigned *nodes = space_.cell_nodes(batch * n_lanes + lane);
    for (unsigned a = 0; a < n; ++a) {
      data.tension[a][lane] = region.contracts ? tension.begin()[nodes[a]] : 0;
      for (unsigned i = 0; i < 3; ++i) {
        data.displacement[3 * a + i][lane] = d.begin()[nodes[a] * 3 + i];
        data.inertia[3 * a + i][lane] =
            region.density * (acceleration_.begin()[nodes[a] * 3 + i] - load_share * gravity_[i]);
      }
    }
  }
  ElasticityCells cells;
  cells.nodes_per_cell = n;
  cells.n_q = space_.n_q();
  cells.shapes = space_.shapes();
  cells.gradients = space_.gradients(batch);
  cells.JxW = &region.JxW[std::size_t(batch) * space_.n_q()];
  cells.frames = fibres_.frames(batch);
  cells.dispersion = fibres_.dispersion(batch);
  cells.fibres = active_fibres_;
  cells.displacement = data.displacement.data();
  cells.inertia = data.inertia.data();
  cells.tension = data.tension.data();
  cells.mass = dt_ > 0 ? region.density / (dt_ * dt_) : 0;
  cells.mean_dilatation = mean_dilatation_;
  return cells;
}

void ElasticityProblem::scatter(unsigned batch, const VectorizedDouble *values, unsigned components,
                                fem::Vector &r) const {
  for (unsigned lane = 0; lane < n_lanes; ++lane) {
    const unsigned slot = batch * n_lanes + lane, *nodes = space_.cell_nodes(slot);
    for (unsigned a = 0; a < space_.nodes_per_cell() && space_.slot_used(slot); ++a)
      for (unsigned i = 0; i < components; ++i)
        r.begin()[nodes[a] * components + i] += values[components * a + i][lane];
  }
}

void ElasticityProblem::note_limits(unsigned batch, const DeformationLimits &limits) {
  for (unsigned lane = 0; lane < n_lanes; ++lane) {
    if (limits.J[lane] < smallest_J_) {
      smallest_J_ = limits.J[lane];
      most_crushed_ = batch * n_lanes + lane;
    }
    if (limits.exponent[lane] > largest_exponent_) {
      largest_exponent_ = limits.exponent[lane];
      most_stretched_ = batch * n_lanes + lane;
    }
    if (space_.slot_owned(batch * n_lanes + lane))
      own_volume_ += limits.volume[lane];
  }
}

/// Inertia and stress. Expects ghost values of d.
void ElasticityProblem::add_cells(const fem::Vector &d, fem::Vector &r) {
  update_time_terms(d);
  smallest_J_ = 1e300;
  largest_exponent_ = own_volume_ = 0;
  CellData data;
  alignas(64) std::array<VectorizedDouble, 3 * max_nodes_per_cell> forces;
  for (const MaterialRegion &region : regions_)
    for (unsigned batch = 0; batch < space_.n_batches(); ++batch)
      if (region.in_batch[batch]) {
        DeformationLimits limits;
        forces.fill(VectorizedDouble{});
        const ElasticityCells cells = gather(batch, region, d, tension, data);
        std::visit([&](const auto &law) { add_residual(law, cells, forces.data(), limits); }, region.law);
        note_limits(batch, limits);
        scatter(batch, forces.data(), 3, r);
      }
}

/// Of the scene. Expects ghost values of d.
void ElasticityProblem::add_loads(const fem::Vector &d, fem::Vector &r) const {
  for (const auto &[parameters, surface] : loads_) {
    if (const double pressure = load_share * parameters.pressure.at(time); pressure != 0)
      surface.add_force(pressure, d, r);
    const auto &t = parameters.traction;
    const double share = -load_share * parameters.share.at(time); // as an inner force
    if (t[0] != 0 || t[1] != 0 || t[2] != 0)
      surface.add_traction({share * t[0], share * t[1], share * t[2]}, r);
  }
}

fem::ResidualSize ElasticityProblem::residual(const fem::Vector &d, fem::Vector &r) {
  const bus::Stopwatch::Section section(stopwatch, "residual");
  const fem::GhostValues ghosts(d);
  r = 0;
  add_cells(d, r);
  const double own_forces = fem::own_square(r); // with the reactions, so that the scale does not vanish in equilibrium
  pericardium_.add_force(d, dt_ > 0 ? &velocity_ : nullptr, r);
  for (const auto &surface : interface_)
    if (interface_pressure != 0)
      surface.add_force(interface_pressure, d, r);
  add_loads(d, r);
  r.zero_out_ghost_values();
  r.add(-1.0, load);
  fem::zero_constrained(r, constrained_);
  const bool valid = smallest_J_ > mech::smallest_J && largest_exponent_ < mech::largest_exponent;
  if (!valid) {
    crushed_cell_ = centre(most_crushed_, d);
    stretched_cell_ = centre(most_stretched_, d);
  }
  std::vector<double> sums{own_forces, fem::own_square(r), valid ? 0. : 1.};
  dealii::Utilities::MPI::sum(sums, space_.communicator(), sums);
  fem::ResidualSize size;
  size.norm = std::sqrt(sums[1]);
  size.scale = std::max({std::sqrt(sums[0]), size.norm, negligible_force_});
  size.valid = sums[2] == 0;
  wanted_residual_ = solver_.residual_tolerance * size.scale;
  return size;
}

void ElasticityProblem::linearise(const fem::Vector &d) {
  const bus::Stopwatch::Section section(stopwatch, "tangent");
  const fem::GhostValues ghosts(d);
  update_time_terms(d);
  tangent_.clear();
  CellData data;
  alignas(64) std::array<VectorizedDouble, 3 * max_nodes_per_cell> forces;
  alignas(64) std::array<VectorizedDouble, 9 * max_nodes_per_cell * max_nodes_per_cell> K;
  const unsigned n_K = 9 * space_.nodes_per_cell() * space_.nodes_per_cell();
  for (const MaterialRegion &region : regions_)
    for (unsigned batch = 0; batch < space_.n_batches(); ++batch)
      if (region.in_batch[batch]) {
        DeformationLimits limits;
        std::fill_n(K.begin(), n_K, VectorizedDouble{});
        const ElasticityCells cells = gather(batch, region, d, tension, data);
        std::visit([&](const auto &law) { add_residual_and_tangent(law, cells, forces.data(), K.data(), limits); },
                   region.law);
        tangent_.add_batch(batch, K.data());
      }
  pericardium_.add_tangent(dt_ > 0 ? 1 / dt_ : 0, tangent_);
  for (const auto &surface : interface_)
    if (interface_pressure != 0)
      surface.add_tangent(interface_pressure, d, tangent_);
  for (const auto &load : loads_)
    if (const double pressure = load_share * load.parameters.pressure.at(time); pressure != 0)
      load.surface.add_tangent(pressure, d, tangent_);
  rounded_tangent_.copy(tangent_);
  tangent_solver_.follow(tangent_);
  has_tangent_ = true;
  ++n_tangents_;
}

unsigned ElasticityProblem::solve_tangent(fem::Vector &dx, const fem::Vector &force, double tolerance) {
  return tangent_solver_.solve(tangent_, rounded_tangent_, dx, force, tolerance, stopwatch);
}

unsigned ElasticityProblem::solve(fem::Vector &dx, const fem::Vector &r) {
  fem::Vector force(r);
  force *= -1;
  // Beyond what Newton's method wants, the linear residual does not matter.
  return solve_tangent(dx, force, 0.1 * wanted_residual_ / force.l2_norm());
}

} // namespace heartbus::mech
