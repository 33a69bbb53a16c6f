#pragma once
#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "axode/lie/se3.hpp"

namespace axode {

/// The kinds of loop joints, which constrain the relative motion of two bodies in addition to the joints of
/// the spanning tree. Rods, rolling contacts and belts are loop joints as well.
enum class LoopKind {
  fixed,
  revolute,
  prismatic,
  helical,
  cylindrical,
  spherical,
  planar,
  translational,  ///< all translations are free and no rotation is
  universal,
  rod,      ///< massless rod with a ball joint at either end: two points keep their distance
  rolling,  ///< rolling of a wheel or a sphere on a plane, without slip
  belt,     ///< span of a belt that does not stretch, from one pulley to another
};

/// The properties of a kind of loop joints, without its equations, which are in axode/constraints/loops.
struct LoopTraits {
  LoopKind kind;
  std::string_view name;
  int rows;       ///< number of rows of the Jacobian
  int residuals;  ///< number of residuals; fewer than rows if some rows have no position level
  /// For each of the motions ω_x ω_y ω_z v_x v_y v_z, whether the joint leaves it free. For a helical joint
  /// ω_z is free, and v_z = pitch ω_z follows from it. A universal joint has the same entries as a spherical
  /// joint, but one more constraint equation. For rods, rolling contacts and belts, whose motions do not form
  /// a subgroup, all entries are false.
  std::array<bool, 6> free;
  bool located;  ///< whether the position of the joint matters and not only its directions
  /// The members of LoopDescription by which a joint of this kind is described in the inertial frame at q =
  /// 0. Its two joint frames coincide there, unless `second_axis`, `points` or `center` is one of the
  /// members.
  std::array<std::string_view, 5> keys;

  constexpr bool has(std::string_view key) const {
    return std::find(keys.begin(), keys.end(), key) != keys.end();
  }
};

inline constexpr std::array<LoopTraits, 12> loop_kinds{{
    {LoopKind::fixed, "fixed", 6, 6, {}, false, {"point"}},
    {LoopKind::revolute, "revolute", 5, 5, {0, 0, 1, 0, 0, 0}, true, {"axis", "point"}},
    {LoopKind::prismatic, "prismatic", 5, 5, {0, 0, 0, 0, 0, 1}, false, {"axis", "point"}},
    {LoopKind::helical, "helical", 5, 5, {0, 0, 1, 0, 0, 0}, true, {"axis", "point", "pitch"}},
    {LoopKind::cylindrical, "cylindrical", 4, 4, {0, 0, 1, 0, 0, 1}, true, {"axis", "point"}},
    {LoopKind::spherical, "spherical", 3, 3, {1, 1, 1, 0, 0, 0}, true, {"point"}},
    {LoopKind::planar, "planar", 3, 3, {0, 0, 1, 1, 1, 0}, true, {"axis", "point"}},
    {LoopKind::translational, "translational", 3, 3, {0, 0, 0, 1, 1, 1}, false, {"point"}},
    {LoopKind::universal,
     "universal",
     4,
     4,
     {1, 1, 1, 0, 0, 0},
     true,
     {"axis", "second_axis", "point", "angle"}},
    {LoopKind::rod, "rod", 1, 1, {}, true, {"points", "length"}},
    {LoopKind::rolling, "rolling", 3, 1, {}, true, {"axis", "point", "center", "wheel_axis", "radius"}},
    {LoopKind::belt, "belt", 1, 0, {}, true, {"axis", "points", "radii"}},
}};

constexpr const LoopTraits& traits(LoopKind kind) {
  return *std::find_if(loop_kinds.begin(), loop_kinds.end(),
                       [&](const LoopTraits& t) { return t.kind == kind; });
}
constexpr std::string_view to_string(LoopKind kind) { return traits(kind).name; }

/// The name of a loop joint or coupling, the indices of its rows in the loop Jacobian A of the constraints A
/// v = 0, and the indices of its residuals, which are 0 if the loop is closed.
struct LoopRows {
  std::string name;
  int first_row = 0, rows = 1;
  int first_residual = 0, residuals = 1;
};

/// A loop joint as the kernels read it, see loop_jacobian().
struct Loop : LoopRows {
  struct End {
    int body = 0;
    SE3<> F;  ///< pose of the joint frame in the internal frame of the body
  };
  LoopKind kind{};
  std::array<End, 2> ends = {};
  double pitch = 0;  ///< pitch of a helical joint, m/rad
  /// Length of a rod or radius of a rolling body, m; cosine between the axes of a universal joint.
  double size = 0;
  bool wheel = false;  ///< whether the rolling body is a wheel
  /// The radii of the two pulleys of a belt, m. The loop joint is one straight span of the belt. A radius is
  /// negative if its pulley turns clockwise about the z-axis of the joint frame on the first body when
  /// the belt runs along this span from the first pulley to the second. The signs thus determine on which
  /// side of each pulley the span touches it. The axes of both pulleys are parallel to this z-axis.
  std::array<double, 2> radii = {};
};

/// A coupling Σ factor q = offset of the coordinates of several joints. Its row of the loop Jacobian A in A v
/// = 0 has these factors.
struct LoopCoupling : LoopRows {
  struct Term {
    int coordinate, velocity;
    double factor;
  };
  std::vector<Term> terms = {};
  double offset = 0;
};

/// A coupling with play, |Σ factor q - offset| <= play/2. Simulations treat the ends of the play as contacts.
struct Backlash {
  std::string name;
  std::vector<LoopCoupling::Term> terms = {};
  double offset = 0, play = 0;
  double restitution = 0;
};

/// The loop joints and couplings of a mechanism.
struct Loops {
  std::vector<Loop> joints;
  std::vector<LoopCoupling> couplings;
  std::vector<LoopRows> all;         ///< the entries of `joints`, followed by those of `couplings`
  int rows = 0, residuals = 0;       ///< total numbers of rows and residuals
  std::vector<Backlash> backlashes;  ///< couplings with play, which are not in `couplings`
  std::vector<char> driven;          ///< nv: whether the velocity belongs to a joint that has a drive

  bool empty() const { return all.empty(); }
};

}  // namespace axode
