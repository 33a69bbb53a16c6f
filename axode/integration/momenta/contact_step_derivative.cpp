#include "axode/integration/momenta/contact_step_derivative.hpp"

#include <algorithm>

#include "axode/contact/law/problem_derivative.hpp"
#include "axode/derivatives/spring_derivatives.hpp"
#include "axode/dynamics/mass_matrix/mass_matrix.hpp"
#include "axode/integration/momenta/contact_step.hpp"

namespace axode {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Joints = GroupDerivatives::Joints;

std::size_t index(Eigen::Index k) { return static_cast<std::size_t>(k); }

std::span<const double> entries(const Vector& x) { return {x.data(), index(x.size())}; }
std::span<double> entries(RowMajor& x) { return {x.data(), index(x.size())}; }

/// The size of velocities, or of columns of velocities, in the metric of the masses.
double mass_norm(const Matrix& M, const Matrix& x) {
  return std::sqrt(std::max(0.0, x.cwiseProduct(M * x).sum()));
}

/// The place of a contact with a key, or -1.
int place_of(const std::vector<Contact>& contacts, std::uint64_t key) {
  const auto found = std::ranges::find(contacts, key, &Contact::key);
  return found == contacts.end() ? -1 : static_cast<int>(found - contacts.begin());
}

/// Replaces changes along (directions, multipliers) by those along directions, if the multipliers change by
/// `by` along them.
template <class M> void follow(M& x, const Matrix& by) {
  x = (x.leftCols(by.cols()) + x.rightCols(by.rows()) * by).eval();
}
void follow(FrameChanges& x, const Matrix& by) {
  follow(x.n, by);
  follow(x.t1, by);
  follow(x.t2, by);
}

}  // namespace

ContactStepDerivative::ContactStepDerivative(const Model& model, const ContactShapes& shapes,
                                             bool dry_friction, bool damping)
    : model_(model),
      shapes_(shapes),
      tree_(&model_.tree<double>()),
      damping_(damping),
      workspace_(model_, cut_tree),
      momenta_(model_.topology()),
      group_(*tree_),
      displaced_group_(*tree_),
      maps_(*tree_),
      system_(model_, shapes.contact_rows(), 16, dry_friction),
      loops_(model_),
      jets_(shapes),
      motion_(model_),
      place_(index(model_.nv()), 0) {
  const Topology& topology = model_.topology();
  for (int i = 1; i <= topology.n; ++i)
    for (int s = topology.first_screw[index(i)]; s < topology.first_screw[index(i) + 1]; ++s)
      if (!topology.coupled[index(i)]) {
        const int k = s - topology.first_screw[index(i)];
        place_[index(topology.iv[index(i)] + k)] = k;
      }
}

void ContactStepDerivative::take_momenta(const Vector& q, const Vector& v, Momenta& out) {
  const Eigen::Index nv = v.size();
  for (Matrix* x : {&out.M, &out.Mv_q, &out.F_q, &out.F_v}) x->resize(nv, nv);
  mass_matrix(model_, workspace_, Numbers<double>(entries(q)), std::span(out.M.data(), index(nv * nv)));
  momenta_->kinetic(*tree_, q.data(), v.data(), out.Mv_q.data(), out.F_q.data(), out.F_v.data());
  out.factor.compute(out.M);
}

Matrix ContactStepDerivative::Ad_transpose(const Vector& y, Matrix x) const {
  for (Eigen::Index k = 0; k < x.cols(); ++k) group_.Ad_transpose(y.data(), x.col(k).data(), x.col(k).data());
  return x;
}

Matrix ContactStepDerivative::dexp_transpose(const Vector& y, Matrix x) const {
  for (Eigen::Index k = 0; k < x.cols(); ++k)
    group_.dexp_transpose(y.data(), x.col(k).data(), x.col(k).data());
  return x;
}

