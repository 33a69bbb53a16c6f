// expect: do not add to one another
#include "axode/lie.hpp"

using namespace axode;

auto sum(Twist<BodyFixed> V, [[maybe_unused]] TwistRate<BodyFixed> dV) {
#ifdef AXODE_CONTROL
  return V + V;
#else
  return V + dV;
#endif
}
