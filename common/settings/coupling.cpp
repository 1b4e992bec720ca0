#include "common/settings/coupling.h"

#include <algorithm>
#include <functional>

namespace heartbus {

namespace {

bool any(const std::vector<config::Outline> &lines, const std::function<bool(const config::Outline &)> &condition) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const config::Outline &line) { return condition(line) || any(line.lines, condition); });
}

} // namespace

bool WrittenScheme::sends(const std::string &field) const {
  return any(step, [&](const config::Outline &line) {
    return line.text.compare(0, field.size() + 1, field + " ") == 0 && line.text.find("->") != std::string::npos;
  });
}

bool WrittenScheme::repeats() const {
  return any(step, [](const config::Outline &line) { return !line.lines.empty(); });
}

bool CouplingParameters::has_robin_condition() const {
  if (is_written())
    return sequence.sends("wall_velocity");
  return scheme != "E1FSinf" && scheme != "one_way" && scheme != "circulation";
}

void CouplingParameters::describe(config::Section &s) {
  s.choice("scheme", scheme,
           {"EFS1", "EFS1-corrected", "E1FS", "adaptive", "by_phase", "E1FSinf", "one_way", "circulation", "custom"},
           "coupling scheme");
  config::Section &lines = s.section("sequence", "of custom: the scheme line by line, as a run prints it");
  lines.outline("once", sequence.once, "what never changes");
  lines.outline("start", sequence.start, "before the first step");
  lines.outline("step", sequence.step, "in each step");
  s.integer(
      "iterations", iterations, {1, 1000},
      "Robin-Neumann iterations in each step: of E1FS all, of adaptive the most, of by_phase while isovolumetric");
  s.number("tolerance", tolerance, config::between(0, 0.1),
           "of E1FS: iterate until the Robin datum changes less than this, 'iterations' times at most; 0: always that "
           "often");
  s.choice("acceleration", acceleration, {"none", "anderson"}, "of the iterations");
  s.number("epsilon", epsilon, config::between(0, 0.1),
           "of adaptive: iterate until a step loses less than this share of the cavity's volume");
  s.quantity_or("alpha", alpha, "kg/(m^2 s)", config::positive, "auto", automatic_alpha,
                "Robin coefficient of the fluid at the interface");
  s.integer("lookahead", lookahead, {0, 1000},
            "steps by which participants that receive nothing (ep, replay) may run ahead of the others: for cores of "
            "their own");
  s.quantity("deadline", deadline, "s", config::between(1e-2, 1e7), "longest time anybody waits for anybody");
  if (is_written() && sequence.step.empty())
    s.fail("scheme",
           "custom needs 'coupling.sequence.step', a list of lines as a run prints them: [solve ep, commit ep]");
  if (is_written() && iterations != 1)
    s.fail("iterations", "custom says itself how often: '- 2 times:' with a list of lines below");
  if (!iterates() && iterations != 1)
    s.fail("iterations", scheme + " has one iteration; 'scheme: E1FS' may have more");
  if (iterates() && scheme != "E1FS" && !is_written() && iterations == 1)
    s.fail("iterations", scheme + " needs to know how many are allowed: more than one");
  if (scheme != "E1FS" && tolerance != 0)
    s.fail("tolerance", "only 'scheme: E1FS' iterates to a tolerance");
  if (!iterates() && acceleration != "none")
    s.fail("acceleration", scheme + " has no iterations to accelerate");
}

} // namespace heartbus