Matrix ContactStepDerivative::turn_of(const Vector& y, const Vector& p, bool Ad) const {
  // The maps do not mix joints, so that the same direction serves the k-th velocities of all joints.
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

bool ContactStepDerivative::find(const std::vector<Contact>& contacts, double margin, Rows& out) {
  out = {};
  jets_.restart();
  for (const Contact& contact : contacts) {
    const ContactJet* jet = jets_.find(contact.key, motion_.poses(), margin);
    if (!jets_.closed_form()) {
      why_ =
          "the points of contact between " + jets_.names(contact.key) +
          " have no closed form, so that their derivatives are not known; give one of the two another shape";
      return false;
    }
    out.found.push_back(jet != nullptr);
    out.jets.push_back(jet ? *jet : ContactJet{});
    out.changes.push_back(jet ? motion_.contact(*jet) : ContactChanges{});
  }
  return true;
}

void ContactStepDerivative::set_axes(const std::vector<Contact>& contacts, Rows& out) {
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    out.axes.push_back(contact_frame(contacts[k].normal));
    out.daxes.push_back(frame_changes(contacts[k].normal, out.changes[k].normal));
  }
}

ContactStepDerivative::Impulses ContactStepDerivative::set_rows(const Vector& q,
                                                                const std::vector<Contact>& contacts,
                                                                double h, double stop_margin,
                                                                const std::vector<double>& lambda) {
  static_cast<void>(system_.set(q.data(), contacts, h, stop_margin));  // the step has factorised M already
  VelocityProblem& problem = system_.problem();
  problem.finish();
  RowMajor J(problem.rows(), model_.nv());
  system_.write(J.data());
  for (Eigen::Index row = 0; row < J.rows(); ++row)
    if (!problem.moves(index(row))) J.row(row).setZero();
  return {J, Eigen::Map<const Vector>(problem.c.data(), problem.rows()),
          Eigen::Map<const Vector>(lambda.data(), static_cast<Eigen::Index>(lambda.size()))};
}

Matrix ContactStepDerivative::impulse_changes(const Vector& q, const Rows& rows, const Vector& physical,
                                              const Matrix& dq) {
  Matrix out = Matrix::Zero(dq.rows(), dq.cols());
  const int width = system_.contact_rows();
  for (std::size_t k = 0; k < rows.jets.size(); ++k)
    motion_.add_impulse_changes(rows.jets[k], rows.changes[k], rows.axes[k], rows.daxes[k], width,
                                physical.data() + static_cast<Eigen::Index>(k) * width, out);
  if (model_.loops().empty()) return out;
  LoopSystem<double>& loops = loops_.system(model_);
  const Eigen::Index nv = dq.rows(), m = model_.loops().rows;
  RowMajor by_q = RowMajor::Zero(m, nv), by_v = by_q, forces_by_q = RowMajor::Zero(nv, nv);
  const Vector none = Vector::Zero(nv);
  Vector force(nv);
  loops.force(q.data(), none.data(), none.data(), {}, force.data());
  loops.make_rows(ConstraintLevel::velocity);
  loops.differentiate(physical.data() + system_.first_loop_row(), by_q.data(), by_v.data(),
                      forces_by_q.data());
  return out + forces_by_q * dq;
}

Matrix ContactStepDerivative::velocity_changes(const Vector& q, const Vector& x, const Rows& rows,
                                               const Matrix& dq, Vector& u) {
  const int width = system_.contact_rows();
  const Eigen::Index m = system_.problem().rows(), nv = dq.rows();
  Matrix out = Matrix::Zero(m, dq.cols());
  u.resize(m);
  system_.times(x.data(), u.data());
  for (std::size_t k = 0; k < rows.jets.size(); ++k) {
    const Eigen::Index row = static_cast<Eigen::Index>(k) * width;
    out.middleRows(row, width) = motion_.row_velocities(rows.jets[k], rows.changes[k], rows.axes[k],
                                                        rows.daxes[k], width, u.data() + row);
  }
  if (model_.loops().empty()) return out;
  LoopSystem<double>& loops = loops_.system(model_);
  const Eigen::Index loop_rows = model_.loops().rows;
  RowMajor by_q = RowMajor::Zero(loop_rows, nv), by_v = by_q, forces_by_q = RowMajor::Zero(nv, nv);
  const Vector none = Vector::Zero(nv), no_multipliers = Vector::Zero(loop_rows);
  Vector force(nv);
  loops.force(q.data(), none.data(), x.data(), {}, force.data());
  loops.make_rows(ConstraintLevel::velocity);
  loops.differentiate(no_multipliers.data(), by_q.data(), by_v.data(), forces_by_q.data());
  out.bottomRows(loop_rows) = by_q * dq;
  return out;
}

