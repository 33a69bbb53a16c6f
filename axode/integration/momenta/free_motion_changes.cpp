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

Matrix ContactStepDerivative::mass_matrix_at(const VectorXd& q) {
  Matrix M(model_.nv(), model_.nv());
  mass_matrix(model_, workspace_, Numbers<double>(as_span(q)), as_span(M));
  return M;
}

ContactStepDerivative::Mass ContactStepDerivative::mass(const VectorXd& q) {
  const Matrix M = mass_matrix_at(q);
  return {M, CholeskyFactor(M)};
}

ContactStepDerivative::Kinetic ContactStepDerivative::kinetic(const VectorXd& q, const VectorXd& v) {
  const Matrix square(v.size(), v.size());
  Kinetic out{square, square, square};
  momenta_->kinetic(*tree_, q.data(), v.data(), out.Mv_q.data(), out.F_q.data(), out.F_v.data());
  return out;
}

Matrix ContactStepDerivative::momenta_by_q(const VectorXd& q, const VectorXd& v) {
  Matrix out(v.size(), v.size());
  momenta_->kinetic(*tree_, q.data(), v.data(), out.data());
  return out;
}

template <class M>
M ContactStepDerivative::transposed(GroupDerivatives::Block Joints::*map, const M& x) const {
  M out = M::Zero(x.rows(), x.cols());
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

Eigen::Matrix3d ContactStepDerivative::rotation(int base, const VectorXd& q) const {
  const double* const q_of_base = q.data() + model_.topology().iq[index(base)];
  return to_eigen(subgroup::Free<double>::pose(tree_->B[index(base)], q_of_base).R);
}

/// Computes the velocity of the moving frame of each floating base from its linear momentum.
void ContactStepDerivative::begin_bases(const ContactPart& part, const Start& start) {
  bases_.clear();
  const Matrix& M = start.mass.M;
  for (const ContactPart::Base& base : part.bases) {
    const Eigen::Index first = model_.topology().iv[index(base.body)];
    const double mass = M(first + 3, first + 3);
    const Eigen::Vector3d u = rotation(base.body, part.q_0) * (M.middleRows<3>(first + 3) * start.v_a) / mass;
    bases_.push_back({base.body, first, base.constant, mass, from_eigen<Vec3<>>(u), {}, {}, {}});
  }
}

/// Computes the changes of the velocities of the moving frames. Mv_q and parameter_changes_ belong to the
/// velocities in the moving frames. The velocity u of a frame adds to the linear momentum of the base only
/// the product of the mass and u, whose change is that of u and, by parameters, of the mass.
void ContactStepDerivative::differentiate_bases(const ContactPart& part, const Start& start,
                                                const Matrix& Mv_q) {
  for (Base& base : bases_) {
    const Eigen::Matrix3d R = rotation(base.body, part.q_0);
    const auto translations = [&](const auto& x) { return x.template middleRows<3>(base.first + 3); };
    const Eigen::Matrix3d turn_linear = skew(from_eigen<Vec3<>>(translations(start.mass.M) * start.v_a));
    VectorChanges dlinear = translations(start.dp);
    add_product(translations(Mv_q), start.dq, dlinear);
    add_product(translations(start.mass.M), start.dv, dlinear);
    if (p_ > 0) dlinear.middleCols(first_, p_) += translations(parameter_changes_.momenta);
    subtract_product(turn_linear, start.dq.middleRows<3>(base.first), dlinear);
    base.du = product(R, dlinear);
    if (along_.geometry.size() > 0) {
      base.turn = to_eigen(tree_->B[index(base.body)].R * tree_->frame_offset[index(base.body)].R) *
                  along_.geometry.middleRows<3>(6 * (base.body - 1));
      base.du.middleCols(first_, p_) -= R * turn_linear * R.transpose() * base.turn;
    }
    if (p_ > 0) base.center = parameter_changes_.center(base.body);
    base.du /= base.mass;
  }
}

/// Velocities of the moving frames of floating bases, as velocities of their joints at q.
VectorXd ContactStepDerivative::frame_velocity(const VectorXd& q, double t) const {
  VectorXd e = VectorXd::Zero(model_.nv());
  for (const Base& base : bases_)
    e.segment<3>(base.first + 3) = rotation(base.body, q).transpose() * to_eigen(base.u + t * tree_->g);
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
void ContactStepDerivative::add_frame_changes(const VectorXd& q, double time, double of_place,
                                              double of_velocity, const Changes& dq_moving, Changes* dq,
                                              Changes* dv) const {
  const VectorXd e = frame_velocity(q, time);
  for (const Base& base : bases_) {
    const Eigen::Matrix3d Rt = rotation(base.body, q).transpose();
    const Eigen::Matrix3d turn_e = skew(from_eigen<Vec3<>>(e.segment<3>(base.first + 3)));
    const auto linear = [&](Changes& x) { return x.middleRows<3>(base.first + 3); };
    if (dv) {
      add_product(Eigen::Matrix3d(of_velocity * Rt), base.du, linear(*dv));
      add_product(Eigen::Matrix3d(of_velocity * turn_e), dq_moving.middleRows<3>(base.first), linear(*dv));
    }
    if (dq) add_product(Eigen::Matrix3d(of_place * Rt), base.du, linear(*dq));
    if (base.turn.size() == 0) continue;
    // The base turns by geometric parameters, and so do the axes of its translations.
    if (dv) dv->block(base.first + 3, first_, 3, p_) += of_velocity * turn_e * Rt * base.turn;
    const Eigen::Vector3d path = to_eigen(of_place * (base.u + (time / 2) * tree_->g));
    if (dq) dq->block(base.first + 3, first_, 3, p_) += Rt * skew(from_eigen<Vec3<>>(path)) * base.turn;
  }
}

Changes ContactStepDerivative::rolling_changes(const ContactPart& part, const Start& start,
                                               const Changes& dp) {
  const Eigen::Index nv = dp.rows();
  VectorXd weight(nv), velocity = part.v_0;
  system_.bias_forces(part.q_0.data(), VectorXd::Zero(nv).eval().data(), {}, weight.data());
  const Impulses& first = start.first;
  const VectorXd gain = start.mass.factor.solve(first.J.transpose() * first.physical() - part.h / 2 * weight);
  velocity += gain;
  RowMajor gravity(nv, nv);
  gravity_derivatives(model_, workspace_, Numbers<double>(as_span(part.q_0)), as_span(gravity));
  Changes momenta = dp;
  subtract_product(Matrix(part.h / 2 * gravity + momenta_by_q(part.q_0, gain)), start.dq, momenta);
  if (p_ > 0) {
    parameter_changes_.run(part.q_0.data(), gain.data(), along_);
    by_parameters(momenta) += part.h / 2 * parameter_changes_.gravity - parameter_changes_.momenta;
  }
  VectorXd u;
  Changes du = velocity_changes(part.q_0, velocity, start.rows, start.dq, u);
  add_product(first.J, start.dv + start.mass.factor.solve_changes(momenta), du);
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
                                        const VectorXd& v_m, Matrix& f_q, Matrix& f_v, Changes& df) {
  const double h = part.h;
  const Eigen::Index nv = v_m.size();
  const VectorXd p_m = M * v_m;
  const Changes none = Changes::Zero(nv, df.cols());
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
    Changes along_frames = none, velocities = none;
    Matrix turned = Matrix::Zero(nv, nv);
    add_frame_changes(part.q_middle, h / 2, h / 2, 1, none, &along_frames, &velocities);
    add_product(by_place, along_frames, df);
    add_product(by_velocity, velocities, df);
    const VectorXd e = frame_velocity(part.q_middle, h / 2);
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
  Flight out;
  const VectorXd v_m = part.v_middle - frame_velocity(part.q_middle, h / 2);
  const Matrix M_m = mass_matrix_at(part.q_middle);
  const Kinetic at_m = kinetic(part.q_middle, v_m);
  const VectorXd y = h / 2 * v_m;
  const VectorXd& p_0 = start.p;
  maps_.at(y.data(), y.data());
  Changes carry = Changes::Zero(nv, k + m);
  Matrix by_v = Matrix::Zero(nv, nv);
  maps_.add(&Joints::carry, start.dq, carry);
  maps_.add(&Joints::velocity, Matrix(h / 2 * Matrix::Identity(nv, nv)), by_v);
  if (p_ > 0) parameter_changes_.run(part.q_middle.data(), v_m.data(), along_);
  Matrix f_q, f_v;
  Changes df = start.dtau;
  take_forces(part, M_m, at_m, v_m, f_q, f_v, df);
  const VectorXd q_1 = part.q_1;
  const VectorXd v_b = part.v_before_end - frame_velocity(q_1, h);
  out.at_1 = mass(q_1);
  const Matrix& M_1 = out.at_1.M;
  const VectorXd p_plus = transposed(&Joints::carry, VectorXd(M_1 * v_b));
  maps_.at((-y).eval().data(), y.data());
  const Matrix f_by_v = f_q * by_v + f_v, turn_0 = h / 2 * turn_of(y, p_0, true);
  const Matrix p_plus_by_v = turn_0 + h * f_by_v;
  const Matrix N = M_m + at_m.Mv_q * by_v - h / 2 * turn_of(y, (p_0 + p_plus) / 2, false) -
                   transposed(&Joints::velocity, Matrix(p_plus_by_v / 2));
  add_product(f_q, carry, df);
  Changes dp_plus = transposed(&Joints::carry, start.dp) + h * df;
  Changes left = transposed(&Joints::velocity, Changes((start.dp + dp_plus) / 2));
  subtract_product(at_m.Mv_q, carry, left);
  if (p_ > 0) by_parameters(left) -= parameter_changes_.momenta;
  out.dv_m = LuFactor(N).solve_changes(left);
  Changes& dv_m = out.dv_m;
  add_product(p_plus_by_v, dv_m, dp_plus);
  out.dq_m = carry;
  add_product(by_v, dv_m, out.dq_m);
  out.dp_1 = transposed(&Joints::carry, dp_plus);
  add_product(Matrix(h / 2 * turn_of(y, p_plus, true)), dv_m, out.dp_1);
  maps_.at((2 * y).eval().data(), y.data());
  Changes& dq_1 = out.dq_1;
  dq_1.setZero(nv, k + m);
  maps_.add(&Joints::carry, start.dq, dq_1);
  maps_.add(&Joints::velocity, Changes(h * dv_m), dq_1);
  for (const Base& base : bases_) {
    if (!base.constant) continue;
    const Eigen::Index linear = base.first + 3;
    const Eigen::Matrix3d R_0 = rotation(base.body, part.q_0), R_1 = rotation(base.body, q_1);
    // If forces on the base change, they move the centre of mass.
    VectorChanges shift = product(Matrix(R_0 * start.mass.M.middleRows<3>(linear)), start.dq);
    subtract_product(Matrix(R_1 * M_1.middleRows<3>(linear)), dq_1, shift);
    shift /= base.mass;
    if (p_ > 0) {
      parameter_changes_.run(q_1.data(), v_b.data(), along_);
      shift.middleCols(first_, p_) += base.center - parameter_changes_.center(base.body);
      // The centre of mass turns about another point in the moving frame than in the inertial one.
      if (base.turn.size() > 0)
        shift.middleCols(first_, p_) -= skew(h * (base.u + (h / 2) * tree_->g)) * base.turn;
    }
    for (Eigen::Index c = 0; c < k; ++c)
      if (!start.dtau.col(c).segment<6>(base.first).isZero(0)) shift.col(c).setZero();
    add_product(R_1.transpose(), shift, dq_1.middleRows<3>(linear));
  }
  // Converts changes in the moving frames to changes in the inertial frame, at the end and in the middle.
  const Changes dq_moving_1 = dq_1;
  add_frame_changes(q_1, h, h, 0, dq_moving_1, &dq_1, nullptr);
  const Changes dq_moving_m = out.dq_m;
  add_frame_changes(part.q_middle, h / 2, h / 2, 1, dq_moving_m, &out.dq_m, &dv_m);
  return out;
}

}  // namespace axode
