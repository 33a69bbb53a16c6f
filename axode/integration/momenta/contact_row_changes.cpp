#include "axode/integration/momenta/contact_step_derivative.hpp"
#include "axode/scalar/index.hpp"

/// The part of ContactStepDerivative that differentiates the Jacobian of contacts and loops along directions.
namespace axode {
namespace {

using Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace

void ContactStepDerivative::displace_each(const VectorXd& q, const VectorXd& v) {
  first_column_ = model_.nv();
  motion_.run(q.data(), v.data(), each_, none_, first_column_ + first_);
}

void ContactStepDerivative::displace(const VectorXd& q, const VectorXd& v, const Changes& dq,
                                     const Changes& dv) {
  first_column_ = 0;
  motion_.run(q.data(), v.data(), dq, dv, first_);
}

Changes ContactStepDerivative::chain(const ChangesArgument& x, const Changes& dq) const {
  Changes out = product(x.leftCols(dq.rows()), dq);
  if (x.cols() > dq.rows()) out.leftCols(k_) += x.rightCols(k_);
  return out;
}

bool ContactStepDerivative::find(const std::vector<Contact>& contacts, double margin, Rows& out) {
  out = {};
  jets_.restart();
  for (const Contact& contact : contacts) {
    const ContactJet* jet = jets_.find(contact.key, motion_.poses(), margin);
    if (!jets_.closed_form()) {
      why_ = "the points of contact between " + jets_.names(contact.key) +
             " have no closed form, so that their derivatives are not known; "
             "give one of the two another shape";
      return false;
    }
    out.found.push_back(jet != nullptr);
    out.jets.push_back(jet ? *jet : ContactJet{});
    out.changes.push_back(jet ? motion_.contact(*jet) : ContactChanges{});
    if (jet && along_.placement.size() > 0) {
      const ContactChanges by = placement_changes(contact.key, *jet);
      ContactChanges& changes = out.changes.back();
      const Eigen::Index first = first_column_ + first_;
      changes.point().middleCols(first, p_) += by.point();
      changes.normal().middleCols(first, p_) += by.normal();
      changes.gap().segment(first, p_) += by.gap();
    }
    if (!jet || thickness_.size() == 0) continue;
    // A layer on a shape moves the side of this shape at the contact along the normal. The contact point is
    // on b if a is a plane, and otherwise half-way.
    const auto [a, b] = shapes_of_key(contact.key);
    const Eigen::RowVectorXd on_a = thickness_.row(a), on_b = thickness_.row(b);
    const double part_a = shapes_[a].kind == ShapeKind::plane ? 0 : 0.5;
    ContactChanges& changes = out.changes.back();
    changes.gap().segment(first_column_, k_) -= on_a + on_b;
    changes.point().middleCols(first_column_, k_) +=
        to_eigen(jet->normal) * (part_a * on_a - (1 - part_a) * on_b);
  }
  return true;
}

ContactChanges ContactStepDerivative::placement_changes(std::uint64_t key, const ContactJet& jet) const {
  const auto displacements = [&](int shape) {
    const SE3<> C = motion_.poses()[index(shapes_[shape].body)] * shapes_[shape].pose;
    const auto own = along_.placement.middleRows<6>(6 * shape);
    ScrewChanges xi(6, p_);
    xi << to_eigen(C.R) * own.topRows<3>(), to_eigen(C.R) * own.bottomRows<3>();
    return std::pair(xi, C.r);
  };
  const auto [a, b] = shapes_of_key(key);
  const auto [xi_a, r_a] = displacements(a);
  const auto [xi_b, r_b] = displacements(b);
  return contact_changes(jet, {xi_a, r_a}, {xi_b, r_b});
}

Changes ContactStepDerivative::coefficient_changes(const std::vector<Contact>& contacts, Eigen::Index rows,
                                                   const Changes& friction) const {
  Changes out = Changes::Zero(rows, friction.cols());
  if (friction.size() == 0) return out;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const auto [a, b] = shapes_of_key(contacts[k].key);
    const double mu_a = shapes_[a].surface.friction.value_or(0),
                 mu_b = shapes_[b].surface.friction.value_or(0);
    if (!(contacts[k].surface.friction > 0)) continue;
    const Eigen::Index row = static_cast<Eigen::Index>(k) * system_.contact_rows();
    for (int i = 1; i <= 2; ++i)
      out.row(row + i) =
          (mu_b * friction.row(a) + mu_a * friction.row(b)) / (2 * contacts[k].surface.friction);
  }
  return out;
}

Eigen::RowVectorXd ContactStepDerivative::restitution_changes(const Contact& contact) const {
  const auto [a, b] = shapes_of_key(contact.key);
  return restitution_.row(shapes_[a].surface.restitution < shapes_[b].surface.restitution ? b : a);
}

void ContactStepDerivative::set_axes(const std::vector<Contact>& contacts, Rows& out) {
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    out.axes.push_back(contact_frame(contacts[k].normal));
    out.daxes.push_back(frame_changes(contacts[k].normal, out.changes[k].normal()));
  }
}

