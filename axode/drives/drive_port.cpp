#include "axode/drives/drive_port.hpp"

#include <stdexcept>

#include "axode/dynamics/spring_elements.hpp"

namespace axode {

DrivePort::DrivePort(const Model& model, const std::string& drive,
                     std::span<const std::pair<std::string, double>> joints) {
  const Tree<double>& tree = model.tree<double>();
  for (const auto& [name, factor] : joints) {
    const int i = model.joint_index(name);
    const Joint& joint = model.joint(i);
    if (joint.dof.size() != 1)
      throw std::invalid_argument("drive \"" + drive + "\" acts on joint \"" + name + "\", which has " +
                                  std::to_string(joint.dof.size()) +
                                  " velocities; a drive acts on joints of one");
    terms_.push_back({tree->iv[i], tree->iq[i], factor * tree.ratio[i], factor * tree.offset[i]});
  }
}

void DrivePort::update(const Tree<double>& tree, std::span<const double> q, std::span<const double> v) {
  row_.clear();
  if (!along_line_) {
    l_ = w_ = 0;
    for (const Term& term : terms_) {
      l_ += term.factor * q[static_cast<std::size_t>(term.coordinate)] + term.offset;
      w_ += term.factor * v[static_cast<std::size_t>(term.velocity)];
      row_.emplace_back(term.velocity, term.factor);
    }
    return;
  }
  columns_.clear();
  const Segment<double> line(line_.points.data(), tree, q.data(), v.data(),
                             [&](std::size_t end, int, int c, const Screw<double>& X) {
                               columns_.emplace_back(end, X.v);
                               row_.emplace_back(c, 0.0);
                             });
  l_ = line.length;
  w_ = line.rate;
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    const auto& [end, moves] = columns_[k];
    const double along = dot(line.u, line.R[end] * moves);
    row_[k].second = end == 0 ? -along : along;
  }
}

/// Adds `factor` times the derivatives by q of the row vector E in l' = E v to `out`, where l = |r| is the
/// length of a line with the vector r between its ends, and u = r/|r|. Entry k of E is u·r_k if a unit of
/// velocity k changes r by r_k and turns the body at the end that it moves by w_k. The derivative is along
/// the left-trivialised direction of each velocity j. If j and k move the same end, r_k changes by w_j × r_k
/// or, if the joint of j is farther from the ground than that of k, by w_k × r_j; otherwise r_k is constant.
void DrivePort::add_row_derivatives(const Tree<double>& tree, std::span<const double> q, double factor,
                                    std::span<double> out) {
  if (!along_line_) return;
  derived_.clear();
  const Segment<double> line(line_.points.data(), tree, q.data(), nullptr,
                             [&](std::size_t end, int i, int c, const Screw<double>& X) {
                               derived_.push_back({end, i, c, X.w, X.v});
                             });
  for (Column& column : derived_) {
    const SO3<>& R = line.R[column.end];
    column.w = R * column.w;
    column.r = column.end == 0 ? -(R * column.r) : R * column.r;
  }
  const std::size_t nv = static_cast<std::size_t>(tree->nv);
  for (const Column& k : derived_)
    for (const Column& j : derived_) {
      Vec3<> turned{};
      if (j.end == k.end) turned = j.body <= k.body ? cross(j.w, k.r) : cross(k.w, j.r);
      const double across = dot(j.r, k.r) - dot(line.u, j.r) * dot(line.u, k.r);
      out[static_cast<std::size_t>(k.c) * nv + static_cast<std::size_t>(j.c)] +=
          factor * (dot(line.u, turned) + across / line.length);
    }
}

}  // namespace axode
