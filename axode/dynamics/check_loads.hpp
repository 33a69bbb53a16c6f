#pragma once
#include "axode/kinematics/check_arguments.hpp"
#include "axode/recursion/loads.hpp"

namespace axode {

template <class T> void check_loads(const Model& model, const Loads<T>& loads) {
  for (const AppliedWrench<T>& load : loads.wrenches)
    if (load.frame < 0 || load.frame >= model.n_frames())
      throw std::invalid_argument("loads: a wrench acts on frame " + std::to_string(load.frame) +
                                  "; model \"" + model.name() + "\" has frames 0 to " +
                                  std::to_string(model.n_frames() - 1));
}

}  // namespace axode
