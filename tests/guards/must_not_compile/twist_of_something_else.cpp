// expect: a twist is BodyFixed, Spatial, Hybrid, Mixed or InFrames
#include "axode/lie.hpp"

using namespace axode;

#ifdef AXODE_CONTROL
Twist<Mixed> V;
#else
Twist<int> V;
#endif
