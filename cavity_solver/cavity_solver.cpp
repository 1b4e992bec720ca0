#include "cavity_solver/cavity_solver.h"

#include "common/io/state_file.h"

namespace heartbus::cavity {
namespace {

enum Phase { isovolumetric_contraction, ejection, isovolumetric_relaxation, filling };
/// A valve that passes less is closed by name: round-off in the balance with the atrium is no filling.
constexpr double seeping = 1e-6; // [m^3/s]

} // namespace

CavitySolver::CavitySolver(MPI_Comm communicator, const CirculationParameters &parameters, double initial_pressure)
    : communicator_(communicator), circulation_(parameters), pressure_{initial_pressure} {}

void CavitySolver::declare(bus::Declaration &bus) {
  const char *global = bus::Declaration::global;
  bus.input("cavity_volume", global, 1, "m^3", volume_);
  bus.input("cavity_compliance", global, 1, "m^3/Pa", compliance_);
  bus.input("cavity_pressure_guess", global, 1, "Pa", guess_);
  bus.output("cavity_pressure", global, 1, "Pa", "n+1", pressure_);
  bus.task("start", [this](const bus::Step &) { old_volume_ = blood_volume_ = volume_[0]; });
  bus.task("budget", [](const bus::Step &) {}); // the volume has arrived
  bus.scalar("volume", "m^3", [this] { return volume_[0]; });
  bus.scalar("mean_pressure", "Pa", [this] { return pressure_[0]; });
  bus.scalar("mitral_flow", "m^3/s", [this] { return circulation_.mitral_flow(); });
  bus.scalar("aortic_flow", "m^3/s", [this] { return circulation_.aortic_flow(); });
  bus.scalar("arterial_pressure", "Pa", [this] { return circulation_.arterial_pressure(); });
  bus.scalar("volume_missed", "m^3", [this] { return volume_[0] - blood_volume_; });
  bus.state("phase", {"isovolumetric contraction", "ejection", "isovolumetric relaxation", "filling"},
            [this] { return phase(); });
}

void CavitySolver::solve_step(const bus::Step &step) {
  pressure_[0] = circulation_.solve({volume_[0], compliance_[0], guess_[0]}, old_volume_, step.size);
  blood_volume_ = old_volume_ + step.size * (circulation_.mitral_flow() - circulation_.aortic_flow());
}

void CavitySolver::commit_step(const bus::Step &) {
  circulation_.commit();
  old_volume_ = blood_volume_;
  last_phase_ = phase();
}

int CavitySolver::phase() const {
  if (circulation_.aortic_flow() > seeping)
    return ejection;
  if (circulation_.mitral_flow() > seeping)
    return filling;
  return last_phase_ == ejection || last_phase_ == isovolumetric_relaxation ? isovolumetric_relaxation
                                                                            : isovolumetric_contraction;
}

void CavitySolver::visit(io::State &state) {
  state.number("volume", old_volume_);
  state.number("pressure", pressure_[0]);
  state.number("arterial_pressure", circulation_.old_arterial_pressure());
  state.number("phase", last_phase_);
}

void CavitySolver::save_state(const std::string &folder, const bus::Step &) {
  io::save_state(communicator_, folder + "/circulation.h5", [this](io::State &state) { visit(state); });
}

void CavitySolver::load_state(const std::string &folder, const bus::Step &) {
  io::load_state(communicator_, folder + "/circulation.h5", [this](io::State &state) { visit(state); });
  volume_[0] = blood_volume_ = old_volume_;
}

} // namespace heartbus::cavity