/// The linear momentum of a base gives the velocity u of its frame, and its change.
void ContactStepDerivative::begin_bases(const ContactPart& part, const Vector& v_a, const Matrix& M,
                                        const Matrix& dq, const Matrix& dp) {
  bases_.clear();
  const Vector p = M * v_a;
  for (const ContactPart::Base& base : part.bases) {
    const Eigen::Index first = tree_->operator->()->iv[index(base.body)];
    const Eigen::Matrix3d R = to_eigen(motion_.poses()[index(base.body)].R);
    const Eigen::Vector3d linear = p.segment<3>(first + 3);
    const double mass = M(first + 3, first + 3);
    const Eigen::Vector3d u = R * linear / mass;
    bases_.push_back(
        {base.body, first, base.constant, mass, from_eigen<Vec3<>>(u),
         R * (dp.middleRows<3>(first + 3) - skew(from_eigen<Vec3<>>(linear)) * dq.middleRows<3>(first)) /
             mass});
  }
}

/// Velocities of the frames of the bases at the poses of the motion, as velocities of their joints.
Vector ContactStepDerivative::frame_velocity(double t) const {
  Vector e = Vector::Zero(model_.nv());
  for (const Base& base : bases_) {
    const SO3<> R = motion_.poses()[index(base.body)].R;
    e.segment<3>(base.first + 3) = to_eigen(transpose(R) * (base.u + t * tree_->g));
  }
  return e;
}

/// Adds to dq the changes of the places of the frames after a time t, and to dv those of their velocities.
void ContactStepDerivative::add_frame_changes(double time, double of_place, double of_velocity,
                                              const Matrix& dq_moving, Matrix* dq, Matrix* dv) const {
  const Vector e = frame_velocity(time);
  for (const Base& base : bases_) {
    const Eigen::Matrix3d Rt = to_eigen(motion_.poses()[index(base.body)].R).transpose();
    if (dv)
      dv->middleRows<3>(base.first + 3) +=
          of_velocity * (Rt * base.du + skew(from_eigen<Vec3<>>(e.segment<3>(base.first + 3))) *
                                            dq_moving.middleRows<3>(base.first));
    if (dq) dq->middleRows<3>(base.first + 3) += of_place * Rt * base.du;
  }
}

Matrix ContactStepDerivative::rolling_changes(const ContactPart& part, const Rows& start,
                                              const Impulses& first, const Matrix& dp, const Matrix& dq,
                                              const Matrix& dv) {
  const Eigen::Index nv = dq.rows();
  Vector weight(nv), velocity = part.v_0;
  system_.bias_forces(part.q_0.data(), Vector::Zero(nv).eval().data(), {}, weight.data());
  Momenta at;
  take_momenta(part.q_0, part.v_0, at);
  const Vector gain = at.factor.solve(first.J.transpose() * first.physical() - part.h / 2 * weight);
  velocity += gain;
  take_momenta(part.q_0, gain, at);
  RowMajor gravity(nv, nv);
  gravity_derivatives(model_, workspace_, Numbers<double>(entries(part.q_0)), entries(gravity));
  const Matrix dvelocity = dv + at.factor.solve(dp - (part.h / 2 * gravity + at.Mv_q) * dq);
  Vector u;
  const Matrix du = velocity_changes(part.q_0, velocity, start, dq, u) + first.J * dvelocity;
  return du.bottomRows(model_.loops().rows);
}

