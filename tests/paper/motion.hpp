#pragma once
#include <cstdint>
#include <tuple>
#include <vector>

#include "axode/axode.hpp"
#include "axode/kinematics/higher_order/product_of_exponentials.hpp"
#include "axode/lie/newton_euler.hpp"
#include "axode/recursion/link.hpp"
#include "tests/paper/series.hpp"
#include "tests/paper/systems.hpp"

namespace axode::test::paper {

template <class Rep>
inline constexpr Representation value_of = std::same_as<Rep, BodyFixed> ? Representation::body
                                           : std::same_as<Rep, Spatial> ? Representation::spatial
                                           : std::same_as<Rep, Hybrid>  ? Representation::hybrid
                                                                        : Representation::mixed;

/// A system with random q, v and a at t = 0, in the frames that the user placed.
///
/// Members that are named by symbols of the paper (C, V, J, Π, W, ...) are evaluated from their definitions,
/// with poses that are series in t and with point masses. Members that are named by words (pose, twist,
/// joint_wrench, ...) are results of the library. Frames are those of the model: 0 is the ground, 1 to n()
/// are the bodies, and com(i) is a frame of body i in its centre of mass.
class Motion {
 public:
  Motion(System system, std::uint64_t seed);

  // The mechanism and its state
  const Model& model() const { return system_.model; }
  int n() const { return model().n_bodies(); }
  const Body& body(int i) const { return model().body(i); }
  int predecessor(int i) const { return body(i).predecessor; }
  std::vector<int> children(int i) const;
  std::vector<int> path(int i) const;  ///< from the root to body i
  int com(int i) const { return model().frame_index(body(i).name + ".com"); }
  const SE3<>& S_bc(int i) const { return model().frame(com(i)).pose; }
  const Inertia<>& M(int i) const { return body(i).M; }
  const Drawn& drawn(int i) const { return system_.drawn[i]; }
  const std::vector<AppliedWrench<>>& loads() const { return system_.loads; }
  const std::vector<double>& q() const { return q_; }
  const std::vector<double>& v() const { return v_; }
  const std::vector<double>& a() const { return a_; }
  Matrix qd(int i) const { return of_joint(i, v_); }
  Matrix qdd(int i) const { return of_joint(i, a_); }
  Matrix X(int i) const;  ///< one column for each velocity of the joint
  Vec6 Xqd(int i) const { return X(i) * qd(i); }
  Vec6 Xqdd(int i) const { return X(i) * qdd(i); }
  // For joints with one screw
  double q(int i) const { return q_[model().joint(i).iq]; }
  Screw<> X_screw(int i) const { return body(i).X[0]; }
  JointFrames joint_frames(int i) const;  ///< the frames of the drawing, or those that the library chose if
                                          ///< the drawing has none
  SE3<> product_of_Y(int i) const;        ///< exp(Y_1 q_1) ... exp(Y_i q_i)

  // Configurations, twists and Jacobians by definition
  const PoseOfT& C_of_t(int f) const { return C_[f]; }
  PoseOfT C_of_t(int f, int g) const { return inverse(C_[f]) * C_[g]; }  ///< C_{f,g}
  SE3<> C(int f) const { return now(C_[f]); }
  SE3<> C(int f, int g) const { return now(C_of_t(f, g)); }
  Vec3<Series> r_of_t(int f, int g) const { return C_[g].r - C_[f].r; }  ///< r_{f,g}, from f to g
  template <class Rep> Vec6OfT V_of_t(int f) const { return twist_of(C_[f], value_of<Rep>); }
  template <class Rep> Vec6 V(int f) const { return now(V_of_t<Rep>(f)); }
  template <class Rep> Vec6 dV(int f) const { return rate(V_of_t<Rep>(f)); }
  /// J_{i,j}: the twist of body i if only joint j moves, with velocity 1. It has one column for each velocity
  /// of the joint.
  template <class Rep> Matrix J(int i, int j) const { return J(i, j, value_of<Rep>); }
  Vec3d ddr(int f) const { return second_rate(C_[f].r); }

  // A frame from which the motion of a body is described
  /// Where a representation measures and resolves; the mixed one resolves angular parts as body-fixed.
  template <class Rep> PoseOfT frame(int f) const { return frame(f, value_of<Rep>); }
  PoseOfT frame_jk(int j, int k) const { return {C_[k].R, C_[j].r}; }  ///< origin of F_j, axes of F_k
  /// The twist of the body of frame i, measured at the origin of F and resolved in F.
  Vec6OfT V_of_t(int i, const PoseOfT& F) const;

