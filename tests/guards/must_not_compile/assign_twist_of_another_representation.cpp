// expect: no match for or no viable or conversion from
#include "axode/lie.hpp"

using namespace axode;

void assign(Twist<Mixed>& V, [[maybe_unused]] Twist<Mixed> U, [[maybe_unused]] Twist<BodyFixed> W) {
#ifdef AXODE_CONTROL
  V = U;
#else
  V = W;
#endif
}
