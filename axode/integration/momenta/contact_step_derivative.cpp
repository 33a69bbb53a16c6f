#include "axode/integration/momenta/contact_step_derivative.hpp"

#include <limits>

#include "axode/integration/momenta/contact_step.hpp"
#include "axode/scalar/index.hpp"

namespace axode {
namespace {

using Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Applies the chain rule to the derivatives x of some quantities, whose first k columns are along k
/// directions at constant multipliers, and whose other columns are by the multipliers: x becomes the k total
/// derivatives, with the derivatives `by` of the multipliers along the directions.
template <class X> void follow(X& x, const Changes& by) {
  X followed = x.leftCols(by.cols());
  add_product(x.rightCols(by.rows()), by, followed);
  x = std::move(followed);
}
void follow(FrameChanges& x, const Changes& by) {
  follow(x.n, by);
  follow(x.t1, by);
  follow(x.t2, by);
}

}  // namespace

double ContactStepDerivative::mass_norm(const Matrix& M, const ChangesArgument& x) {
  return std::sqrt(std::max(0.0, x.cwiseProduct(product(M, x)).sum()));
}

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
      parameter_changes_(model_),
      place_(index(model_.nv()), 0) {
  const Topology& topology = model_.topology();
  for (int i = 1; i <= topology.n; ++i)
    for (int s = topology.first_screw[index(i)]; s < topology.first_screw[index(i) + 1]; ++s)
      if (!topology.coupled[index(i)]) {
        const int k = s - topology.first_screw[index(i)];
        place_[index(topology.iv[index(i)] + k)] = k;
      }
}

/// Differentiates the velocities and momenta after the impulses at the start of a substep (D11.19). A substep
/// is a step of a simulation or a part of one. Matrices of changes have k columns for the directions along
/// which the step is differentiated, at constant multipliers, and then a column for each multiplier with the
/// derivative by it. A multiplier is the impulse of a constraint row at the start of the substep, divided by
/// the coefficient of friction if it is a friction row of a contact.
bool ContactStepDerivative::begin(const ContactPart& part, const Changes& dq, const Changes& dv,
                                  const ContactDirections& directions, Start& out) {
  const Eigen::Index nv = dq.rows(), k = dq.cols();

  const Eigen::Index m = static_cast<Eigen::Index>(part.lambda_start.size());
  k_ = k;
  for (Changes* x : {&out.dq, &out.dv, &out.dtau, &out.dp}) x->setZero(nv, k + m);
  out.dq.leftCols(k) = dq;
  out.dv.leftCols(k) = dv;
  out.dtau.leftCols(k) = directions.tau;
  thickness_ = directions.thickness;
  restitution_ = directions.restitution;
  along_ = directions.parameters;
  p_ = along_.count();
  first_ = k - p_;
  motion_.set_geometry(along_.geometry);
  const bool shapes_change =
      thickness_.size() > 0 || along_.geometry.size() > 0 || along_.placement.size() > 0;
  each_.setIdentity(nv, nv + (shapes_change ? k : 0));
  none_.setZero(nv, each_.cols());
  if (directions.friction.size() > 0) {
    out.friction.setZero(directions.friction.rows(), k + m);
    out.friction.leftCols(k) = directions.friction;
  }
  out.mass = mass(part.q_0);
  displace_each(part.q_0, part.v_0);
  if (!find(part.start, part.margin, out.rows)) return false;
  set_axes(part.start, out.rows);
  Impulses& first = out.first;
  Changes& dp = out.dp;
  if (m > 0) {
    first = set_rows(part.q_0, part.start, part.h / 2, std::numeric_limits<double>::infinity(),
                     part.lambda_start);
    dp = impulse_changes(part.q_0, out.rows, first.physical(), out.dq);
    dp.rightCols(m) += first.J.transpose() * first.c.asDiagonal();
    if (out.friction.size() > 0)
      add_product(first.J.transpose(),
                  first.lambda.asDiagonal() * coefficient_changes(part.start, m, out.friction), dp);
    out.du = velocity_changes(part.q_0, part.v_0, out.rows, out.dq, out.u);
    add_product(first.J, out.dv, out.du);
    if (!model_.loops().empty()) out.du_rolling = rolling_changes(part, out, dp);
  }
  const Matrix& M = out.mass.M;
  VectorXd& v_a = out.v_a;
  v_a = part.v_0;
  if (m > 0) v_a += out.mass.factor.solve(first.J.transpose() * first.physical());
  begin_bases(part, out);
  const VectorXd e_0 = frame_velocity(part.q_0, 0), v = part.v_0 - e_0;
  const Matrix Mv_q = momenta_by_q(part.q_0, v);
  if (p_ > 0) parameter_changes_.run(part.q_0.data(), v.data(), along_);
  differentiate_bases(part, out, Mv_q);
  Changes dv_moving = out.dv, de_0 = Changes::Zero(nv, k + m);
  add_frame_changes(part.q_0, 0, 0, 1, out.dq, nullptr, &de_0);
  dv_moving -= de_0;
  if (p_ > 0) by_parameters(dp) += parameter_changes_.momenta;
  add_product(Mv_q, out.dq, dp);
  add_product(M, dv_moving, dp);
  out.p = M * (v_a - e_0);
  return true;
}

/// Computes the relative velocities at the contacts in the middle of a substep (a step of a simulation or a
/// part of one) and their changes. The changes have k columns for the directions along which the step is
/// differentiated, at constant multipliers, and then a column for each multiplier with the derivative by it.
/// A multiplier is the impulse of a constraint row at the start of the substep, divided by the coefficient of
/// friction if it is a friction row of a contact. The velocities of a contact are along its axes at the
/// start, turned so that the first one is the normal in the middle.
bool ContactStepDerivative::take_slip(const ContactPart& part, const Start& start, const Flight& flight,
                                      Slip& out) {
  const int width = system_.contact_rows();
  const Eigen::Index m = start.first.lambda.size();
  displace(part.q_middle, part.v_middle, flight.dq_m, flight.dv_m);
  Rows& middle = out.rows;
  if (!find(part.start, part.margin, middle)) return false;
  out.u.setZero(m);
  out.du.setZero(m, start.dq.cols());
  for (std::size_t c = 0; c < part.start.size(); ++c) {
    const ContactChanges at_start{chain(start.rows.changes[c].rows, start.dq)};
    if (!middle.found[c]) {  // the step takes the place at the start
      middle.jets[c] = start.rows.jets[c];
      middle.changes[c] = at_start;
    }
    const Vec3<>&from = part.start[c].normal, &to = middle.jets[c].normal;
    middle.axes.push_back(turned(start.rows.axes[c], to));
    middle.daxes.push_back(turned_changes(from, at_start.normal(), to, middle.changes[c].normal()));
    const Eigen::Index row = static_cast<Eigen::Index>(c) * width;
    out.du.middleRows(row, width) = motion_.row_velocities(middle.jets[c], middle.changes[c], middle.axes[c],
                                                           middle.daxes[c], width, out.u.data() + row);
  }
  return true;
}

/// Computes the velocities u of the constraint rows (of contacts, stops, dry friction and loops) that obey
/// the laws of contact together with the impulses at the start of a substep (D11.13). A substep is a step of
/// a simulation or a part of one, and h is its length. The velocities are
/// - for a stop or a normal of a contact, the gap at the end of the substep, divided by h; if the gap was
///   negative at its start, beyond rounding, the change of the gap in the substep, divided by h;
/// - for a normal of a compliant contact with an impulse λ > 0 at the start of the substep, C (λ - h N/2)
///   with the mean N of its normal force in the substep and a constant C > 0 (D11.28). This is 0, because
///   half of the impulse h N acts at the start;
/// - for a loop, the residual at the end of the substep, divided by h, or, if the loop constrains velocities
///   alone, as a rolling contact does, the velocity in its equation. Both are 0;
/// - for friction, the velocity in the middle of the substep; if a contact slides, its velocity at the start
///   is added, because friction opposes the mean of both.
///
/// Also computes the changes du of u (D11.21): k columns for the directions along which the step is
/// differentiated, at constant multipliers, and then a column for each multiplier with the derivative by it.
/// A multiplier is the impulse of a row at the start, divided by the coefficient of friction if it is a
/// friction row of a contact. displace_each() must have been called at the end of the substep.
bool ContactStepDerivative::take_start_velocities(const ContactPart& part, const Start& start,
                                                  const Flight& flight, const Slip& middle, VectorXd& u,
                                                  Changes& du) {
  const double h = part.h;
  const VectorXd& q_1 = part.q_1;
  const Eigen::Index nv = start.dq.rows(), m = start.first.lambda.size();
  const int width = system_.contact_rows();
  u.setZero(m);
  du.setZero(m, start.dq.cols());
  Rows end;
  if (!find(part.start, part.margin, end)) return false;

  for (std::size_t c = 0; c < part.start.size(); ++c) {
    const Eigen::Index row = static_cast<Eigen::Index>(c) * width;
    const bool found = end.found[c] != 0;
    const Eigen::RowVectorXd gap_before = chain(start.rows.changes[c].gap(), start.dq);
    const double gap = found ? end.jets[c].gap : part.start[c].gap + h * middle.u[row];
    if (found)
      du.row(row) = chain(end.changes[c].gap(), flight.dq_1);
    else
      du.row(row) = gap_before + h * middle.du.row(row);
    if (part.start[c].surface.compliance && part.lambda_start[index(row)] > 0) {
      const MeanForce mean = mean_force(part.start[c].surface.compliance, part.start[c].gap, gap, h);
      const double C = system_.problem().squared_scales()[index(row)];
      u[row] = 0;
      du.row(row) = C * h / 2 * (mean.slope * du.row(row) + mean.slope_before * gap_before);
      du(row, k_ + row) += C;
    } else {
      u[row] = (gap - (part.overlaps[c] ? part.start[c].gap : 0)) / h;
      if (part.overlaps[c]) du.row(row) -= gap_before;
      du.row(row) /= h;
    }
    for (int i = 1; i < width; ++i) {
      u[row + i] = middle.u[row + i];
      du.row(row + i) = middle.du.row(row + i);
      if (!part.slides[c]) continue;
      u[row + i] += start.u[row + i];
      du.row(row + i) += start.du.row(row + i);
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
    du.row(row) =
        stop.side * (flight.dq_1.row(stop.velocity) - (overlaps ? 1 : 0) * start.dq.row(stop.velocity)) / h;
  }
  const Eigen::Index loop = system_.first_loop_row();
  const Eigen::Index dry = static_cast<Eigen::Index>(system_.dry_joints().size());
  for (Eigen::Index d = 0; d < dry; ++d) {
    const int c = system_.dry_joints()[index(d)].velocity;
    u[loop - dry + d] = part.v_middle[c];
    du.row(loop - dry + d) = flight.dv_m.row(c);
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
          du.row(loop + path.rows.first + r) = product(R.row(path.residuals.first + r), flight.dq_1) / h;
        else
          du.row(loop + path.rows.first + r) = start.du_rolling.row(path.rows.first + r);
  }
  for (Eigen::Index row = 0; row < m; ++row)
    if (!system_.problem().moves(index(row))) du.row(row).setZero();
  return true;
}

bool ContactStepDerivative::run(const ContactPart& part, Changes& dq, Changes& dv,
                                const ContactDirections& directions) {
  Start start;
  Slip middle;
  if (!begin(part, dq, dv, directions, start)) return false;
  Flight flight = fly(part, start);
  if (!take_slip(part, start, flight, middle)) return false;
  displace_each(part.q_1, part.v_1);
  const Eigen::Index k = dq.cols(), m = start.first.lambda.size();
  Changes dlambda = Changes::Zero(m, k);
  if (m > 0) {
    VectorXd u;
    Changes du;
    if (!take_start_velocities(part, start, flight, middle, u, du)) return false;
    const VectorXd scaled = start.first.c.cwiseProduct(u);
    du.array().colwise() *= start.first.c.array();
    if (start.friction.size() > 0) du += u.asDiagonal() * coefficient_changes(part.start, m, start.friction);
    const auto change = [&] {
      return mass_norm(start.mass.M, start.mass.factor.solve_changes(start.dp.leftCols(k)));
    };
    const LawDerivative law =
        differentiate_law(system_.problem(), part.lambda_start.data(), scaled.data(), du.rightCols(m),
                          du.leftCols(k), mass_norm(start.mass.M, start.v_a), change);
    note(law);
    dlambda = law.multipliers;
    for (Changes* x : {&flight.dq_1, &flight.dp_1, &middle.du, &start.du}) follow(*x, law.multipliers);
    for (std::size_t c = 0; c < part.start.size(); ++c)
      if (part.slides[c]) follow(middle.rows.daxes[c], law.multipliers);
    for (Base& base : bases_) follow(base.du, law.multipliers);
  }
  dq = flight.dq_1;
  if (!impulses_at_end(part, start, middle, dlambda, flight.at_1, flight.dp_1, directions.friction, dq, dv))
    return false;
  return part.apart.empty() || move_apart(part, flight.at_1, dq);
}

}  // namespace axode