  // Momentum, inertia, energy and forces of the point masses on the body of frame i
  Vec6OfT Pi_of_t(int i, const PoseOfT& F) const;
  Mat6 M(int i, const PoseOfT& F) const;
  Vec6 W(int i, const PoseOfT& F) const;  ///< the wrench of the forces that accelerate them
  template <class Rep> Vec6OfT Pi_of_t(int f) const { return Pi_of_t(f, frame<Rep>(f)); }
  template <class Rep> Vec6 Pi(int f) const { return now(Pi_of_t<Rep>(f)); }
  template <class Rep> Vec6 W(int f) const { return W(f, value_of<Rep>); }
  double kinetic_energy(int i) const;
  /// W^app: the loads and the weight of body i.
  template <class Rep> Vec6 W_app(int i) const { return W_app(i, frame<Rep>(i)); }
  /// The wrench that joint i transmits: what body i and the bodies after it need beyond their loads and
  /// weights.
  template <class Rep> Vec6 transmitted(int i) const { return transmitted(i, frame<Rep>(i)); }

  // Results of the library
  SE3<> pose(int f) const { return pose_[f]; }
  SE3<> pose_at_zero(int f) const { return pose_at_zero_[f]; }  ///< at q = 0
  std::vector<SE3<>> poses_at(const std::vector<double>& q) const;
  template <class Rep> Twist<Rep> twist(int f) const { return answer<Rep>(Asked::twists).V[f]; }
  template <class Rep> TwistRate<Rep> twist_rate(int f) const {
    return answer<Rep>(Asked::accelerations).dV[f];
  }
  template <class Rep> Wrench<Rep> joint_wrench(int i) const {
    return answer<Rep>(Asked::joint_wrenches).W[i - 1];
  }
  /// The generalised forces of joint i, one for each velocity, with the loads counted.
  template <class Rep> Matrix joint_force(int i) const {
    return of_joint(i, answer<Rep>(Asked::joint_forces).tau);
  }
  Twist<Spatial> joint_screw(int i) const;  ///< J_i^s of a joint with one screw
  FramePair<> frame_pair(int j, int k) const;
  template <class Rep> Link<Rep, double> link(int i) const;  ///< what body i contributes to the recursions
  template <class Rep> Twist<Rep> push_Xqd(int i) const;  ///< X_i q̇_i in the recursions of a representation
  template <class Rep> Vec6 bias(int i) const;            ///< the terms that they add to V̇_i

 private:
  enum class Asked { twists, accelerations, joint_wrenches, joint_forces };
  template <class Rep> struct Answer {
    std::vector<Twist<Rep>> V;
    std::vector<TwistRate<Rep>> dV;
    std::vector<Wrench<Rep>> W;
    std::vector<double> tau;
  };
  /// Calls a function of the library when its result is first needed, so that a test runs only the code that
  /// it is about.
  template <class Rep> const Answer<Rep>& answer(Asked asked) const;
  Matrix of_joint(int i, const std::vector<double>& x) const;
  std::vector<PoseOfT> poses_of_t(const std::vector<double>& v, const std::vector<double>& a) const;
  Matrix J(int i, int j, Representation representation) const;
  PoseOfT frame(int f, Representation representation) const;
  Vec6 W(int f, Representation representation) const;
  Vec6 W_app(int i, const PoseOfT& F) const;
  Vec6 transmitted(int i, const PoseOfT& F) const;
  int body_of(int f) const { return model().frame(f).body; }
  Vec3<Series> position(int i, const PointMass& point) const { return C_[i] * cast<Series>(point.p); }

  System system_;
  std::vector<double> q_, v_, a_;
  std::vector<PoseOfT> C_;
  std::vector<SE3<>> pose_, pose_at_zero_;
  mutable std::tuple<Answer<BodyFixed>, Answer<Spatial>, Answer<Hybrid>, Answer<Mixed>> answers_;
};

/// M_c^b, the inertia in the frame F_c in the centre of mass.
inline CentralInertia<> M_c(const Motion& m, int i) {
  return {m.M(i).m, rotate(transpose(m.S_bc(i).R), inertia_about_com(m.M(i)))};
}

}  // namespace axode::test::paper
