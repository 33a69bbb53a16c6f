#pragma once
#include <span>
#include <string>
#include <vector>

#include "axode/codegen/tape/recording.hpp"

/// Makes recorded functions (lists of operations) from others, by composition and by the rules of
/// differentiation. A derivative that is always 0 becomes the constant 0, so that the sparsity of derivatives
/// is known.
namespace axode::codegen {

/// A function that is composed of recorded functions, and recorded on a tape of its own.
class Composition {
 public:
  using Traces = std::vector<Trace>;

  /// Adds an argument of n entries and returns the entries.
  Traces argument(const std::string& name, int n);
  /// Adds the arguments of the function f and returns the entries of each.
  std::vector<Traces> arguments_of(const Recording& f);
  /// Calls the recorded function f (a list of operations) within the function that is being composed: records
  /// the operations of f with the given arguments, and returns the results of f. If f reports that the mass
  /// matrix may be singular, the composed function reports this as well.
  Traces operator()(const Recording& f, std::span<const Traces> arguments);
  Traces operator()(const Recording& f, std::initializer_list<Traces> arguments) {
    return (*this)(f, std::span(arguments.begin(), arguments.size()));
  }
  /// The derivative of x in a direction of the arguments. Entry k of `direction` is the direction of argument
  /// k; arguments without an entry do not change.
  Traces along(const Traces& x, std::span<const Traces> direction) const;
  /// The gradient of Σ w_k x_k with respect to the first `arguments` arguments, one argument after the other.
  Traces gradient(const Traces& x, const Traces& w, std::size_t arguments) const;
  /// The matrix of derivatives of the numbers x by all entries of the first `arguments` arguments. The matrix
  /// is stored column by column, and each column belongs to an entry of an argument.
  Traces jacobian(const Traces& x, std::size_t arguments) const;

  /// Returns the function that was composed by the preceding calls on this object as a recording (a list of
  /// operations), with `results` as its results and `result` as their name. This object is empty afterwards.
  Recording with(const std::string& result, Traces results);

 private:
  /// The derivatives of the results of the recorded function `made` along a direction of its arguments.
  /// `made` has a copy of all operations that this object has recorded so far, and its results are the
  /// numbers to be differentiated. Entry k of `direction` is the direction of argument k. need[k] says
  /// whether a result depends on operation k; other operations are skipped.
  Traces along(const Recording& made, const std::vector<char>& need, std::span<const Traces> direction) const;
  /// The index of the node of an entry of an argument.
  std::size_t node(std::size_t argument, std::size_t entry) const;

  Tape tape_;
  Recording recording_;
  std::vector<Traces> inputs_;
};

/// Returns a function that computes the matrix of derivatives of f by all its arguments; a column belongs to
/// an entry of an argument.
Recording jacobian_of(const Recording& f);
/// Returns a function that computes the derivative of f in a direction. It has the arguments of f and, for
/// each argument q, an additional argument fwd_q with the direction of q.
Recording tangent_of(const Recording& f);
/// Additional arguments of a recording that have a weight for each result.
struct Weights {
  std::vector<std::string> names;
  std::vector<int> lengths;
  /// Adds the arguments for the weights to a composition and returns their entries.
  Composition::Traces on(Composition& composition) const;
};
/// Returns a function that computes the gradient of Σ w_k f_k by all arguments of f, one after the other. The
/// weights w are additional arguments, and f_k are the results of f.
Recording adjoint_of(const Recording& f, const Weights& weights);
/// Returns a function that computes the second derivatives of Σ w_k f_k by all arguments of f, a square
/// matrix. The weights w are additional arguments, and f_k are the results of f.
Recording hessian_of(const Recording& f, const Weights& weights);

}  // namespace axode::codegen
