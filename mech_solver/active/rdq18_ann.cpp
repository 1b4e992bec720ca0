// The weights below are those of the trained network published at github.com/FrancescoRegazzoni/cardiac-activation-ann
// under the MIT licence:
//
// Copyright (c) 2020 Francesco Regazzoni
//
// Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated
// documentation files (the "Software"), to deal in the Software without restriction, including without limitation the
// rights to use, copy, modify, merge, publish, distribute, sublicense, and/or sell copies of the Software, and to
// permit persons to whom the Software is furnished to do so, subject to the following conditions:
//
// The above copyright notice and this permission notice shall be included in all copies or substantial portions of the
// Software.
//
// THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE
// WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR
// COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR
// OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE.

#include "mech_solver/active/rdq18_ann.h"

#include "common/simd/vectorized_math.h"

#include <algorithm>
#include <cstring>

namespace heartbus::mech {

namespace {

constexpr double W0[6][4] = {
    {-0.348265374557757, 0.0791690044894968, 0.194896350878374, 0.353199731781344},
    {0.1190982968129, 1.42720820906103, 0.656209938054853, 5.05296497140774},
    {-0.32694767329282, 0.467375538019002, -0.26127527283548, -2.34652559281197},
    {-0.111813436760289, 0.0781472387999386, 0.579379679043339, 0.474127958921041},
    {-0.377517431597444, 0.803645971142958, -0.680369822829215, -1.43782499431302},
    {-0.343489412197913, 1.71999910535706, -0.071879846906297, 10.4445869331832},
};
constexpr double b0[6] = {0.0310785788806474, 4.36724351340544,   -0.683276510781984,
                          -0.391300052716311, -0.444992394302788, 5.61198319244018};

constexpr double W1[6][6] = {
    {1.8831633425318, 0.310140552841259, -5.54817352592678, -2.2797843277202, 5.21702581901124, 1.05720237563698},
    {-6.49350361035868, -5.2673687910723, 6.47928712333821, 17.8565201689898, -6.44059658341999, 1.66415392631682},
    {6.59877131868327, -4.16545915312989, 19.6712213833001, -26.9949649431556, -4.53705944347126, 6.18224597231019},
    {5.23448138817053, 0.302725285514981, -3.39384093593541, -9.53547208055024, 1.31690510269088, -0.919724542794827},
    {-8.29496680910701, -4.51716312452067, 18.6113143946444, 16.6218453774498, -18.561663590052, 3.69629940920934},
    {2.36943728469629, 4.32927481011145, 5.84035724719919, -11.4356704355626, -4.04922413015352, -0.783748018510534},
};
constexpr double b1[6] = {-3.11077617514455, 9.80699678868768, 0.260465778800691,
                          -6.25864759340584, 8.48610952395273, -6.02760125184262};

constexpr double W2[2][6] = {
    {-22.9072604551266, -17.129799654303, 4.75358914203894, -5.86920295635699, -18.2151979863996, -11.9169998829762},
    {-2.28451004465549, 7.70470965443537, 6.39560567023131, -0.690728880913998, 2.88498097156162, 5.18542205388068},
};
constexpr double b2[2] = {-12.3252815427869, -7.98245632382205};

/// y = W x - b
template <unsigned m, unsigned n>
HEARTBUS_INLINE void layer(const double (&W)[m][n], const double (&b)[m], const double *x, double *y) {
  for (unsigned i = 0; i < m; ++i) {
    y[i] = -b[i];
    for (unsigned j = 0; j < n; ++j)
      y[i] += W[i][j] * x[j];
  }
}

/// The six neurons of a layer, and two that stay at rest, so that they fill two vectors.
using Neurons = double[2 * fem::n_lanes];

HEARTBUS_INLINE void activate(Neurons &y) {
  for (double *four = y; four < std::end(y); four += fem::n_lanes) {
    fem::VectorizedDouble value;
    std::memcpy(&value, four, sizeof(value));
    value = fem::tanh(value);
    std::memcpy(four, &value, sizeof(value));
  }
}

HEARTBUS_SIMD void network(const double *x, double *output) {
  Neurons y = {}, z = {};
  layer(W0, b0, x, y);
  activate(y);
  layer(W1, b1, y, z);
  activate(z);
  layer(W2, b2, z, output);
}

} // namespace

std::unique_ptr<ActiveModel> make_rdq18_ann() { return std::make_unique<Rdq18Ann>(); }

std::vector<double> Rdq18Ann::initial_state() const { return {0.00149278707634298, 0}; }

void Rdq18Ann::rate(const double *s, double calcium, double sarcomere_length, double *ds) const {
  const double x[4] = {calcium, std::clamp(sarcomere_length, shortest, longest), s[0], s[1]};
  network(x, ds);
}

void Rdq18Ann::advance(double dt, double calcium, double sarcomere_length, double *s) const {
  double ds[2];
  rate(s, calcium, sarcomere_length, ds);
  s[0] += dt * ds[0];
  s[1] += dt * ds[1];
}

} // namespace heartbus::mech
