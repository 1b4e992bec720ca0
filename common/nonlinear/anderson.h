#pragma once

#include <deque>
#include <optional>
#include <vector>

namespace heartbus::fem {

/// Anderson's acceleration of x = G(x), from secants only (Walker and Ni 2011, doi:10.1137/10078356X; in interface
/// problems also known as IQN-ILS): with r_k = G(x_k) - x_k,
///
///     x_{k+1} = G(x_k) - sum_i c_i (G(x_{i+1}) - G(x_i)),     c minimising |r_k - sum_i c_i (r_{i+1} - r_i)|
///
/// over the last `depth` differences; depth 0 is the plain iteration. A linear G in n dimensions needs n + 1
/// evaluations.
template <class Vector>
class Anderson {
 public:
  explicit Anderson(unsigned depth) : depth_(depth) {}

  void restart() {
    last_.reset();
    differences_.clear();
  }

  /// The next x, from the last one and G of it.
  Vector next(const Vector &x, const Vector &G) {
    if (depth_ == 0)
      return G;
    Vector r(G);
    r -= x;
    if (last_)
      remember(r, G);
    last_ = Pair{r, G};
    return extrapolated(r, G);
  }

 private:
  struct Pair {
    Vector r, G;
  };

  void remember(const Vector &r, const Vector &G) {
    differences_.push_front({r, G});
    differences_.front().r -= last_->r;
    differences_.front().G -= last_->G;
    if (differences_.size() > depth_)
      differences_.pop_back();
  }

  /// Least squares by orthogonalising the differences, the newest first; those that add nothing to the others are
  /// skipped.
  Vector extrapolated(Vector r, const Vector &G) const {
    std::vector<Vector> q;
    std::vector<const Pair *> used;
    std::vector<std::vector<double>> R; ///< [column][row]
    std::vector<double> rhs;
    for (const Pair &difference : differences_) {
      Vector column(difference.r);
      std::vector<double> coefficients;
      for (const Vector &direction : q) {
        coefficients.push_back(direction * column);
        column.add(-coefficients.back(), direction);
      }
      const double norm = column.l2_norm();
      if (!(norm > 1e-10 * difference.r.l2_norm()))
        continue;
      column *= 1 / norm;
      coefficients.push_back(norm);
      rhs.push_back(column * r);
      r.add(-rhs.back(), column);
      q.push_back(column);
      R.push_back(coefficients);
      used.push_back(&difference);
    }
    Vector x(G);
    for (std::size_t i = q.size(); i-- > 0;) {
      const double c = rhs[i] / R[i][i];
      for (std::size_t row = 0; row < i; ++row)
        rhs[row] -= c * R[i][row];
      x.add(-c, used[i]->G);
    }
    return x;
  }

  unsigned depth_;
  std::optional<Pair> last_;
  std::deque<Pair> differences_; ///< the newest first
};

} // namespace heartbus::fem