bool ContactStepDerivative::run(const ContactPart& part, Matrix& dq, Matrix& dv, const Matrix& dtau) {
  const double h = part.h;
  const Eigen::Index nv = dq.rows(), k = dq.cols();
  const int width = system_.contact_rows();

  // The impulses at the start (D11.19). Columns after the first k are along their multipliers.
  const Eigen::Index m = static_cast<Eigen::Index>(part.lambda_start.size());
  Matrix dq_0 = Matrix::Zero(nv, k + m), dv_0 = dq_0, dtau_0 = dq_0;
  dq_0.leftCols(k) = dq;
  dv_0.leftCols(k) = dv;
  dtau_0.leftCols(k) = dtau;
  const Matrix none = Matrix::Zero(nv, k + m);
  motion_.run(part.q_0.data(), part.v_0.data(), dq_0, none);
  Rows start;
  if (!find(part.start, part.margin, start)) return false;
  set_axes(part.start, start);
  Momenta at_0, at_m, at_1;
  Impulses first;
  Vector u_start;
  Matrix du_start, du_rolling, dp = none;
  if (m > 0) {
    first = set_rows(part.q_0, part.start, h / 2, std::numeric_limits<double>::infinity(), part.lambda_start);
    dp = impulse_changes(part.q_0, start, first.physical(), dq_0);
    dp.rightCols(m) += first.J.transpose() * first.c.asDiagonal();
    du_start = velocity_changes(part.q_0, part.v_0, start, dq_0, u_start) + first.J * dv_0;
    if (!model_.loops().empty()) du_rolling = rolling_changes(part, start, first, dp, dq_0, dv_0);
  }
  take_momenta(part.q_0, part.v_0, at_0);
  Vector v_a = part.v_0;
  if (m > 0) v_a += at_0.factor.solve(first.J.transpose() * first.physical());
  // Momenta of a translation do not change the linear momenta with q, so that v_0 serves for these.
  begin_bases(part, v_a, at_0.M, dq_0, dp + at_0.Mv_q * dq_0 + at_0.M * dv_0);
  const Vector e_0 = frame_velocity(0);
  Matrix de_0 = Matrix::Zero(nv, k + m);
  add_frame_changes(0, 0, 1, dq_0, nullptr, &de_0);
  if (!bases_.empty()) take_momenta(part.q_0, part.v_0 - e_0, at_0);
  dp += at_0.Mv_q * dq_0 + at_0.M * (dv_0 - de_0);
  const Vector p_0 = at_0.M * (v_a - e_0);

  // The free motion (D11.20).
  Vector v_m = part.v_middle;
  motion_.run(part.q_middle.data(), part.v_middle.data(), none, none);
  v_m -= frame_velocity(h / 2);
  take_momenta(part.q_middle, v_m, at_m);
  const Vector y = h / 2 * v_m, p_m = at_m.M * v_m;
  maps_.at(y.data(), y.data());
  Matrix carry = Matrix::Zero(nv, k + m), by_v = Matrix::Zero(nv, nv);
  maps_.add(&Joints::carry, dq_0, carry);
  maps_.add(&Joints::velocity, h / 2 * Matrix::Identity(nv, nv), by_v);
  // f = F - ad_vᵀ M v + ...
  Matrix f_q = at_m.F_q, f_v = at_m.F_v;
  if (!group_.commutes()) {
    Vector x(nv);
    for (Eigen::Index c = 0; c < nv; ++c) {
      group_.ad_transpose(v_m, at_m.Mv_q.col(c).data(), x);
      f_q.col(c) -= x;
      group_.ad_transpose(v_m, at_m.M.col(c).data(), x);
      f_v.col(c) -= x;
      group_.ad_transpose(Vector::Unit(nv, c).eval(), p_m, x);
      f_v.col(c) -= x;
    }
  }
  RowMajor gravity(nv, nv);
  gravity_derivatives(model_, workspace_, Numbers<double>(entries(part.q_middle)), entries(gravity));
  for (const Base& base : bases_) {
    const Topology& topology = model_.topology();
    for (int i = base.body; i < topology.subtree_end[index(base.body)]; ++i)
      gravity
          .middleRows(topology.iv[index(i)],
                      topology.first_screw[index(i) + 1] - topology.first_screw[index(i)])
          .setZero();
  }
  f_q -= gravity;
  if (damping_)
    for (Eigen::Index c = 0; c < nv; ++c) f_v(c, c) -= tree_->damping[index(c)];
  Matrix df = dtau_0;
  if (!model_.springs().empty()) {
    RowMajor by_place(nv, nv), by_velocity(nv, nv);
    spring_force_derivatives(model_, workspace_, Numbers<double>(entries(part.q_middle)),
                             Numbers<double>(entries(part.v_middle)),
                             {entries(by_place), entries(by_velocity)});
    Matrix along_frames = none, velocities = none, turned = Matrix::Zero(nv, nv);
    add_frame_changes(h / 2, h / 2, 1, none, &along_frames, &velocities);
    df += by_place * along_frames + by_velocity * velocities;
    const Vector e = frame_velocity(h / 2);
    for (const Base& base : bases_)
      turned.block<3, 3>(base.first + 3, base.first) = skew(from_eigen<Vec3<>>(e.segment<3>(base.first + 3)));
    f_q += by_place + by_velocity * turned;
    f_v += by_velocity;
  }
  const Vector q_1 = part.q_1;
  motion_.run(q_1.data(), part.v_before_end.data(), none, none);
  const Vector v_b = part.v_before_end - frame_velocity(h);
  take_momenta(q_1, v_b, at_1);
  const Vector p_plus = Ad_transpose(-y, at_1.M * v_b);
  const Matrix f_by_v = f_q * by_v + f_v, turn_0 = h / 2 * turn_of(y, p_0, true);
  const Matrix p_plus_by_v = turn_0 + h * f_by_v;
  const Matrix N = at_m.M + at_m.Mv_q * by_v - h / 2 * turn_of(y, (p_0 + p_plus) / 2, false) -
                   dexp_transpose(y, p_plus_by_v / 2);
  Matrix dp_plus = Ad_transpose(y, dp) + h * (df + f_q * carry);
  const Matrix left = dexp_transpose(y, (dp + dp_plus) / 2) - at_m.Mv_q * carry;
  const Matrix dv_m = N.partialPivLu().solve(left);
  dp_plus += p_plus_by_v * dv_m;
  Matrix dq_m = carry + by_v * dv_m;
  Matrix dp_1 = Ad_transpose(y, dp_plus) + h / 2 * turn_of(y, p_plus, true) * dv_m;
  maps_.at((2 * y).eval().data(), y.data());
  Matrix dq_1 = none;
  maps_.add(&Joints::carry, dq_0, dq_1);
  maps_.add(&Joints::velocity, h * dv_m, dq_1);
  for (const Base& base : bases_) {
    if (!base.constant) continue;
    const Eigen::Index linear = base.first + 3;
    // The poses of the motion are those at the end. Forces on the base move the centre of mass.
    const Eigen::Matrix3d R_1 = to_eigen(motion_.poses()[index(base.body)].R);
    const SE3<> C_0 = subgroup::Free<double>::pose(
        tree_->B[index(base.body)], part.q_0.data() + tree_->operator->()->iq[index(base.body)]);
    Eigen::Matrix3Xd shift =
        (to_eigen(C_0.R) * at_0.M.middleRows<3>(linear) * dq_0 - R_1 * at_1.M.middleRows<3>(linear) * dq_1) /
        base.mass;
    for (Eigen::Index c = 0; c < k; ++c)
      if (!dtau_0.col(c).segment<6>(base.first).isZero(0)) shift.col(c).setZero();
    dq_1.middleRows<3>(linear) += R_1.transpose() * shift;
  }
  // From the moving frames to the inertial one: at the end, and in the middle.
  const Matrix dq_moving_1 = dq_1;
  add_frame_changes(h, h, 0, dq_moving_1, &dq_1, nullptr);

  // The rows in the middle, with the axes of the start turned to their normals.
  motion_.run(part.q_middle.data(), part.v_middle.data(), none, none);
  Matrix dv_middle = dv_m;
  const Matrix dq_moving_m = dq_m;
  add_frame_changes(h / 2, h / 2, 1, dq_moving_m, &dq_m, &dv_middle);
  motion_.run(part.q_middle.data(), part.v_middle.data(), dq_m, dv_middle);
  Rows middle;
  if (!find(part.start, part.margin, middle)) return false;
  Vector slip(m);
  Matrix dslip(m, k + m);
  for (std::size_t c = 0; c < part.start.size(); ++c) {
    if (!middle.found[c]) {  // the step takes the place at the start
      middle.jets[c] = start.jets[c];
      middle.changes[c] = start.changes[c];
    }
    const Vec3<>&from = part.start[c].normal, &to = middle.jets[c].normal;
    middle.axes.push_back(turned(start.axes[c], to));
    middle.daxes.push_back(turned_changes(from, start.changes[c].normal, to, middle.changes[c].normal));
    const Eigen::Index row = static_cast<Eigen::Index>(c) * width;
    dslip.middleRows(row, width) = motion_.row_velocities(middle.jets[c], middle.changes[c], middle.axes[c],
                                                          middle.daxes[c], width, slip.data() + row);
  }

  // The law of the impulses at the start (D11.21).
  if (m > 0) {
    motion_.run(q_1.data(), part.v_before_end.data(), dq_1, none);
    Rows end;
    if (!find(part.start, part.margin, end)) return false;
    Vector u(m);
    Matrix du(m, k + m);
    for (std::size_t c = 0; c < part.start.size(); ++c) {
      const Eigen::Index row = static_cast<Eigen::Index>(c) * width;
      const bool found = end.found[c] != 0;
      const double overlap = part.overlaps[c] ? part.start[c].gap : 0;
      u[row] = ((found ? end.jets[c].gap : part.start[c].gap + h * slip[row]) - overlap) / h;
      du.row(row) = found ? end.changes[c].gap : start.changes[c].gap + h * dslip.row(row);
      if (part.overlaps[c]) du.row(row) -= start.changes[c].gap;
      du.row(row) /= h;
      for (int i = 1; i < width; ++i) {
        u[row + i] = slip[row + i];
        du.row(row + i) = dslip.row(row + i);
        if (!part.slides[c]) continue;
        u[row + i] += u_start[row + i];
        du.row(row + i) += du_start.row(row + i);
      }
    }
    const auto blocks = system_.problem().blocks();
    const std::size_t n = part.start.size();
    for (std::size_t s = 0; s < system_.active_stops().size(); ++s) {
      const JointStop& stop = system_.stops()[index(system_.active_stops()[s])];
      const Eigen::Index row = blocks[n + s].first;
      const double room = system_.room()[n + s];
      constexpr double rounding = 1e-10;
      const bool overlaps = room < -rounding;
      u[row] = (stop.side * (q_1[stop.coordinate] - stop.limit) - (overlaps ? room : 0)) / h;
      du.row(row) = stop.side * (dq_1.row(stop.velocity) - (overlaps ? 1 : 0) * dq_0.row(stop.velocity)) / h;
    }
    const Eigen::Index loop = system_.first_loop_row();
    const Eigen::Index dry = static_cast<Eigen::Index>(system_.dry_joints().size());
    for (Eigen::Index d = 0; d < dry; ++d) {
      const int c = system_.dry_joints()[index(d)].velocity;
      u[loop - dry + d] = part.v_middle[c];
      du.row(loop - dry + d) = dv_middle.row(c);
    }
    if (loop < m) {
      u.tail(m - loop).setZero();
      LoopSystem<double>& loops = loops_.system(model_);
      loops.update_kinematics(q_1.data());
      loops.make_rows(ConstraintLevel::position);
      RowMajor R(model_.loops().residuals, nv);
      loops.write(R.data());
      for (const LoopPath& path : loops.table().paths)
        for (int r = 0; r < path.rows.count; ++r)
          if (r < path.residuals.count)
            du.row(loop + path.rows.first + r) = R.row(path.residuals.first + r) * dq_1 / h;
          else
            du.row(loop + path.rows.first + r) = du_rolling.row(path.rows.first + r);
    }
    for (Eigen::Index row = 0; row < m; ++row)
      if (!system_.problem().moves(index(row))) du.row(row).setZero();
    const Vector scaled = first.c.cwiseProduct(u);
    du = first.c.asDiagonal() * du;
    const Matrix dv_a = at_0.factor.solve(dp.leftCols(k));
    const LawDerivative law =
        differentiate_law(system_.problem(), part.lambda_start.data(), scaled.data(), du.rightCols(m),
                          du.leftCols(k), mass_norm(at_0.M, v_a), mass_norm(at_0.M, dv_a));
    note(law);
    for (Matrix* x : {&dq_1, &dp_1, &dslip, &du_start}) follow(*x, law.multipliers);
    for (FrameChanges& x : middle.daxes) follow(x, law.multipliers);
    for (Base& base : bases_) follow(base.du, law.multipliers);
  }
  dq = dq_1;
  if (!impulses_at_end(part, middle, slip, dslip, u_start, du_start, dp_1, dq, dv)) return false;
  return part.apart.empty() || move_apart(part, dq);
}

