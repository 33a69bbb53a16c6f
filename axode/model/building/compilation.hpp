#pragma once
#include <vector>

#include "axode/model/model.hpp"

namespace axode {

/// The result of a compilation: the numbers of a mechanism, and the faults that only the numbers show.
struct Compilation {
  std::vector<Body> bodies;
  std::vector<Joint> joints;
  std::vector<Frame> frames;
  Springs springs;
  Loops loops;
  Tree<double> tree;
  std::vector<Fault> faults;
};
/// Compiles a description, which must have passed inspect() without an error.
Compilation compile(const Description& description);

}  // namespace axode
