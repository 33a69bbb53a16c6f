#pragma once
#include <vector>

#include "axode/model/model.hpp"

namespace axode {

/// A description turned into numbers, and what only the numbers show to be wrong or doubtful with it.
struct Compilation {
  std::vector<Body> bodies;
  std::vector<Joint> joints;
  std::vector<Frame> frames;
  Springs springs;
  Loops loops;
  Tree<double> tree;
  std::vector<Fault> faults;
};
/// The description must have passed inspect() without an error.
Compilation compile(const Description& description);

}  // namespace axode
