#pragma once

#include "ep_solver/ionic/gating.h"

#include <array>

/// The model of human ventricular cells by ten Tusscher and Panfilov (2006), doi 10.1152/ajpheart.00109.2006, with the
/// constants of its CellML versions; written once for T = double and T = VectorizedDouble.
///
/// Units of this file: mV, ms, mM, currents in pA/pF. Twelve gates w, dw/dt = (w_inf - w) / tau, and six concentrations
/// z, among them R_bar, the fraction of ryanodine receptors that are not inactivated. fCass, a gate, follows Ca_ss, not
/// v. Of the concentrations a cell also keeps their mean rates over its last step, from which the next one
/// extrapolates.
namespace heartbus::ep::ttp06 {

using fem::exp;
using fem::log;
using fem::sqrt;

enum State : unsigned { Xr1, Xr2, Xs, m, h, j, d, f, f2, fCass, s, r, Ca_i, Ca_SR, Ca_ss, R_bar, Na_i, K_i, n_states };
inline constexpr unsigned n_gates = Ca_i, n_concentrations = n_states - n_gates;
inline constexpr unsigned n_kept = n_states + n_concentrations; ///< the states, then the rates of the concentrations

template <class T>
using States = std::array<T, n_kept>;

/// What differs between epicardial, endocardial and mid-myocardial cells.
struct CellType {
  double g_Ks, g_to; ///< [nS/pF]
  double s_centre;   ///< of s_inf [mV]
  double tau_s_peak, tau_s_centre, tau_s_width, tau_s_slope, tau_s_floor;
};
inline constexpr CellType epi{0.392, 0.294, -20, 85, -45, 320, 5, 3};
inline constexpr CellType endo{0.392, 0.073, -28, 1000, -67, 1000, 0, 8};
inline constexpr CellType mid{0.098, 0.294, -20, 85, -45, 320, 5, 3};

inline constexpr double R = 8314.472, temperature = 310, F = 96485.3415; // mJ/(mol K), K, C/mol
inline constexpr double RT_F = R * temperature / F;                      // mV
inline constexpr double K_o = 5.4, Na_o = 140, Ca_o = 2;                 // mM
inline constexpr double C_m = 0.185, V_c = 0.016404, V_sr = 0.001094, V_ss = 5.468e-5;

template <class T>
HEARTBUS_INLINE T bell(const T &v, double centre, double width) {
  return exp(square(v - centre) * (-1 / width));
}

/// x / (e^x - 1), whose singularity at 0 is removable: there the series of Bernoulli numbers.
template <class T>
HEARTBUS_INLINE T bernoulli(const T &x, const T &exp_x) {
  const T x2 = x * x;
  const T series = 1.0 - 0.5 * x +
                   x2 * (1. / 12 + x2 * (-1. / 720 + x2 * (1. / 30240 + x2 * (-1. / 1209600 + x2 * (1. / 47900160)))));
  return x2 < 0.09 ? series : x / (exp_x - 1.0);
}

template <class T>
HEARTBUS_INLINE Gate<T> gate_h(const T &v) {
  const T a = 0.057 * exp((v + 80) * (-1 / 6.8)), b = 2.7 * exp(0.079 * v) + 3.1e5 * exp(0.3485 * v);
  const T b_depolarised = (0.77 / 0.13) * sigmoid(v, -10.66, 11.1);
  return {square(sigmoid(v, -71.55, -7.43)), 1.0 / (v < -40.0 ? a + b : b_depolarised)};
}

template <class T>
HEARTBUS_INLINE Gate<T> gate_j(const T &v) {
  const T a = (-25428 * exp(0.2444 * v) - 6.948e-6 * exp(-0.04391 * v)) * (v + 37.78) * sigmoid(v, -79.23, -1 / 0.311);
  const T b = 0.02424 * exp(-0.01052 * v) * sigmoid(v, -40.14, 1 / 0.1378);
  const T b_depolarised = 0.6 * exp(0.057 * v) * sigmoid(v, -32, 10);
  return {square(sigmoid(v, -71.55, -7.43)), 1.0 / (v < -40.0 ? a + b : b_depolarised)};
}

template <class T>
HEARTBUS_INLINE std::array<Gate<T>, n_gates> gates(const CellType &cell, const T &v, const T &Ca_ss) {
  const T closed = 1.0 / (1.0 + square(Ca_ss * (1 / 0.05)));
  const T zero = T{};
  return {{
      {sigmoid(v, -26, 7), 2700.0 * sigmoid(v, -45, 10) * sigmoid(v, -30, -11.5)},
      {sigmoid(v, -88, -24), 3.36 * sigmoid(v, -60, 20) * sigmoid(v, 60, -20)},
      {sigmoid(v, -5, 14), 1400.0 / sqrt(1.0 + exp((5.0 - v) * (1. / 6))) * sigmoid(v, 35, -15) + 80.0},
      {square(sigmoid(v, -56.86, 9.03)), 0.1 * sigmoid(v, -60, 5) * (sigmoid(v, -35, -5) + sigmoid(v, 50, -200))},
      gate_h(v),
      gate_j(v),
      {sigmoid(v, -8, 7.5), (1.4 * sigmoid(v, -35, 13) + 0.25) * 1.4 * sigmoid(v, -5, -5) + sigmoid(v, 50, 20)},
      {sigmoid(v, -20, -7),
       1102.5 * bell(v, -27, 225) + 200.0 * sigmoid(v, 13, 10) + 180.0 * sigmoid(v, -30, -10) + 20.0},
      {0.67 * sigmoid(v, -35, -7) + 0.33,
       562.0 * bell(v, -27, 240) + 31.0 * sigmoid(v, 25, 10) + 80.0 * sigmoid(v, -30, -10)},
      {0.6 * closed + 0.4, 80.0 * closed + 2.0},
      {sigmoid(v, cell.s_centre, -5), cell.tau_s_peak * bell(v, cell.tau_s_centre, cell.tau_s_width) +
                                          cell.tau_s_slope * sigmoid(v, 20, -5) + cell.tau_s_floor},
      {sigmoid(v, 20, 6), 9.5 * bell(v, -40, 1800) + 0.8 + zero},
  }};
}

template <class T>
struct Currents {
  T Na, bNa, K1, to, Kr, Ks, CaL, NaCa, NaK, pCa, pK, bCa;
  HEARTBUS_INLINE T sum() const { return Na + bNa + K1 + to + Kr + Ks + CaL + NaCa + NaK + pCa + pK + bCa; }
};

template <class T>
HEARTBUS_INLINE Currents<T> currents(const CellType &cell, const T &v, const States<T> &y) {
  const T E_Na = RT_F * log(Na_o / y[Na_i]), E_K = RT_F * log(K_o / y[K_i]), E_Ca = 0.5 * RT_F * log(Ca_o / y[Ca_i]);
  const T E_Ks = RT_F * log((K_o + 0.03 * Na_o) / (y[K_i] + 0.03 * y[Na_i]));
  const T u = v - E_K;

  Currents<T> I;
  I.Na = 14.838 * y[m] * y[m] * y[m] * y[h] * y[j] * (v - E_Na);
  I.bNa = 2.9e-4 * (v - E_Na);
  const T a = 0.1 / (1.0 + exp(0.06 * (u - 200.0)));
  const T b = (3.0 * exp(2e-4 * (u + 100.0)) + exp(0.1 * (u - 10.0))) / (1.0 + exp(-0.5 * u));
  I.K1 = 5.405 * a / (a + b) * u; // sqrt(K_o / 5.4) = 1 here and in I_Kr
  I.to = cell.g_to * y[r] * y[s] * u;
  I.Kr = 0.153 * y[Xr1] * y[Xr2] * u;
  I.Ks = cell.g_Ks * y[Xs] * y[Xs] * (v - E_Ks);

  const T x = (v - 15.0) * (2 / RT_F), exp_x = exp(x);
  I.CaL = (3.98e-5 * 2 * F) * y[d] * y[f] * y[f2] * y[fCass] * bernoulli(x, exp_x) * (0.25 * y[Ca_ss] * exp_x - Ca_o);

  const T inward = exp(v * (0.35 / RT_F)), outward = exp(v * (-0.65 / RT_F));
  I.NaCa = 1000.0 * (inward * y[Na_i] * y[Na_i] * y[Na_i] * Ca_o - outward * (Na_o * Na_o * Na_o * 2.5) * y[Ca_i]) /
           ((87.5 * 87.5 * 87.5 + Na_o * Na_o * Na_o) * (1.38 + Ca_o) * (1.0 + 0.1 * outward));
  I.NaK = (2.724 * K_o / (K_o + 1.0)) * y[Na_i] /
          ((y[Na_i] + 40.0) * (1.0 + 0.1245 * exp(v * (-0.1 / RT_F)) + 0.0353 * exp(v * (-1 / RT_F))));
  I.pCa = 0.1238 * y[Ca_i] / (5e-4 + y[Ca_i]);
  I.pK = 0.0146 * u * sigmoid(v, 25, 5.98);
  I.bCa = 5.92e-4 * (v - E_Ca);
  return I;
}

/// The concentrations explicitly: z^{n+1} = z^n + dt F_z(v, y), and their mean rates. An applied current is carried by
/// potassium. Returns how far Ca_ss^{n+1}, the fastest of them, is from its extrapolation with the rate of the step
/// before [mM].
template <class T>
HEARTBUS_INLINE T step_concentrations(const Currents<T> &I, const States<T> &y, const States<T> &y_n, States<T> &y_np1,
                                      double dt, double i_app) {
  const T kcasr = 2.5 - 1.5 / (1.0 + square(1.5 / y[Ca_SR]));
  const T k1_Ca2 = 0.15 / kcasr * square(y[Ca_ss]), k2 = 0.045 * kcasr;
  const T open = k1_Ca2 * y[R_bar] / (0.06 + k1_Ca2);
  const T I_rel = 0.102 * open * (y[Ca_SR] - y[Ca_ss]), I_up = 0.006375 / (1.0 + square(2.5e-4 / y[Ca_i]));
  const T I_leak = 3.6e-4 * (y[Ca_SR] - y[Ca_i]), I_xfer = 0.0038 * (y[Ca_ss] - y[Ca_i]);
  const T free_c = 1.0 / (1.0 + 0.2 * 0.001 / square(y[Ca_i] + 0.001)); // fractions that the buffers leave
  const T free_sr = 1.0 / (1.0 + 10 * 0.3 / square(y[Ca_SR] + 0.3));
  const T free_ss = 1.0 / (1.0 + 0.4 * 2.5e-4 / square(y[Ca_ss] + 2.5e-4));
  constexpr double per_current = C_m / (V_c * F); // mM/ms in the cytosol by 1 pA/pF

  y_np1[Ca_i] =
      y_n[Ca_i] +
      dt * free_c * ((I_leak - I_up) * (V_sr / V_c) + I_xfer - (I.bCa + I.pCa - 2.0 * I.NaCa) * (0.5 * per_current));
  y_np1[Ca_SR] = y_n[Ca_SR] + dt * free_sr * (I_up - I_leak - I_rel);
  y_np1[Ca_ss] =
      y_n[Ca_ss] + dt * free_ss * (I.CaL * (-C_m / (2 * V_ss * F)) + I_rel * (V_sr / V_ss) - I_xfer * (V_c / V_ss));
  y_np1[R_bar] = y_n[R_bar] + dt * (0.005 * (1.0 - y[R_bar]) - k2 * y[Ca_ss] * y[R_bar]);
  y_np1[Na_i] = y_n[Na_i] - (dt * per_current) * (I.Na + I.bNa + 3.0 * I.NaK + 3.0 * I.NaCa);
  y_np1[K_i] = y_n[K_i] - (dt * per_current) * (I.K1 + I.to + I.Kr + I.Ks + I.pK - 2.0 * I.NaK - i_app);

  for (unsigned z = n_gates; z < n_states; ++z)
    y_np1[z + n_concentrations] = (y_np1[z] - y_n[z]) * (1 / dt);
  return dt * absolute(y_np1[Ca_ss + n_concentrations] - y_n[Ca_ss + n_concentrations]);
}

/// What a step of a cell gives besides its states: I_ion, and how far Ca_ss is from its extrapolation [mM].
template <class T>
struct Outcome {
  T I_ion, error;
};

/// The paper's scheme (ionic_model.h), first the gates w^{n+1} ...
template <class T>
HEARTBUS_INLINE void step_gates(const CellType &cell, const T &v, const States<T> &y_n, States<T> &y_np1, double dt) {
  const auto gate = gates(cell, v, y_n[Ca_ss]);
  for (unsigned w = 0; w < n_gates; ++w)
    y_np1[w] = (gate[w].tau * y_n[w] + dt * gate[w].inf) / (gate[w].tau + dt);
}

/// ... then the concentrations z^{n+1}, and I_ion(v^n, w^{n+1}, z^{n+1}).
template <class T>
HEARTBUS_INLINE Outcome<T> finish_step(const CellType &cell, const T &v, const States<T> &y_n, States<T> &y_np1,
                                       double dt, double i_app = 0) {
  const T error = step_concentrations(currents(cell, v, y_n), y_n, y_n, y_np1, dt, i_app);
  return {currents(cell, v, y_np1).sum(), error};
}

/// The exponential midpoint rule (ionic_model.h), `v` in the middle of the step: first the concentrations there,
/// extrapolated, and the gates there and at the end, w_inf + (w^n - w_inf) e^{-t/tau} ...
template <class T>
HEARTBUS_INLINE void step_gates_midpoint(const CellType &cell, const T &v, const States<T> &y_n, States<T> &y_middle,
                                         States<T> &y_np1, double dt) {
  for (unsigned z = n_gates; z < n_states; ++z)
    y_middle[z] = y_n[z] + 0.5 * dt * y_n[z + n_concentrations];
  const auto gate = gates(cell, v, y_middle[Ca_ss]);
  for (unsigned w = 0; w < n_gates; ++w) {
    const T half = decay(0.5 * dt / gate[w].tau);
    y_middle[w] = gate[w].inf + half * (y_n[w] - gate[w].inf);
    y_np1[w] = gate[w].inf + half * (y_middle[w] - gate[w].inf);
  }
}

/// ... then the concentrations z^{n+1}, and I_ion, with everything in the middle.
template <class T>
HEARTBUS_INLINE Outcome<T> finish_step_midpoint(const CellType &cell, const T &v, const States<T> &y_n,
                                                const States<T> &y_middle, States<T> &y_np1, double dt,
                                                double i_app = 0) {
  const Currents<T> I = currents(cell, v, y_middle);
  const T error = step_concentrations(I, y_middle, y_n, y_np1, dt, i_app);
  return {I.sum(), error};
}

} // namespace heartbus::ep::ttp06