/// The impulses at the end (D11.22).
bool ContactStepDerivative::impulses_at_end(const ContactPart& part, const Rows& middle, const Vector& slip,
                                            const Matrix& dslip, const Vector& u_start,
                                            const Matrix& du_start, const Matrix& dp, Matrix& dq,
                                            Matrix& dv) {
  const Vector& q_1 = part.q_1;
  const Eigen::Index m = static_cast<Eigen::Index>(part.lambda_end.size()), nv = dq.rows(), k = dq.cols();
  const int width = system_.contact_rows();
  const Matrix none = Matrix::Zero(nv, k);
  Vector v_1 = part.v_before_end;
  Momenta at;
  Impulses last;
  Rows rows;
  constexpr double near_stop = 1e-9;  // as in the step
  if (m > 0) {
    last = set_rows(q_1, part.end, part.h / 2, near_stop, part.lambda_end);
    take_momenta(q_1, v_1, at);
    v_1 += at.factor.solve(last.J.transpose() * last.physical());
  }
  motion_.run(q_1.data(), v_1.data(), dq, none);
  if (!find(part.end, part.margin, rows)) return false;
  set_axes(part.end, rows);
  take_momenta(q_1, v_1 - frame_velocity(part.h), at);
  Matrix momenta = dp - at.Mv_q * dq;
  if (m > 0) momenta += impulse_changes(q_1, rows, last.physical(), dq);
  dv = at.factor.solve(momenta);
  add_frame_changes(part.h, 0, 1, dq, nullptr, &dv);
  if (m == 0) return true;

  Vector u;
  Matrix du = velocity_changes(q_1, v_1, rows, dq, u) + last.J * dv;
  for (std::size_t c = 0; c < part.end.size(); ++c) {
    const Contact& contact = part.end[c];
    const int before = place_of(part.start, contact.key);
    if (before < 0) continue;
    const std::size_t b = index(before);
    const Eigen::Index row = static_cast<Eigen::Index>(c) * width, row_0 = before * width;
    if (part.bounces[b]) {
      const double e = part.bounciness * contact.surface.restitution;
      u[row] += e * u_start[row_0];
      du.row(row) += e * du_start.row(row_0);
    }
    if (!part.slides[b]) continue;
    const ContactFrame &from = middle.axes[b], &to = rows.axes[c];
    const FrameChanges &dfrom = middle.daxes[b], &dto = rows.daxes[c];
    const auto turn = [&](int first) {
      const double x = slip[row_0 + first], y = slip[row_0 + first + 1];
      const Vec3<> vector = x * from.t1 + y * from.t2;
      const VectorChanges change = x * dfrom.t1 + y * dfrom.t2 +
                                   to_eigen(from.t1) * dslip.row(row_0 + first) +
                                   to_eigen(from.t2) * dslip.row(row_0 + first + 1);
      u[row + first] += dot(vector, to.t1);
      u[row + first + 1] += dot(vector, to.t2);
      du.row(row + first) += to_eigen(to.t1).transpose() * change + to_eigen(vector).transpose() * dto.t1;
      du.row(row + first + 1) += to_eigen(to.t2).transpose() * change + to_eigen(vector).transpose() * dto.t2;
    };
    turn(1);
    if (width > 3) {
      u[row + 3] += slip[row_0 + 3];
      du.row(row + 3) += dslip.row(row_0 + 3);
    }
    if (width > 4) turn(4);
  }
  for (std::size_t s = 0; s < system_.active_stops().size(); ++s) {
    const std::size_t stop = index(system_.active_stops()[s]);
    if (!part.bounces[part.start.size() + stop]) continue;
    const Eigen::Index row = system_.problem().blocks()[part.end.size() + s].first;
    const Eigen::Index row_0 =
        static_cast<Eigen::Index>(part.start.size()) * width + static_cast<Eigen::Index>(stop);
    const double e = part.bounciness * system_.stops()[stop].restitution;
    u[row] += e * u_start[row_0];
    du.row(row) += e * du_start.row(row_0);
  }
  Matrix G(m, m);
  system_.problem().delassus(G);
  const Vector scaled = last.c.cwiseProduct(u);
  const LawDerivative law =
      differentiate_law(system_.problem(), part.lambda_end.data(), scaled.data(), G, last.c.asDiagonal() * du,
                        mass_norm(at.M, v_1), mass_norm(at.M, dv));
  note(law);
  dv += at.factor.solve(last.J.transpose() * (last.c.asDiagonal() * law.multipliers));
  return true;
}

