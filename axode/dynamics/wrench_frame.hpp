#pragma once
#include "axode/dynamics/joint_wrenches.hpp"
#include "axode/model/model.hpp"

namespace axode {

/// The pose of the frame in which the wrench of joint i is given, in the joint frame of body i. This frame
/// has the axes of the body frame that the user placed. Its origin is that of the body frame
/// (WrenchPoint::body) or the point of the joint (WrenchPoint::joint).
template <class T> SE3<T> wrench_frame(const Model& model, int i, WrenchPoint at) {
  const SE3<T>& body = model.tree<T>().frame_offset[i];
  return at == WrenchPoint::body ? body : body * SE3<T>{{}, cast<T>(model.body(i).S_self.r)};
}

}  // namespace axode
