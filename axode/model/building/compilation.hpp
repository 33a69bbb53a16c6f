#pragma once
#include <vector>

#include "axode/model/model.hpp"

namespace axode {

/// The result of a compilation: the parts of a Model, and the faults that cannot be found before the numbers
/// are computed.
struct Compilation {
  std::vector<Body> bodies;
  std::vector<Joint> joints;
  std::vector<Frame> frames;
  Springs springs;
  Loops loops;
  Tree<double> tree;
  std::vector<Fault> faults;
};
/// Compiles a description into the parts of a model. The description must have passed inspect() without an
/// error.
Compilation compile(const Description& description);

}  // namespace axode
