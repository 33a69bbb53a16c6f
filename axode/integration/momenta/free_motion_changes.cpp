#include "axode/derivatives/spring_derivatives.hpp"
#include "axode/dynamics/mass_matrix/mass_matrix.hpp"
#include "axode/eigen.hpp"
#include "axode/integration/momenta/contact_step_derivative.hpp"
#include "axode/scalar/index.hpp"

/// The part of ContactStepDerivative for momenta and for the free motion between the impulses of a step.
namespace axode {
namespace {

using Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Joints = GroupDerivatives::Joints;

}  // namespace

ContactStepDerivative::Mass ContactStepDerivative::mass(const VectorXd& q) {
  Mass out{.M = Matrix(model_.nv(), model_.nv()), .factor = {}};
  mass_matrix(model_, workspace_, Numbers<double>(as_span(q)), as_span(out.M));
  out.factor.compute(out.M);
  return out;
}

ContactStepDerivative::Kinetic ContactStepDerivative::kinetic(const VectorXd& q, const VectorXd& v) {
  const Matrix square(v.size(), v.size());
  Kinetic out{square, square, square};
  momenta_->kinetic(*tree_, q.data(), v.data(), out.Mv_q.data(), out.F_q.data(), out.F_v.data());
  return out;
}

Matrix ContactStepDerivative::transposed(GroupDerivatives::Block Joints::*map, const Matrix& x) const {
  Matrix out = Matrix::Zero(x.rows(), x.cols());
  maps_.add_transposed(map, x, out);
  return out;
}

Matrix ContactStepDerivative::turn_of(const VectorXd& y, const VectorXd& p, bool Ad) const {
  // The maps do not mix joints, so that the same direction serves the k-th
  // velocities of all joints.
  const Eigen::Index nv = y.size();
  std::vector<Displaced> y_displaced(index(nv)), p_constant(index(nv)), out(index(nv));
  for (Eigen::Index c = 0; c < nv; ++c) {
    y_displaced[index(c)] = y[c];
    y_displaced[index(c)].dx[index(place_[index(c)])] = 1;
    p_constant[index(c)] = p[c];
  }
  if (Ad)
    displaced_group_.Ad_transpose(y_displaced.data(), p_constant.data(), out.data());
  else
    displaced_group_.dexp_transpose(y_displaced.data(), p_constant.data(), out.data());
  Matrix by_y = Matrix::Zero(nv, nv);
  const Topology& topology = model_.topology();
  for (int i = 1; i <= topology.n; ++i) {
    const int first = topology.iv[index(i)];
    const int n = topology.first_screw[index(i) + 1] - topology.first_screw[index(i)];
    if (n == 1) continue;
    for (int r = first; r < first + n; ++r)
      for (int k = 0; k < n; ++k) by_y(r, first + k) = out[index(r)].dx[index(k)];
  }
  return by_y;
}

/// Computes the velocity of the moving frame of each floating base from its linear momentum, and its changes.
void ContactStepDerivative::begin_bases(const ContactPart& part, const Start& start, const Matrix& Mv_q) {
  bases_.clear();
  const Matrix& M = start.mass.M;
  for (const ContactPart::Base& base : part.bases) {
    const Eigen::Index first = tree_->operator->()->iv[index(base.body)];
    const Eigen::Matrix3d R = to_eigen(motion_.poses()[index(base.body)].R);
    const auto translations = [&](const Matrix& x) { return x.middleRows<3>(first + 3); };
    const Eigen::Vector3d linear = translations(M) * start.v_a;
    Eigen::Matrix3Xd dlinear =
        translations(start.dp) + translations(Mv_q) * start.dq + translations(M) * start.dv;
    if (p_ > 0) dlinear.middleCols(first_, p_) += translations(parameter_changes_.momenta);
    const double mass = M(first + 3, first + 3);
    const Eigen::Vector3d u = R * linear / mass;
    Base out{base.body, first, base.constant, mass, from_eigen<Vec3<>>(u), {}, {}, {}};
    out.du = R * (dlinear - skew(from_eigen<Vec3<>>(linear)) * start.dq.middleRows<3>(first));
    if (along_.geometry.size() > 0) {
      out.turn = to_eigen(tree_->B[index(base.body)].R * tree_->frame_offset[index(base.body)].R) *
                 along_.geometry.middleRows<3>(6 * (base.body - 1));
      out.du.middleCols(first_, p_) -= R * skew(from_eigen<Vec3<>>(linear)) * R.transpose() * out.turn;
    }
    if (p_ > 0) {
      out.du.middleCols(first_, p_) -= u * parameter_changes_.mass(base.body);
      out.center = parameter_changes_.center(base.body);
    }
    out.du /= mass;
    bases_.push_back(out);
  }
}

/// Velocities of the moving frames of floating bases at the poses of motion_, as velocities of their joints.
VectorXd ContactStepDerivative::frame_velocity(double t) const {
  VectorXd e = VectorXd::Zero(model_.nv());
  for (const Base& base : bases_) {
    const SO3<> R = motion_.poses()[index(base.body)].R;
    e.segment<3>(base.first + 3) = to_eigen(transpose(R) * (base.u + t * tree_->g));
  }
  return e;
}

/// Adds the changes of the moving frames of floating bases to dq and dv, along the directions in which a step
/// is differentiated; one of them may be null. The coordinates of a floating base are relative to its moving
/// frame, which does not rotate and falls with gravity g. At the start of a substep (a step of a simulation
/// or a part of one), this frame has the velocity u of the centre of mass of the base with its subtree. A
/// `time` (s) later its velocity is u + g time. dv receives the changes of this velocity, times of_velocity
/// (1 or 0). g is constant, but the velocity is in the axes of the base, so that it also changes if the base
/// rotates, which is part of dq_moving, the changes of the coordinates relative to the moving frames. dq
/// receives the changes of the displacement of the frame since the start; of_place must then be `time`.
void ContactStepDerivative::add_frame_changes(double time, double of_place, double of_velocity,
                                              const Matrix& dq_moving, Matrix* dq, Matrix* dv) const {
  const VectorXd e = frame_velocity(time);
  for (const Base& base : bases_) {
    const Eigen::Matrix3d Rt = to_eigen(motion_.poses()[index(base.body)].R).transpose();
    const Eigen::Matrix3d turn_e = skew(from_eigen<Vec3<>>(e.segment<3>(base.first + 3)));
    if (dv)
      dv->middleRows<3>(base.first + 3) +=
          of_velocity * (Rt * base.du + turn_e * dq_moving.middleRows<3>(base.first));
    if (dq) dq->middleRows<3>(base.first + 3) += of_place * Rt * base.du;
    if (base.turn.size() == 0) continue;
    // The base turns by geometric parameters, and so do the axes of its translations.
    if (dv) dv->block(base.first + 3, first_, 3, p_) += of_velocity * turn_e * Rt * base.turn;
    const Eigen::Vector3d path = to_eigen(of_place * (base.u + (time / 2) * tree_->g));
    if (dq) dq->block(base.first + 3, first_, 3, p_) += Rt * skew(from_eigen<Vec3<>>(path)) * base.turn;
  }
}

Matrix ContactStepDerivative::rolling_changes(const ContactPart& part, const Start& start, const Matrix& dp) {
  const Eigen::Index nv = dp.rows();
  VectorXd weight(nv), velocity = part.v_0;
  system_.bias_forces(part.q_0.data(), VectorXd::Zero(nv).eval().data(), {}, weight.data());
  const Impulses& first = start.first;
  const VectorXd gain = start.mass.factor.solve(first.J.transpose() * first.physical() - part.h / 2 * weight);
  velocity += gain;
  RowMajor gravity(nv, nv);
  gravity_derivatives(model_, workspace_, Numbers<double>(as_span(part.q_0)), as_span(gravity));
  Matrix momenta = dp - (part.h / 2 * gravity + kinetic(part.q_0, gain).Mv_q) * start.dq;
  if (p_ > 0) {
    parameter_changes_.run(part.q_0.data(), gain.data(), along_);
    by_parameters(momenta) += part.h / 2 * parameter_changes_.gravity - parameter_changes_.momenta;
  }
  const Matrix dvelocity = start.dv + start.mass.factor.solve(momenta);
  VectorXd u;
  const Matrix du = velocity_changes(part.q_0, velocity, start.rows, start.dq, u) + first.J * dvelocity;
  return du.bottomRows(model_.loops().rows);
}

/// Computes, in the middle of a substep (a step of a simulation or a part of one), the derivatives f_q and
/// f_v by q and v of the forces f = p' - ad_vᵀ p on the joint momenta p = M v (D5.2), as far as they come
/// from the kinetic energy, gravity, springs and damping. ad_v is the Lie bracket of joint velocities with v,
/// taken joint by joint; it is 0 for joints with one velocity. For a floating base, q and v are relative to a
/// moving frame, which does not rotate and falls with gravity, so that f contains no gravity on the base and
/// its subtree. Adds to df the changes of f at constant q and v along the directions in which the step is
/// differentiated: those by the parameters of the mechanism, from parameter_changes_, and those of the forces
/// of springs, which depend on the motion of the moving frames.
void ContactStepDerivative::take_forces(const ContactPart& part, const Matrix& M, const Kinetic& at_m,
                                        const VectorXd& v_m, Matrix& f_q, Matrix& f_v, Matrix& df) {
  const double h = part.h;
  const Eigen::Index nv = v_m.size();
  const VectorXd p_m = M * v_m;
  const Matrix none = Matrix::Zero(nv, df.cols());
  f_q = at_m.F_q;
  f_v = at_m.F_v;
  if (!group_.commutes()) {
    VectorXd x(nv);
    for (Eigen::Index c = 0; c < nv; ++c) {
      group_.ad_transpose(v_m, at_m.Mv_q.col(c).data(), x);
      f_q.col(c) -= x;
      group_.ad_transpose(v_m, M.col(c).data(), x);
      f_v.col(c) -= x;
      group_.ad_transpose(VectorXd::Unit(nv, c).eval(), p_m, x);
      f_v.col(c) -= x;
    }
  }
  RowMajor gravity(nv, nv);
  gravity_derivatives(model_, workspace_, Numbers<double>(as_span(part.q_middle)), as_span(gravity));
  for (const Base& base : bases_) {
    const Topology& topology = model_.topology();
    for (int i = base.body; i < topology.subtree_end[index(base.body)]; ++i) {
      const Eigen::Index first = topology.iv[index(i)],
                         n = topology.first_screw[index(i) + 1] - topology.first_screw[index(i)];
      gravity.middleRows(first, n).setZero();
      if (p_ > 0) parameter_changes_.gravity.middleRows(first, n).setZero();
    }
  }
  f_q -= gravity;
  if (p_ > 0) by_parameters(df) += parameter_changes_.forces + parameter_changes_.gravity;
  if (damping_)
    for (Eigen::Index c = 0; c < nv; ++c) f_v(c, c) -= tree_->damping[index(c)];
  if (!model_.springs().empty()) {
    RowMajor by_place(nv, nv), by_velocity(nv, nv);
    spring_force_derivatives(model_, workspace_, Numbers<double>(as_span(part.q_middle)),
                             Numbers<double>(as_span(part.v_middle)),
                             {as_span(by_place), as_span(by_velocity)});
    Matrix along_frames = none, velocities = none, turned = Matrix::Zero(nv, nv);
    add_frame_changes(h / 2, h / 2, 1, none, &along_frames, &velocities);
    df += by_place * along_frames + by_velocity * velocities;
    const VectorXd e = frame_velocity(h / 2);
    for (const Base& base : bases_)
      turned.block<3, 3>(base.first + 3, base.first) = skew(from_eigen<Vec3<>>(e.segment<3>(base.first + 3)));
    f_q += by_place + by_velocity * turned;
    f_v += by_velocity;
  }
}

/// Differentiates the free motion (D11.20).
ContactStepDerivative::Flight ContactStepDerivative::fly(const ContactPart& part, const Start& start) {
  const double h = part.h;
  const Eigen::Index nv = start.dq.rows(), k = k_, m = start.dq.cols() - k;
  const Matrix none = Matrix::Zero(nv, k + m);
  Flight out;
  VectorXd v_m = part.v_middle;
  const Matrix no_direction(nv, 0);
  motion_.run(part.q_middle.data(), part.v_middle.data(), no_direction, no_direction);
  v_m -= frame_velocity(h / 2);
  const Matrix M_m = mass(part.q_middle).M;
  const Kinetic at_m = kinetic(part.q_middle, v_m);
  const VectorXd y = h / 2 * v_m;
  const VectorXd& p_0 = start.p;
  maps_.at(y.data(), y.data());
  Matrix carry = Matrix::Zero(nv, k + m), by_v = Matrix::Zero(nv, nv);
  maps_.add(&Joints::carry, start.dq, carry);
  maps_.add(&Joints::velocity, h / 2 * Matrix::Identity(nv, nv), by_v);
  if (p_ > 0) parameter_changes_.run(part.q_middle.data(), v_m.data(), along_);
  Matrix f_q, f_v, df = start.dtau;
  take_forces(part, M_m, at_m, v_m, f_q, f_v, df);
  const VectorXd q_1 = part.q_1;
  motion_.run(q_1.data(), part.v_before_end.data(), no_direction, no_direction);
  const VectorXd v_b = part.v_before_end - frame_velocity(h);
  out.at_1 = mass(q_1);
  const Matrix& M_1 = out.at_1.M;
  const VectorXd p_plus = transposed(&Joints::carry, M_1 * v_b);
  maps_.at((-y).eval().data(), y.data());
  const Matrix f_by_v = f_q * by_v + f_v, turn_0 = h / 2 * turn_of(y, p_0, true);
  const Matrix p_plus_by_v = turn_0 + h * f_by_v;
  const Matrix N = M_m + at_m.Mv_q * by_v - h / 2 * turn_of(y, (p_0 + p_plus) / 2, false) -
                   transposed(&Joints::velocity, p_plus_by_v / 2);
  Matrix dp_plus = transposed(&Joints::carry, start.dp) + h * (df + f_q * carry);
  Matrix left = transposed(&Joints::velocity, (start.dp + dp_plus) / 2) - at_m.Mv_q * carry;
  if (p_ > 0) by_parameters(left) -= parameter_changes_.momenta;
  const Matrix dv_m = LuFactor(N).solve(left);
  dp_plus += p_plus_by_v * dv_m;
  out.dq_m = carry + by_v * dv_m;
  out.dp_1 = transposed(&Joints::carry, dp_plus) + h / 2 * turn_of(y, p_plus, true) * dv_m;
  maps_.at((2 * y).eval().data(), y.data());
  Matrix& dq_1 = out.dq_1;
  dq_1 = none;
  maps_.add(&Joints::carry, start.dq, dq_1);
  maps_.add(&Joints::velocity, h * dv_m, dq_1);
  for (const Base& base : bases_) {
    if (!base.constant) continue;
    const Eigen::Index linear = base.first + 3;
    // The poses of motion_ are those at the end here. If forces on the base change, they move the centre of
    // mass.
    const Eigen::Matrix3d R_1 = to_eigen(motion_.poses()[index(base.body)].R);
    const double* const q_0 = part.q_0.data() + model_.topology().iq[index(base.body)];
    const SE3<> C_0 = subgroup::Free<double>::pose(tree_->B[index(base.body)], q_0);
    Eigen::Matrix3Xd shift = (to_eigen(C_0.R) * start.mass.M.middleRows<3>(linear) * start.dq -
                              R_1 * M_1.middleRows<3>(linear) * dq_1) /
                             base.mass;
    if (p_ > 0) {
      parameter_changes_.run(q_1.data(), v_b.data(), along_);
      shift.middleCols(first_, p_) += base.center - parameter_changes_.center(base.body);
      // The centre of mass turns about another point in the moving frame than in the inertial one.
      if (base.turn.size() > 0)
        shift.middleCols(first_, p_) -= skew(h * (base.u + (h / 2) * tree_->g)) * base.turn;
    }
    for (Eigen::Index c = 0; c < k; ++c)
      if (!start.dtau.col(c).segment<6>(base.first).isZero(0)) shift.col(c).setZero();
    dq_1.middleRows<3>(linear) += R_1.transpose() * shift;
  }
  // Converts changes in the moving frames to changes in the inertial frame, at the end and in the middle.
  const Matrix dq_moving_1 = dq_1;
  add_frame_changes(h, h, 0, dq_moving_1, &dq_1, nullptr);
  motion_.run(part.q_middle.data(), part.v_middle.data(), no_direction, no_direction);
  out.dv_m = dv_m;
  const Matrix dq_moving_m = out.dq_m;
  add_frame_changes(h / 2, h / 2, 1, dq_moving_m, &out.dq_m, &out.dv_m);
  return out;
}

}  // namespace axode
