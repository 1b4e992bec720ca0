#include "ep_solver/ionic/pacing.h"

#include <cstdio>
#include <cstdlib>
#include <exception>

/// prepace MODEL [beats [cycle length in ms [step in ms]]]: paces a single cell from its published state and prints the
/// state it ends in, v [V] first: the row `limit_cycle` of the model.
int main(int argc, char **argv) {
  using namespace heartbus;
  try {
    const auto model = ep::make_ionic_model(argc > 1 ? argv[1] : "ttp06_epi");
    const int n_beats = argc > 2 ? std::atoi(argv[2]) : 800;
    ep::Pacing pacing;
    if (argc > 3)
      pacing.cycle_length = 1e-3 * std::atof(argv[3]);
    if (argc > 4)
      pacing.dt = 1e-3 * std::atof(argv[4]);
    ep::CellState cell = model->initial_state("published");
    for (int beat = 1; beat <= n_beats; ++beat) {
      const ep::Beat b = pace(*model, cell, pacing);
      if (beat % 100 == 0 || beat <= 3)
        std::printf("beat %d: %.3f to %.2f mV, APD90 %.2f ms, calcium %.4f to %.4f uM\n", beat, 1e3 * b.v_diastole,
                    1e3 * b.v_max, 1e3 * b.duration, b.calcium_diastole, b.calcium_peak);
    }
    std::printf("%.9g", cell.v);
    for (std::size_t s = 0; s < model->n_states(); ++s)
      std::printf(", %.9g", cell.states[s]);
    std::printf("\n");
  } catch (const std::exception &error) {
    std::fprintf(stderr, "prepace: %s\n", error.what());
    return 1;
  }
}
