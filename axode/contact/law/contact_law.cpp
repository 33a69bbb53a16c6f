#include "axode/contact/law/contact_law.hpp"

#include <algorithm>
#include <cmath>

namespace axode {
namespace {

/// The norm |z_T| of the friction rows of a contact.
double tangential(const LawBlock& block, const double* z) {
  double sum = 0;
  for (int k = 1; k < block.rows; ++k) sum += z[k] * z[k];
  return std::sqrt(sum);
}

void scale_tangential(const LawBlock& block, const double* z, double factor, double* lambda) {
  for (int k = 1; k < block.rows; ++k) lambda[k] = factor * z[k];
}

}  // namespace

void resolve(const LawBlock& block, const double* z, double* lambda) noexcept {
  switch (block.law) {
    case ContactLaw::contact: {
      const double n = z[0] < 0 ? 0 : z[0], t = tangential(block, z);
      scale_tangential(block, z, t > n ? n / t : 1, lambda);
      lambda[0] = n;
      return;
    }
    case ContactLaw::stop: lambda[0] = z[0] < 0 ? 0 : z[0]; return;
    case ContactLaw::dry_friction: lambda[0] = std::clamp(z[0], -block.bound, block.bound); return;
    case ContactLaw::loop: lambda[0] = z[0]; return;
    case ContactLaw::pressed: {
      const double t = tangential(block, z);
      scale_tangential(block, z, t > block.bound ? block.bound / t : 1, lambda);
      lambda[0] = 0;
      return;
    }
  }
}

LawBranch branch_of(const LawBlock& block, const double* z) noexcept {
  switch (block.law) {
    case ContactLaw::contact:
      if (!(z[0] > 0)) return LawBranch::open;
      return tangential(block, z) <= z[0] ? LawBranch::stick : LawBranch::slide;
    case ContactLaw::stop: return z[0] > 0 ? LawBranch::stick : LawBranch::open;
    case ContactLaw::dry_friction: return std::abs(z[0]) < block.bound ? LawBranch::stick : LawBranch::slide;
    case ContactLaw::loop: break;
    case ContactLaw::pressed:
      if (!(block.bound > 0)) return LawBranch::open;
      return tangential(block, z) <= block.bound ? LawBranch::stick : LawBranch::slide;
  }
  return LawBranch::stick;
}

template <int rows>
LawBranch differentiate(const LawBlock& block, const double* z, LawMatrix<rows>& Z) noexcept {
  const LawBranch branch = branch_of(block, z);
  const bool pressed = block.law == ContactLaw::pressed;
  if (branch == LawBranch::stick) {
    Z.setIdentity();
    if (pressed) Z(0, 0) = 0;
  } else {
    Z.setZero();
    if constexpr (rows > 1) {
      if (branch == LawBranch::slide) {
        const double t = tangential(block, z), s = (pressed ? block.bound : z[0]) / t;
        const Eigen::Matrix<double, rows - 1, 1> T =
            Eigen::Map<const Eigen::Matrix<double, rows - 1, 1>>(z + 1) / t;
        if (!pressed) {
          Z(0, 0) = 1;
          Z.template bottomLeftCorner<rows - 1, 1>() = T;
        }
        Z.template bottomRightCorner<rows - 1, rows - 1>().noalias() = -s * T * T.transpose();
        Z.template bottomRightCorner<rows - 1, rows - 1>().diagonal().array() += s;
      }
    }
  }
  return branch;
}
template LawBranch differentiate<1>(const LawBlock&, const double*, LawMatrix<1>&) noexcept;
template LawBranch differentiate<3>(const LawBlock&, const double*, LawMatrix<3>&) noexcept;
template LawBranch differentiate<4>(const LawBlock&, const double*, LawMatrix<4>&) noexcept;
template LawBranch differentiate<6>(const LawBlock&, const double*, LawMatrix<6>&) noexcept;

void project(const LawBlock& block, const double* z, double* lambda) noexcept {
  const double t = block.law == ContactLaw::contact ? tangential(block, z) : 0;
  if (block.law != ContactLaw::contact || t <= z[0]) {
    resolve(block, z, lambda);
  } else if (t <= -z[0]) {
    std::fill_n(lambda, block.rows, 0.0);
  } else {
    const double half = (z[0] + t) / 2;
    scale_tangential(block, z, half / t, lambda);
    lambda[0] = half;
  }
}

}  // namespace axode
