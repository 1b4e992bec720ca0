#pragma once

#include <algorithm>
#include <deque>
#include <string>

namespace heartbus::interface {

/// Recognises that the coupling runs away. What blood and wall disagree by at the end of a step, alpha |u - v|, is a
/// pressure that the next step has to make up for. The pressure in a beating heart changes by 3e5 Pa/s; a valve that
/// switches makes a jump of one step. A run that fails instead asks for more step after step: it is recognised when six
/// steps in a row disagree by more than 1e6 Pa/s and the last three twice as much as those before, or all by 1e7 Pa/s;
/// and at once, before the wall is torn, when a step disagrees by 1e7 Pa/s and by ten times the last Robin datum. Of
/// large steps a wall is crushed by fewer than six: there it counts when u - v has turned round in six steps in a row,
/// grows by a third in three, disagrees by 1e5 Pa/s and changes the datum by a tenth.
///
/// With alpha far beyond the wall's impedance (Dirichlet-Neumann) blood moves as the wall did one step earlier: alpha
/// |u - v| is alpha dt times the wall's acceleration, large even when all is well and for as long as a load lasts. Then
/// growth counts when the step changes the datum by more than itself, as amplification by less than -1 does, and six
/// such steps in a row count without it.
class InstabilityWatch {
 public:
  explicit InstabilityWatch(double dt) : large_(1e6 * dt), huge_(1e7 * dt) {}

  /// One more step: its kinematic jump alpha |u - v| [Pa], the same relative to the datum, whether it is one of
  /// Dirichlet-Neumann, and the cosine of the angle between u - v and that of the step before. True: blood and wall
  /// run away from each other.
  bool add(double kinematic_jump, double datum_residual = 0, bool dirichlet = false, double cosine = 0) {
    last_.push_back({kinematic_jump, cosine});
    if (last_.size() > n_steps)
      last_.pop_front();
    larger_than_datum_ = datum_residual > 1 ? larger_than_datum_ + 1 : 0;
    if (kinematic_jump > huge_ && datum_residual > 10)
      return true;
    if (last_.size() < n_steps)
      return false;
    const double lowest = std::min_element(last_.begin(), last_.end(), smaller)->kinematic_jump;
    const double growth = largest(3, 6) / largest(0, 3);
    if (dirichlet)
      return lowest > large_ && ((growth > 2 && larger_than_datum_ > 0) || larger_than_datum_ >= 6);
    const bool turns_and_grows = count_turns() == n_steps && growth > 4. / 3;
    return (turns_and_grows && lowest > 0.1 * large_ && datum_residual > 0.1) ||
           (lowest > large_ && (growth > 2 || lowest > huge_));
  }

  /// Whether u - v has turned round in most of the last steps, as it does where alpha is too large for a scheme without
  /// iterations: v is then more than opposed to what the blood was told.
  bool alternates() const { return 2 * count_turns() > last_.size(); }

 private:
  struct Step {
    double kinematic_jump, cosine;
  };
  std::size_t count_turns() const {
    return std::count_if(last_.begin(), last_.end(), [](const Step &step) { return step.cosine < -0.5; });
  }
  static bool smaller(const Step &a, const Step &b) { return a.kinematic_jump < b.kinematic_jump; }
  double largest(int first, int end) const {
    return std::max_element(last_.begin() + first, last_.begin() + end, smaller)->kinematic_jump;
  }

  static constexpr std::size_t n_steps = 6;
  double large_, huge_;
  std::deque<Step> last_;
  int larger_than_datum_ = 0; ///< steps in a row
};

/// What is known when a coupling runs away.
struct Runaway {
  double kinematic_jump = 0;         ///< [Pa]
  double alpha = 0, alpha_limit = 0; ///< [kg/(m^2 s)]; a limit of 0 has not been estimated since a restart
  bool alternates = false;           ///< the jump changes its sign from step to step
  bool iterates = false;             ///< blood and wall are solved more than once a step
  bool automatic_alpha = false;
};

/// What is seen, and what may help: alpha where it is above its limit or the jump alternates, but not below
/// half the limit: what alternates there is driven by something else, e.g. by a tension beyond all hearts. The limit
/// of iterations lies up to half above the border (docs/schemes.md), and they need not alternate. `pressure`: mean of
/// the blood [Pa].
std::string explanation(const Runaway &seen, double pressure);

} // namespace heartbus::interface
