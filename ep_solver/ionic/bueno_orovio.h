#pragma once

#include "ep_solver/ionic/gating.h"

#include <array>

/// The minimal model of human ventricular cells by Bueno-Orovio, Cherry and Fenton, J. Theor. Biol. 253 (2008) 544,
/// doi:10.1016/j.jtbi.2008.03.029: section 2 and table 1; written once for T = double and T = VectorizedDouble.
///
/// Units of this file: ms; the potential u is a number, V = 85.7 u - 84 mV. With H the Heaviside function and
/// S_k,c(u) = (1 + tanh(k (u - c))) / 2,
///
///     du/dt = -(J_fi + J_so + J_si),
///     dv/dt = (1 - H(u - theta_v)) (v_inf - v) / tau_v^-  -  H(u - theta_v) v / tau_v^+,
///     dw/dt = (1 - H(u - theta_w)) (w_inf - w) / tau_w^-  -  H(u - theta_w) w / tau_w^+,
///     ds/dt = (S_k_s,u_s(u) - s) / tau_s,
///     J_fi = -v H(u - theta_v) (u - theta_v) (u_u - u) / tau_fi,
///     J_so = (u - u_o) (1 - H(u - theta_w)) / tau_o + H(u - theta_w) / tau_so,
///     J_si = -H(u - theta_w) w s / tau_si.
///
/// The model has no calcium. What is sent as calcium is a surrogate of this program, no part of the article: a release
/// that is driven by the variable s of the slow inward current, through channels of which a share r is open, and an
/// uptake,
///
///     dc/dt = B H(u - theta_w) r s - (c - c_0) / 150 ms,
///     dr/dt = (1 - H(u - theta_w)) (1 - r) / 100 ms  -  H(u - theta_w) r / 12 ms.
///
/// With the times of uptake and closing the transient is nearest to that of the model of ten Tusscher and Panfilov
/// (root of the mean square 4 % of the peak); c_0 and B give it the diastolic and the peak value there for the same
/// cell type, both every 800 ms. Nothing depends on c and r.
namespace heartbus::ep::bueno_orovio {

enum State : unsigned { v, w, s, r, Ca, n_states };
inline constexpr unsigned v_rate = n_states; ///< dv/dt over the last step, against which the next is compared
inline constexpr unsigned n_kept = n_states + 1;

template <class T>
using States = std::array<T, n_kept>;

/// What differs between epicardial, endocardial and mid-myocardial cells, in the article's names.
struct CellType {
  double u_u, theta_v_minus, theta_o, tau_v1_minus, tau_v2_minus, tau_w1_minus, tau_w2_minus, k_w_minus, u_w_minus,
      tau_w_plus, tau_fi, tau_o1, tau_o2, tau_so1, tau_so2, k_so, u_so, tau_s2, tau_si, tau_w_inf, w_inf_star;
  double calcium_rest, release; ///< c_0 [uM], B [uM/ms]
};
inline constexpr CellType epi{1.55, 0.006,   0.006,  60,     1150, 60, 15,     65,   0.03, 200,      0.11,   400,
                              6,    30.0181, 0.9957, 2.0458, 0.65, 16, 1.8875, 0.07, 0.94, 0.107814, 0.35724};
inline constexpr CellType endo{1.56, 0.2, 0.006, 75, 10,   6, 140,    200,    0.016, 280,      0.1,    470,
                               6,    40,  1.2,   2,  0.65, 2, 2.9013, 0.0273, 0.78,  0.106369, 0.14651};
inline constexpr CellType mid{1.61, 0.1, 0.005, 80,  1.4506, 70, 8,      200,  0.016, 280,     0.078, 410,
                              7,    91,  0.8,   2.1, 0.6,    4,  3.3849, 0.01, 0.5,   0.11555, 0.2636};

inline constexpr double theta_v = 0.3, theta_w = 0.13, tau_v_plus = 1.4506, tau_s1 = 2.7342, k_s = 2.0994, u_s = 0.9087;
inline constexpr double error_scale = 4; ///< of the error in v: with 1 a front is 4 % too slow
inline constexpr double tau_c = 150, tau_r_closing = 12, tau_r_opening = 100; // ms

/// `above` where u >= threshold, `below` elsewhere.
template <class T>
HEARTBUS_INLINE T switched(const T &u, double threshold, const T &below, const T &above) {
  return u < threshold ? below : above;
}
/// The same between two constants.
template <class T>
HEARTBUS_INLINE T jump(const T &u, double threshold, double below, double above) {
  return switched<T>(u, threshold, T{} + below, T{} + above);
}

/// (1 + tanh(k (u - centre))) / 2
template <class T>
HEARTBUS_INLINE T S(const T &u, double k, double centre) {
  return sigmoid(u, centre, 0.5 / k);
}

/// Of v, w, s and r.
template <class T>
HEARTBUS_INLINE std::array<Gate<T>, 4> gates(const CellType &cell, const T &u) {
  const T v_inf = jump(u, cell.theta_v_minus, 1, 0);
  const T tau_v_minus = jump(u, cell.theta_v_minus, cell.tau_v1_minus, cell.tau_v2_minus);
  const T w_inf = switched<T>(u, cell.theta_o, 1.0 - u * (1 / cell.tau_w_inf), T{} + cell.w_inf_star);
  const T tau_w_minus =
      cell.tau_w1_minus + (cell.tau_w2_minus - cell.tau_w1_minus) * S(u, cell.k_w_minus, cell.u_w_minus);
  return {{{switched<T>(u, theta_v, v_inf, T{}), switched<T>(u, theta_v, tau_v_minus, T{} + tau_v_plus)},
           {switched<T>(u, theta_w, w_inf, T{}), switched<T>(u, theta_w, tau_w_minus, T{} + cell.tau_w_plus)},
           {S(u, k_s, u_s), jump(u, theta_w, tau_s1, cell.tau_s2)},
           {jump(u, theta_w, 1, 0), jump(u, theta_w, tau_r_opening, tau_r_closing)}}};
}

/// J_fi + J_so + J_si [1/ms]
template <class T>
HEARTBUS_INLINE T current(const CellType &cell, const T &u, const States<T> &y) {
  const T fast_inward = y[v] * (u - theta_v) * (cell.u_u - u) * (1 / cell.tau_fi);
  const T tau_so = cell.tau_so1 + (cell.tau_so2 - cell.tau_so1) * S(u, cell.k_so, cell.u_so);
  const T leak = u * jump(u, cell.theta_o, 1 / cell.tau_o1, 1 / cell.tau_o2); // u_o = 0
  return switched<T>(u, theta_w, leak, 1.0 / tau_so - y[w] * y[s] * (1 / cell.tau_si)) -
         switched<T>(u, theta_v, T{}, fast_inward);
}

template <class T>
HEARTBUS_INLINE Gate<T> calcium(const CellType &cell, const T &u, const States<T> &y) {
  return {cell.calcium_rest + tau_c * cell.release * switched<T>(u, theta_w, T{}, y[r] * y[s]), T{} + tau_c};
}

/// What a step of a cell gives besides its states: the current [1/ms], and how far v is from its extrapolation.
template <class T>
struct Outcome {
  T current, error;
};

template <class T>
HEARTBUS_INLINE T finish_rates(const States<T> &y_n, States<T> &y_np1, double dt) {
  y_np1[v_rate] = (y_np1[v] - y_n[v]) * (1 / dt);
  return error_scale * dt * absolute(T(y_np1[v_rate] - y_n[v_rate]));
}

/// imex_euler (ionic_model.h): every variable but u is a gate, taken implicitly with u^n.
template <class T>
HEARTBUS_INLINE Outcome<T> step_euler(const CellType &cell, const T &u, const States<T> &y_n, States<T> &y_np1,
                                      double dt) {
  const auto gate = gates(cell, u);
  for (unsigned k = 0; k < gate.size(); ++k)
    y_np1[k] = (gate[k].tau * y_n[k] + dt * gate[k].inf) / (gate[k].tau + dt);
  const Gate<T> c = calcium(cell, u, y_np1);
  y_np1[Ca] = (c.tau * y_n[Ca] + dt * c.inf) / (c.tau + dt);
  const T error = finish_rates(y_n, y_np1, dt);
  return {current(cell, u, y_np1), error};
}

/// exponential_midpoint (ionic_model.h), `u` in the middle of the step.
template <class T>
HEARTBUS_INLINE Outcome<T> step_midpoint(const CellType &cell, const T &u, const States<T> &y_n, States<T> &y_np1,
                                         double dt) {
  States<T> y_middle;
  const auto gate = gates(cell, u);
  for (unsigned k = 0; k < gate.size(); ++k) {
    const T half = decay(T(0.5 * dt / gate[k].tau));
    y_middle[k] = gate[k].inf + half * (y_n[k] - gate[k].inf);
    y_np1[k] = gate[k].inf + half * (y_middle[k] - gate[k].inf);
  }
  const Gate<T> c = calcium(cell, u, y_middle);
  y_np1[Ca] = c.inf + decay(T(dt / c.tau)) * (y_n[Ca] - c.inf);
  const T error = finish_rates(y_n, y_np1, dt);
  return {current(cell, u, y_middle), error};
}

} // namespace heartbus::ep::bueno_orovio