/// The motion that parts overlaps (D11.23).
bool ContactStepDerivative::move_apart(const ContactPart& part, Matrix& dq) {
  const Eigen::Index m = static_cast<Eigen::Index>(part.lambda_apart.size()), nv = dq.rows(), k = dq.cols();
  const int width = system_.contact_rows();
  const Impulses apart =
      set_rows(part.q_1, part.apart, 0, std::numeric_limits<double>::infinity(), part.lambda_apart);
  Momenta at;
  take_momenta(part.q_1, part.v_before_end, at);
  const Vector y = at.factor.solve(apart.J.transpose() * apart.physical());
  take_momenta(part.q_1, y, at);
  motion_.run(part.q_1.data(), y.data(), dq, Matrix::Zero(nv, k));
  Rows rows;
  if (!find(part.apart, part.margin, rows)) return false;
  set_axes(part.apart, rows);
  Matrix dy = at.factor.solve(impulse_changes(part.q_1, rows, apart.physical(), dq) - at.Mv_q * dq);
  Vector u;
  Matrix du = velocity_changes(part.q_1, y, rows, dq, u) + apart.J * dy;
  const std::span<const double> room = system_.room();
  for (std::size_t c = 0; c < part.apart.size(); ++c) {
    const Eigen::Index row = static_cast<Eigen::Index>(c) * width;
    u[row] += std::max(room[c], -part.most_apart);
    if (room[c] > -part.most_apart) du.row(row) += rows.changes[c].gap;
  }
  for (std::size_t s = 0; s < system_.active_stops().size(); ++s) {
    const std::size_t n = part.apart.size() + s;
    const Eigen::Index row = system_.problem().blocks()[n].first;
    const JointStop& stop = system_.stops()[index(system_.active_stops()[s])];
    u[row] += std::max(room[n], -part.most_apart);
    if (room[n] > -part.most_apart) du.row(row) += stop.side * dq.row(stop.velocity);
  }
  const Eigen::Index loop = system_.first_loop_row();
  if (loop < m) {
    LoopSystem<double>& loops = loops_.system(model_);
    loops.update_kinematics(part.q_1.data());
    loops.make_rows(ConstraintLevel::position);
    RowMajor R(model_.loops().residuals, nv);
    loops.write(R.data());
    for (const LoopPath& path : loops.table().paths)
      for (int r = 0; r < path.residuals.count; ++r)
        if (const Eigen::Index row = loop + path.rows.first + r; system_.problem().moves(index(row)))
          du.row(row) += R.row(path.residuals.first + r) * dq;
  }
  Matrix G(m, m);
  system_.problem().delassus(G);
  const Vector scaled = apart.c.cwiseProduct(u);
  const double size = mass_norm(at.M, y);
  const LawDerivative law = differentiate_law(system_.problem(), part.lambda_apart.data(), scaled.data(), G,
                                              apart.c.asDiagonal() * du, size, mass_norm(at.M, dq));
  note(law);
  dy += at.factor.solve(apart.J.transpose() * (apart.c.asDiagonal() * law.multipliers));
  maps_.at(y.data(), y.data());
  Matrix moved = Matrix::Zero(nv, k);
  maps_.add(&Joints::carry, dq, moved);
  maps_.add(&Joints::velocity, dy, moved);
  dq = moved;
  return true;
}

}  // namespace axode
