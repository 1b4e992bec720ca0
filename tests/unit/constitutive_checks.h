#pragma once

#include "mech_solver/constitutive/law.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <random>

/// What every constitutive law must satisfy, checked at random deformations.
namespace heartbus::mech::checks {

using Matrix = Mat3<double>;

inline Matrix random_matrix(std::mt19937 &generator, double size) {
  std::uniform_real_distribution<double> uniform(-size, size);
  Matrix A;
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      A[i][j] = uniform(generator);
  return A;
}

inline Matrix random_deformation(std::mt19937 &generator) {
  return fem::identity<double>() + random_matrix(generator, 0.15);
}

/// A rotation by Cayley's map of a random skew matrix.
inline Matrix random_rotation(std::mt19937 &generator) {
  const Matrix A = random_matrix(generator, 1.0), I = fem::identity<double>();
  const Matrix skew = A - fem::transpose(A);
  return fem::inverse(Matrix(I - skew)) * Matrix(I + skew);
}

inline double norm(const Matrix &A) { return std::sqrt(fem::contract(A, A)); }

/// Central differences have an error h^2 c: a hundredth when h falls ten times, as long as it stands above round-off.
/// `error(h)` is relative; fails unless the order is seen and the best error is small.
inline void expect_second_order(const std::function<double(double)> &error) {
  const double coarse = error(1e-2), fine = error(1e-3), finest = error(1e-4);
  EXPECT_LT(fine, 0.012 * coarse + 1e-11);
  EXPECT_LT(finest, 0.012 * fine + 1e-10);
  EXPECT_LT(finest, 1e-5);
  EXPECT_GT(coarse, 1e-13) << "the law is not exercised";
}

/// dP for an increment H of F, by the elasticity tensor.
template <class Stress>
Matrix stress_increment(const Stress &stress_and_tangent, const Matrix &F, const Matrix &H) {
  Symmetric<double> S;
  Tangent<double> D;
  stress_and_tangent(F, S, D);
  std::array<std::array<double, 9>, 9> A;
  elasticity_tensor(F, S, D, A);
  Matrix dP;
  for (unsigned i = 0; i < 9; ++i) {
    dP[i / 3][i % 3] = 0;
    for (unsigned j = 0; j < 9; ++j)
      dP[i / 3][i % 3] += A[i][j] * H[j / 3][j % 3];
  }
  return dP;
}

template <class Law>
void expect_stress_is_derivative_of_energy(const Law &law) {
  std::mt19937 generator(1);
  for (unsigned sample = 0; sample < 5; ++sample) {
    const Matrix F = random_deformation(generator), H = random_matrix(generator, 1.0);
    const double exact = fem::contract(first_piola(law, F), H);
    expect_second_order([&](double h) {
      const double difference = (law.energy(Matrix(F + h * H)) - law.energy(Matrix(F - h * H))) / (2 * h);
      return std::abs(difference - exact) / norm(first_piola(law, F));
    });
  }
}

template <class Law>
void expect_tangent_is_derivative_of_stress(const Law &law) {
  std::mt19937 generator(2);
  for (unsigned sample = 0; sample < 5; ++sample) {
    const Matrix F = random_deformation(generator), H = random_matrix(generator, 1.0);
    const Matrix exact = stress_increment(
        [&](const Matrix &G, Symmetric<double> &S, Tangent<double> &D) {
          const double J = fem::determinant(G);
          law.stress_and_tangent(right_cauchy_green(G), J, law.volumetric(J), S, D);
        },
        F, H);
    expect_second_order([&](double h) {
      const Matrix difference =
          (1 / (2 * h)) * Matrix(first_piola(law, Matrix(F + h * H)) - first_piola(law, Matrix(F - h * H)));
      return norm(difference - exact) / norm(exact);
    });
  }
}

/// Objectivity: W(QF) = W(F) and P(QF) = Q P(F); no stress under a rotation alone.
template <class Law>
void expect_rotation_invariance(const Law &law, double stiffness) {
  std::mt19937 generator(3);
  const Matrix F = random_deformation(generator), Q = random_rotation(generator), I = fem::identity<double>();
  EXPECT_NEAR(law.energy(Matrix(Q * F)), law.energy(F), 1e-12 * stiffness);
  EXPECT_LT(norm(first_piola(law, Matrix(Q * F)) - Q * first_piola(law, F)), 1e-12 * stiffness);
  EXPECT_LT(norm(first_piola(law, Q)), 1e-12 * stiffness);
  EXPECT_NEAR(law.energy(I), 0, 1e-14 * stiffness);
  EXPECT_LT(norm(first_piola(law, I)), 1e-14 * stiffness);
}

/// The same numbers come out of eight lanes at once, stress and tangent, and both functions give the same stress.
template <class Law>
void expect_lanes_equal_double(const Law &law) {
  std::mt19937 generator(4);
  Mat3<VectorizedDouble> F;
  std::array<Matrix, fem::n_lanes> single;
  for (unsigned lane = 0; lane < fem::n_lanes; ++lane) {
    single[lane] = random_deformation(generator);
    for (unsigned i = 0; i < 9; ++i)
      F[i / 3][i % 3][lane] = single[lane][i / 3][i % 3];
  }
  Symmetric<VectorizedDouble> S;
  Tangent<VectorizedDouble> D;
  const VectorizedDouble J = fem::determinant(F);
  law.stress_and_tangent(right_cauchy_green(F), J, law.volumetric(J), S, D);
  for (unsigned lane = 0; lane < fem::n_lanes; ++lane) {
    Symmetric<double> S1;
    const double J1 = fem::determinant(single[lane]);
    law.stress(right_cauchy_green(single[lane]), J1, law.volumetric(J1), S1);
    Symmetric<double> S2;
    Tangent<double> D2;
    law.stress_and_tangent(right_cauchy_green(single[lane]), J1, law.volumetric(J1), S2, D2);
    for (unsigned v = 0; v < 6; ++v) {
      EXPECT_NEAR(S[v][lane], S1[v], 1e-12 * std::abs(S1[v]) + 1e-10);
      EXPECT_NEAR(S2[v], S1[v], 1e-12 * std::abs(S1[v]) + 1e-10);
      for (unsigned w = 0; w < 6; ++w)
        EXPECT_NEAR(D[v][w][lane], D2[v][w], 1e-12 * std::abs(D2[v][w]) + 1e-9);
    }
  }
}

} // namespace heartbus::mech::checks
