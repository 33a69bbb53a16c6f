// This file is compiled once for each representation, and once for Fast.
#include "apps/study/study_subject.hpp"

#ifndef AXODE_REP  // if an editor parses this file
#define AXODE_REP BodyFixed
#endif

namespace axode::command {

template std::unique_ptr<Subject> make_subject<AXODE_REP, JointFrames>(const Model&, const State&);
#ifndef AXODE_JOINT_FRAMES_ONLY
template std::unique_ptr<Subject> make_subject<AXODE_REP, UserFrames>(const Model&, const State&);
template std::unique_ptr<Subject> make_subject<AXODE_REP, MassCenterFrames>(const Model&, const State&);
template std::unique_ptr<Subject> make_subject<AXODE_REP, ConstructionFrames>(const Model&, const State&);
#endif

}  // namespace axode::command
