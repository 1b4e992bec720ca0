#pragma once

#include "common/simd/vectorized_double.h"

#include <array>

namespace heartbus::fem {

/// 3-vectors and 3x3 matrices of a number type, `double` or `VectorizedDouble`, for pointwise models and kernels.
template <class T>
using Vec3 = std::array<T, 3>;

template <class T>
struct Mat3 {
  std::array<std::array<T, 3>, 3> m{};
  HEARTBUS_INLINE std::array<T, 3> &operator[](unsigned i) { return m[i]; }
  HEARTBUS_INLINE const std::array<T, 3> &operator[](unsigned i) const { return m[i]; }
};

template <class T>
HEARTBUS_INLINE Mat3<T> identity() {
  Mat3<T> a{};
  for (unsigned i = 0; i < 3; ++i)
    a[i][i] = T{} + 1.0;
  return a;
}

/// F = I + grad d = I + sum_a d_a x g_a over the n nodes of a cell: d(a, i), gradients [a][3].
template <class T, class Displacement>
HEARTBUS_INLINE Mat3<T> deformation_gradient(unsigned n, const Displacement &d, const T *gradients) {
  Mat3<T> F = identity<T>();
  for (unsigned a = 0; a < n; ++a)
    for (unsigned i = 0; i < 3; ++i)
      for (unsigned j = 0; j < 3; ++j)
        F[i][j] += d(a, i) * gradients[3 * a + j];
  return F;
}

template <class T>
HEARTBUS_INLINE Mat3<T> operator+(const Mat3<T> &a, const Mat3<T> &b) {
  Mat3<T> c;
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      c[i][j] = a[i][j] + b[i][j];
  return c;
}

template <class T>
HEARTBUS_INLINE Mat3<T> operator-(const Mat3<T> &a, const Mat3<T> &b) {
  Mat3<T> c;
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      c[i][j] = a[i][j] - b[i][j];
  return c;
}

template <class T>
HEARTBUS_INLINE Mat3<T> operator*(const T &s, const Mat3<T> &a) {
  Mat3<T> c;
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      c[i][j] = s * a[i][j];
  return c;
}

template <class T>
HEARTBUS_INLINE Mat3<T> operator*(const Mat3<T> &a, const Mat3<T> &b) {
  Mat3<T> c{};
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      for (unsigned k = 0; k < 3; ++k)
        c[i][j] += a[i][k] * b[k][j];
  return c;
}

template <class T>
HEARTBUS_INLINE Vec3<T> operator*(const Mat3<T> &a, const Vec3<T> &x) {
  Vec3<T> y{};
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      y[i] += a[i][j] * x[j];
  return y;
}

template <class T>
HEARTBUS_INLINE T dot(const Vec3<T> &a, const Vec3<T> &b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// A : B
template <class T>
HEARTBUS_INLINE T contract(const Mat3<T> &a, const Mat3<T> &b) {
  T s{};
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      s += a[i][j] * b[i][j];
  return s;
}

template <class T>
HEARTBUS_INLINE Mat3<T> transpose(const Mat3<T> &a) {
  Mat3<T> c;
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      c[i][j] = a[j][i];
  return c;
}

template <class T>
HEARTBUS_INLINE T determinant(const Mat3<T> &a) {
  return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) - a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
         a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
}

/// J F^{-T}, the cofactor matrix.
template <class T>
HEARTBUS_INLINE Mat3<T> cofactor(const Mat3<T> &a) {
  Mat3<T> c;
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j) {
      const unsigned i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      c[i][j] = a[i1][j1] * a[i2][j2] - a[i1][j2] * a[i2][j1];
    }
  return c;
}

template <class T>
HEARTBUS_INLINE Mat3<T> inverse(const Mat3<T> &a) {
  const Mat3<T> c = cofactor(a);
  const T d = 1.0 / determinant(a);
  return d * transpose(c);
}

} // namespace heartbus::fem
