#pragma once

/// The ionic models there are: the name in the scene and the function that makes the model. One line a model.
#define HEARTBUS_IONIC_MODELS(model)                                                                                   \
  model("ttp06_epi", make_ttp06_epi) model("ttp06_endo", make_ttp06_endo) model("ttp06_mid", make_ttp06_mid)           \
      model("bueno_orovio_epi", make_bueno_orovio_epi) model("bueno_orovio_endo", make_bueno_orovio_endo)              \
          model("bueno_orovio_mid", make_bueno_orovio_mid)
