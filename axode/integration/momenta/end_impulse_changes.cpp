#include <algorithm>
#include <limits>

#include "axode/integration/momenta/contact_step_derivative.hpp"
#include "axode/scalar/index.hpp"

/// The part of ContactStepDerivative for the impulses at the end of a step and the removal of overlaps.
namespace axode {
namespace {

using Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Joints = GroupDerivatives::Joints;

/// The index of the contact with a key in a list, or -1.
int place_of(const std::vector<Contact>& contacts, std::uint64_t key) {
  const auto found = std::ranges::find(contacts, key, &Contact::key);
  return found == contacts.end() ? -1 : static_cast<int>(found - contacts.begin());
}

}  // namespace

/// Differentiates the impulses of contacts, stops, dry friction and loops at the end of a substep (D11.22). A
/// substep is a whole step or a part of one. Computes the changes dv of the velocities after these impulses
/// from the changes dq and dp of the coordinates and momenta before them, with a column for each direction of
/// differentiation. displace_each() must have been called at the end of the substep.
bool ContactStepDerivative::impulses_at_end(const ContactPart& part, const Start& start, const Slip& middle,
                                            const Changes& dlambda, const Mass& at_1, const Changes& dp,
                                            const Changes& friction, Changes& dq, Changes& dv) {
  const VectorXd& q_1 = part.q_1;
  const Eigen::Index m = static_cast<Eigen::Index>(part.lambda_end.size());
  const int width = system_.contact_rows();
  const VectorXd& v_1 = part.v_1;
  Impulses last;
  Rows rows;
  if (m > 0) last = set_rows(q_1, part.end, part.h / 2, ContactPart::near_stop, part.lambda_end);
  if (!find(part.end, part.margin, rows)) return false;
  set_axes(part.end, rows);
  const VectorXd v_moving = v_1 - frame_velocity(q_1, part.h);
  Changes momenta = dp;
  subtract_product(momenta_by_q(q_1, v_moving), dq, momenta);
  if (p_ > 0) {
    parameter_changes_.run(q_1.data(), v_moving.data(), along_);
    by_parameters(momenta) -= parameter_changes_.momenta;
  }
  if (m > 0) momenta += impulse_changes(q_1, rows, last.physical(), dq);
  if (m > 0 && friction.size() > 0)
    add_product(last.J.transpose(), last.lambda.asDiagonal() * coefficient_changes(part.end, m, friction),
                momenta);
  dv = at_1.factor.solve_changes(momenta);
  add_frame_changes(q_1, part.h, 0, 1, dq, nullptr, &dv);
  if (m == 0) return true;

  VectorXd u;
  Changes du = velocity_changes(q_1, v_1, rows, dq, u);
  add_product(last.J, dv, du);
  for (std::size_t c = 0; c < part.end.size(); ++c) {
    const Contact& contact = part.end[c];
    const int before = place_of(part.start, contact.key);
    if (before < 0) continue;
    const std::size_t b = index(before);
    const Eigen::Index row = static_cast<Eigen::Index>(c) * width, row_0 = before * width;
    if (part.bounces[b]) {
      const double e = part.bounciness * contact.surface.restitution;
      u[row] += e * start.u[row_0];
      du.row(row) += e * start.du.row(row_0);
      if (restitution_.size() > 0)
        du.row(row) += part.bounciness * start.u[row_0] * restitution_changes(contact);
    }
    if (!part.slides[b]) continue;
    const ContactFrame &from = middle.rows.axes[b], &to = rows.axes[c];
    const FrameChanges& dfrom = middle.rows.daxes[b];
    const Changes dt1 = chain(rows.daxes[c].t1, dq), dt2 = chain(rows.daxes[c].t2, dq);
    const auto turn = [&](int first) {
      const double x = middle.u[row_0 + first], y = middle.u[row_0 + first + 1];
      const Vec3<> vector = x * from.t1 + y * from.t2;
      const VectorChanges change = x * dfrom.t1 + y * dfrom.t2 +
                                   to_eigen(from.t1) * middle.du.row(row_0 + first) +
                                   to_eigen(from.t2) * middle.du.row(row_0 + first + 1);
      u[row + first] += dot(vector, to.t1);
      u[row + first + 1] += dot(vector, to.t2);
      const auto add = [&](Eigen::Index k, const Vec3<>& axis, const Changes& daxis) {
        add_product(to_eigen(axis).transpose(), change, du.middleRows(row + first + k, 1));
        add_product(to_eigen(vector).transpose(), daxis, du.middleRows(row + first + k, 1));
      };
      add(0, to.t1, dt1);
      add(1, to.t2, dt2);
    };
    turn(1);
    if (width > 3) {
      u[row + 3] += middle.u[row_0 + 3];
      du.row(row + 3) += middle.du.row(row_0 + 3);
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
    u[row] += e * start.u[row_0];
    du.row(row) += e * start.du.row(row_0);
  }
  Matrix G(m, m);
  system_.problem().delassus(G);
  for (std::size_t c = 0; c < part.end.size(); ++c) {
    if (!part.end[c].surface.compliance) continue;
    // The normal impulse is that of the start: C (λ_1N - λ_0N) is the velocity of its row.
    const Eigen::Index row = static_cast<Eigen::Index>(c) * width,
                       row_0 = static_cast<Eigen::Index>(place_of(part.start, part.end[c].key)) * width;
    const double C = system_.problem().squared_scales()[index(row)];
    G.row(row).setZero();
    G(row, row) = C;
    u[row] = 0;
    du.row(row) = -C * dlambda.row(row_0);
  }
  const VectorXd scaled = last.c.cwiseProduct(u);
  const LawDerivative law =
      differentiate_law(system_.problem(), part.lambda_end.data(), scaled.data(), G, last.c.asDiagonal() * du,
                        mass_norm(at_1.M, v_1), [&] { return mass_norm(at_1.M, dv); });
  note(law);
  dv += at_1.factor.solve_changes(product(last.J.transpose(), last.c.asDiagonal() * law.multipliers));
  return true;
}

/// Differentiates the displacement that removes overlaps (D11.23): replaces dq before it by dq after it.
bool ContactStepDerivative::move_apart(const ContactPart& part, const Mass& at_1, Changes& dq) {
  const Eigen::Index m = static_cast<Eigen::Index>(part.lambda_apart.size()), nv = dq.rows(), k = dq.cols();
  const int width = system_.contact_rows();
  const Impulses apart =
      set_rows(part.q_1, part.apart, 0, std::numeric_limits<double>::infinity(), part.lambda_apart);
  const VectorXd y = at_1.factor.solve(apart.J.transpose() * apart.physical());
  displace_each(part.q_1, y);
  Rows rows;
  if (!find(part.apart, part.margin, rows)) return false;
  set_axes(part.apart, rows);
  Changes momenta = impulse_changes(part.q_1, rows, apart.physical(), dq);
  subtract_product(momenta_by_q(part.q_1, y), dq, momenta);
  if (p_ > 0) {
    parameter_changes_.run(part.q_1.data(), y.data(), along_);
    by_parameters(momenta) -= parameter_changes_.momenta;
  }
  Changes dy = at_1.factor.solve_changes(momenta);
  VectorXd u;
  Changes du = velocity_changes(part.q_1, y, rows, dq, u);
  add_product(apart.J, dy, du);
  const std::span<const double> room = system_.room();
  for (std::size_t c = 0; c < part.apart.size(); ++c) {
    const Eigen::Index row = static_cast<Eigen::Index>(c) * width;
    u[row] += std::max(room[c], -part.most_apart);
    if (room[c] > -part.most_apart) du.row(row) += chain(rows.changes[c].gap(), dq);
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
          add_product(R.row(path.residuals.first + r), dq, du.middleRows(row, 1));
  }
  Matrix G(m, m);
  system_.problem().delassus(G);
  const VectorXd scaled = apart.c.cwiseProduct(u);
  const double size = mass_norm(at_1.M, y);
  const LawDerivative law =
      differentiate_law(system_.problem(), part.lambda_apart.data(), scaled.data(), G,
                        apart.c.asDiagonal() * du, size, [&] { return mass_norm(at_1.M, dq); });
  note(law);
  dy += at_1.factor.solve_changes(product(apart.J.transpose(), apart.c.asDiagonal() * law.multipliers));
  maps_.at(y.data(), y.data());
  Changes moved = Changes::Zero(nv, k);
  maps_.add(&Joints::carry, dq, moved);
  maps_.add(&Joints::velocity, dy, moved);
  dq = moved;
  return true;
}

}  // namespace axode
