#pragma once

namespace heartbus::fem {

/// Matrices change little from step to step: a preconditioner serves until solutions take half as many iterations
/// again as when it was new, and a few more.
class PreconditionerAge {
 public:
  explicit PreconditionerAge(unsigned more) : more_(more) {}
  /// Whether a new one is due: there is none, or it has shown its age.
  bool is_due() const { return !is_made_ || last_ > usual_ + usual_ / 2 + more_; }
  void renew() {
    is_made_ = true;
    usual_ = last_ = 0;
  }
  void forget() { is_made_ = false; }
  /// A solution took so many.
  void note(unsigned iterations) {
    last_ = iterations;
    if (usual_ == 0)
      usual_ = iterations;
  }
  unsigned usual() const { return usual_; } ///< iterations with a new one

 private:
  unsigned more_, usual_ = 0, last_ = 0;
  bool is_made_ = false;
};

} // namespace heartbus::fem
