// expect: do not add to one another
#include "axode/lie.hpp"

using namespace axode;

auto sum(Wrench<Hybrid> W, [[maybe_unused]] Momentum<Hybrid> Pi) {
#ifdef AXODE_CONTROL
  return W + W;
#else
  return W + Pi;
#endif
}
