// expect: do not add to one another
#include "axode/lie.hpp"

using namespace axode;

auto sum(Wrench<Spatial> W, [[maybe_unused]] Twist<Spatial> V) {
#ifdef AXODE_CONTROL
  return W + W;
#else
  return W + V;
#endif
}
