#pragma once
#include <vector>

#include "axode/model/model.hpp"

namespace axode {

/// The parts of a Model, and the faults that are found only when its numbers are computed.
struct Compilation {
  std::vector<Body> bodies;
  std::vector<Joint> joints;
  std::vector<Frame> frames;
  Springs springs;
  Loops loops;
  Tree<double> tree;
  std::vector<Fault> faults;
};
/// Compiles a description that has passed inspect() without errors into the parts of a model.
Compilation compile(const Description& description);

}  // namespace axode
