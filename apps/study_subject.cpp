// Compiled once for each representation and choice of frames: many kernels in one unit exhaust the compiler's inlining
// budget.
#include "study_subject.hpp"

#ifndef AXODE_REP  // as an editor sees it
#define AXODE_REP BodyFixed
#define AXODE_FRAMES JointFrames
#endif

namespace axode::command {
template std::unique_ptr<Subject> make_subject<AXODE_REP, AXODE_FRAMES>(const Model&, const State&);
}  // namespace axode::command