ContactStepDerivative::Impulses ContactStepDerivative::set_rows(const VectorXd& q,
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
  return {J, Eigen::Map<const VectorXd>(problem.c.data(), problem.rows()),
          Eigen::Map<const VectorXd>(lambda.data(), static_cast<Eigen::Index>(lambda.size()))};
}

Changes ContactStepDerivative::impulse_changes(const VectorXd& q, const Rows& rows, const VectorXd& physical,
                                               const Changes& dq) {
  Changes by_each = Changes::Zero(dq.rows(), motion_.directions());
  const int width = system_.contact_rows();
  for (std::size_t k = 0; k < rows.jets.size(); ++k)
    motion_.add_impulse_changes(rows.jets[k], rows.changes[k], rows.axes[k], rows.daxes[k], width,
                                physical.data() + static_cast<Eigen::Index>(k) * width, by_each);
  if (model_.loops().empty()) return chain(by_each, dq);
  LoopSystem<double>& loops = loops_.system(model_);
  const Eigen::Index nv = dq.rows(), m = model_.loops().rows;
  RowMajor by_q = RowMajor::Zero(m, nv), by_v = by_q, forces_by_q = RowMajor::Zero(nv, nv);
  const VectorXd none = VectorXd::Zero(nv);
  VectorXd force(nv);
  loops.force(q.data(), none.data(), none.data(), {}, force.data());
  loops.make_rows(ConstraintLevel::velocity);
  loops.differentiate(physical.data() + system_.first_loop_row(), by_q.data(), by_v.data(),
                      forces_by_q.data());
  by_each.leftCols(nv) += forces_by_q;
  return chain(by_each, dq);
}

Changes ContactStepDerivative::velocity_changes(const VectorXd& q, const VectorXd& x, const Rows& rows,
                                                const Changes& dq, VectorXd& u) {
  const int width = system_.contact_rows();
  const Eigen::Index m = system_.problem().rows(), nv = dq.rows();
  Changes by_each = Changes::Zero(m, motion_.directions());
  u.resize(m);
  system_.times(x.data(), u.data());
  for (std::size_t k = 0; k < rows.jets.size(); ++k) {
    const Eigen::Index row = static_cast<Eigen::Index>(k) * width;
    by_each.middleRows(row, width) = motion_.row_velocities(rows.jets[k], rows.changes[k], rows.axes[k],
                                                            rows.daxes[k], width, u.data() + row);
  }
  if (model_.loops().empty()) return chain(by_each, dq);
  LoopSystem<double>& loops = loops_.system(model_);
  const Eigen::Index loop_rows = model_.loops().rows;
  RowMajor by_q = RowMajor::Zero(loop_rows, nv), by_v = by_q, forces_by_q = RowMajor::Zero(nv, nv);
  const VectorXd none = VectorXd::Zero(nv), no_multipliers = VectorXd::Zero(loop_rows);
  VectorXd force(nv);
  loops.force(q.data(), none.data(), x.data(), {}, force.data());
  loops.make_rows(ConstraintLevel::velocity);
  loops.differentiate(no_multipliers.data(), by_q.data(), by_v.data(), forces_by_q.data());
  by_each.bottomLeftCorner(loop_rows, nv) = by_q;
  return chain(by_each, dq);
}

}  // namespace axode
