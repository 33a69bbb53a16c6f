#pragma once
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "axode/codegen/tape/recording.hpp"

namespace axode::codegen {

/// The first derivatives of A(q) = M⁻¹ for CasADi, computed from derivatives of M and products of matrices in
/// loops. Without loops the code would be too long for compilers if the mechanism is a humanoid. With weights
/// W and B = A W A,
///
///     dA = - A dM A,    d(W·A) = - B·dM.
class CasadiInverse {
 public:
  enum Kind : std::size_t { tangent, adjoint, jacobian };
  static constexpr std::size_t kinds = 3;

  /// A function of M with nv x nv results: its derivative in a direction, its gradient with weights B, or its
  /// derivatives by each coordinate. Only the entries `places` are results of the recording; the others are
  /// 0.
  struct Part {
    Recording recording;
    std::vector<int> places;
  };

  /// `entries` are the indices r + nv c of the entries (r, c) that the function for A computes. `weights` is
  /// the name of their weights.
  CasadiInverse(int nq, int nv, std::vector<int> entries, std::string weights,
                std::array<Part, kinds> masses);

  const Recording& of_masses(Kind kind) const { return masses_[kind].recording; }
  /// A recording with the arguments of a function for A. Its results are 1, or 0 for results that are always
  /// 0, which the function leaves out.
  Recording signature(Kind kind) const;
  /// The operations of a function in addition to those for A.
  Operations operations(Kind kind) const;
  /// Length of the memory that a function uses after its results.
  std::size_t scratch() const;
  /// The body of a function in C. `inverse` and `masses` are the names of the functions for A and for the
  /// part of M; table(numbers) returns the name of a constant array.
  std::string body(Kind kind, const std::string& prefix, const std::string& inverse,
                   const std::string& masses,
                   const std::function<std::string(const std::vector<int>&)>& table) const;
  /// Loops that the functions of a file share.
  static std::string loops(const std::string& prefix);

 private:
  std::size_t nq_, nv_;
  std::vector<int> entries_;
  std::string weights_;
  std::array<Part, kinds> masses_;
  std::vector<int> begin_;  ///< for each coordinate q_k: where its results begin among those of ∂M/∂q
  std::vector<int> by_q_;   ///< the non-zero entries of ∂A/∂q: k n + e, with n entries of A, if the
                            ///< derivative of entry e by q_k may not be 0
};

}  // namespace axode::codegen
