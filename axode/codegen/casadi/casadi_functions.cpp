#include "axode/codegen/casadi/casadi_functions.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "axode/codegen/tape/differentiation.hpp"

namespace axode::codegen {
namespace {

using Traces = Composition::Traces;

/// The function f with the quaternions in its argument q divided by their norm.
Recording normalised(const Model& model, const Recording& f) {
  const Topology& topology = *model.tree<double>().topology();
  if (topology.quaternion_bodies.empty()) return f;
  Composition on;
  std::vector<Traces> x = on.arguments_of(f);
  const Traces q = x[0];
  for (const int body : topology.quaternion_bodies) {
    const std::size_t first = topology.iq[body];
    Trace square;
    for (std::size_t k = first; k < first + 4; ++k) square += q[k] * q[k];
    const Trace shorter = 1 / sqrt(square);
    for (std::size_t k = first; k < first + 4; ++k) x[0][k] = shorter * q[k];
  }
  return on.with(f.result, on(f, x));
}

/// Records the forward dynamics a = M⁻¹ (tau - T(q, v, 0)) and its derivatives, with the mass matrix M and
/// the inverse dynamics T(q, v, a). Indices denote partial derivatives at these accelerations a. The
/// derivative da along a direction (dq, dv, dtau), and the Hessian H of the weighted sum w·a by x = (q, v,
/// tau), are
///
///     M da = dtau - T_q dq - T_v dv,    H = - mu (T_xx + T_xa a_x + (T_xa a_x)ᵀ)   with mu = M⁻¹ w,
///
/// where mu T is the sum of the components of T with the weights mu. The rows of mu T_xa for v and tau are 0.
/// The rows for q, multiplied by a_x, are - Kᵀ T_q, - Kᵀ T_v and Kᵀ in the columns of q, v and tau, with K =
/// M⁻¹ (mu T_aq).
class Accelerations {
 public:
  explicit Accelerations(const Model& model)
      : model_(model),
        forces_(normalised(model, record(model, {"inverse_dynamics"}, false))),
        forces_jacobian_(jacobian_of(forces_)) {
    for (const Recording& solution : record_solutions(model))
      solutions_.push_back(normalised(model, solution));
  }

  Recording value() const {
    return shortest([](Composition& on, const State& at, const Recording&) { return on.with("a", at.a); });
  }

  Recording jacobian() const {
    return shortest([&](Composition& on, const State& at, const Recording& solution) {
      return on.with("jac", by_state(on, at, solution));
    });
  }
  Recording tangent() const {
    const Recording forces_tangent = tangent_of(forces_);
    return shortest([&](Composition& on, const State& at, const Recording& solution) {
      const Traces dq = on.argument("fwd_q", model_.nq()), dv = on.argument("fwd_v", model_.nv());
      Traces rest = on.argument("fwd_tau", model_.nv());
      subtract(rest, on(forces_tangent, {at.q, at.v, at.a, dq, dv, Traces(rest.size())}));
      return on.with("fwd", on(solution, {at.q, rest}));
    });
  }
  Recording adjoint(const Weights& weights) const {
    const Recording forces_adjoint = adjoint_of(forces_, {{"w"}, {model_.nv()}});
    return shortest([&](Composition& on, const State& at, const Recording& solution) {
      const Traces mu = on(solution, {at.q, weights.on(on)});
      Traces out = on(forces_adjoint, {at.q, at.v, at.a, mu});
      const std::size_t moving = out.size() - mu.size();
      for (std::size_t k = 0; k < moving; ++k) out[k] = -out[k];
      std::ranges::copy(mu, out.begin() + static_cast<std::ptrdiff_t>(moving));
      return on.with("adj", std::move(out));
    });
  }
  Recording hessian(const Weights& weights) const {
    const Recording forces_hessian = hessian_of(forces_, {{"w"}, {model_.nv()}});
    return shortest([&](Composition& on, const State& at, const Recording& solution) {
      const Traces mu = on(solution, {at.q, weights.on(on)});
      const Traces L = on(forces_hessian, {at.q, at.v, at.a, mu});
      const std::size_t nq = at.q.size(), nv = at.v.size(), n = nq + 2 * nv, moving = nq + nv;
      std::vector<Traces> K;
      for (std::size_t i = 0; i < nq; ++i) {
        const auto by_a = L.begin() + static_cast<std::ptrdiff_t>(i * n + moving);
        K.push_back(on(solution, {at.q, Traces(by_a, by_a + static_cast<std::ptrdiff_t>(nv))}));
      }
      return on.with("hess", curvature(L, on(forces_jacobian_, {at.q, at.v, at.a}), K));
    });
  }

 private:
  struct State {
    Traces q, v, a;
  };
  State state(Composition& on, const Recording& solution) const {
    State at{on.argument("q", model_.nq()), on.argument("v", model_.nv()), {}};
    Traces rest = on.argument("tau", model_.nv());
    subtract(rest, on(forces_, {at.q, at.v, Traces(rest.size())}));
    at.a = on(solution, {at.q, rest});
    return at;
  }
  static void subtract(Traces& x, const Traces& y) {
    for (std::size_t k = 0; k < x.size(); ++k) x[k] -= y[k];
  }
  /// Makes a recording (a list of operations) once with each method that solves M x = b, where M is the mass
  /// matrix, and returns the recording with the fewest operations. For each method, make(composition, state,
  /// solution) must return the recording: `composition` receives the operations, `state` has the recorded
  /// coordinates q, velocities v and accelerations a, and `solution` is the recording of x = M⁻¹ b, a
  /// function of q and b.
  template <class Make> Recording shortest(const Make& make) const {
    Recording best;
    for (const Recording& solution : solutions_) {
      Composition on;
      Recording made = make(on, state(on, solution), solution);
      if (best.nodes.empty() || operations(made).total() < operations(best).total()) best = std::move(made);
    }
    return best;
  }
  /// The derivatives of the accelerations a by each entry of q, v and tau, as contiguous columns.
  Traces by_state(Composition& on, const State& at, const Recording& solution) const {
    Traces columns = on(forces_jacobian_, {at.q, at.v, at.a});
    const std::size_t nv = at.v.size(), moving = at.q.size() + nv;
    for (std::size_t c = 0; c < moving + nv; ++c) {
      Traces rest(nv);
      for (std::size_t r = 0; r < nv; ++r) rest[r] = c < moving ? -columns[c * nv + r] : T(c - moving == r);
      std::ranges::copy(on(solution, {at.q, rest}), columns.begin() + static_cast<std::ptrdiff_t>(c * nv));
    }
    // M⁻¹ is symmetric. Keeps the half that each solution computes first, on its way to the leaves.
    for (std::size_t c = 0; c < nv; ++c)
      for (std::size_t r = c + 1; r < nv; ++r)
        columns[(moving + c) * nv + r] = columns[(moving + r) * nv + c];
    return columns;
  }
  /// The upper triangle of the Hessian of the weighted accelerations w·a by (q, v, tau). The accelerations a
  /// solve T(q, v, a) = tau, where T is the inverse dynamics. Indices denote derivatives of T by x = (q, v,
  /// a) or by parts of it, and mu = M⁻¹ w with the mass matrix M. The arguments are L = mu T_xx, the columns
  /// of T_x, and K = M⁻¹ (mu T_aq).
  Traces curvature(const Traces& L, const Traces& T_x, const std::vector<Traces>& K) const {
    const std::size_t nq = K.size(), nv = static_cast<std::size_t>(model_.nv()), n = nq + 2 * nv,
                      moving = nq + nv;
    const auto through_a = [&](std::size_t i, std::size_t j) {
      Trace sum;
      for (std::size_t k = 0; k < nv; ++k) sum += K[i][k] * T_x[j * nv + k];
      return sum;
    };
    Traces H(n * n);
    for (std::size_t i = 0; i < moving; ++i)
      for (std::size_t j = i; j < moving; ++j) {
        H[i * n + j] = -L[i * n + j];
        if (i < nq) H[i * n + j] += through_a(i, j);
        if (j < nq) H[i * n + j] += through_a(j, i);
      }
    for (std::size_t i = 0; i < nq; ++i)
      for (std::size_t j = 0; j < nv; ++j) H[i * n + moving + j] = -K[i][j];
    return H;
  }

  using T = Trace;
  const Model& model_;
  Recording forces_, forces_jacobian_;
  std::vector<Recording> solutions_;
};

/// Removes the results that are always 0 from a recording (a list of operations). Returns the new index of
/// each result, or -1 for a removed one.
std::vector<int> keep_nonzeros(Recording& recording) {
  std::vector<int> places;
  Traces kept;
  for (const Trace& x : recording.results) {
    const bool is_zero = x.is_constant() && x.factor() == 0;
    places.push_back(is_zero ? -1 : static_cast<int>(kept.size()));
    if (!is_zero) kept.push_back(x);
  }
  recording.results = std::move(kept);
  return places;
}

Pattern dense(int rows, int columns) {
  Pattern pattern{rows, columns};
  for (int k = 0; k < rows * columns; ++k) pattern.entries.push_back(k);
  return pattern;
}

/// Makes an output matrix from the results of a recording (a list of operations). result(r, c) must return
/// the index of the result that is entry (r, c), or a negative number for an entry that is always 0.
template <class Result>
CasadiOutput output(std::string name, int rows, int columns, std::size_t recording, const Result& result) {
  CasadiOutput out{std::move(name), {rows, columns}, recording};
  for (int c = 0; c < columns; ++c)
    for (int r = 0; r < rows; ++r)
      if (const int place = result(r, c); place >= 0) {
        out.pattern.entries.push_back(c * rows + r);
        out.results.push_back(place);
      }
  return out;
}

/// Returns the output matrices of a function that is generated for CasADi: the shape of each, its entries
/// that are not always 0, and for each such entry its index among the results of `value`, the recording (list
/// of operations) of the generated function. Results that are always 0 are removed from `value`. The constant
/// 1 is appended as its last result for every generated function; only the 4 × 4 matrices of poses use it, as
/// their last entry.
std::vector<CasadiOutput> matrices(const Model& model, const Function& function,
                                   std::span<const std::string> frames, Recording& value) {
  const int nv = model.nv();
  value.results.push_back(1);
  const std::vector<int> places = keep_nonzeros(value);
  const int one = places.back();
  const auto at = [&](int k) { return places[k]; };
  const auto square = [&](int r, int c) { return at(r * nv + c); };
  const catalog::Words& row = function.row.words();
  if (row.entry == catalog::Entry::twist) return {output(value.result, 6, nv, 0, square)};
  if (row.entry == catalog::Entry::pose) {
    std::vector<CasadiOutput> all;
    for (int f = 0; f < std::ssize(places) / 12; ++f)
      all.push_back(output(function.is_of_a_frame() ? value.result : value.result + "_" + frames[f], 4, 4, 0,
                           [&](int r, int c) { return r < 3   ? at(12 * f + 3 * c + r)
                                                      : c < 3 ? -1
                                                              : one; }));
    return all;
  }
  if (row.shape.size() == 2) return {output(value.result, nv, nv, 0, square)};
  return {output(value.result, nv, 1, 0, [&](int r, int) { return at(r); })};
}

/// Brings the results of the recording into the order of the entries of the output matrices.
void put_in_order(std::vector<CasadiOutput>& outputs, Recording& value) {
  Traces ordered;
  for (CasadiOutput& out : outputs)
    for (int& result : out.results) {
      ordered.push_back(value.results[result]);
      result = static_cast<int>(ordered.size()) - 1;
    }
  value.results = std::move(ordered);
}

/// Makes the functions of a CasadiFamily from the recordings of a function and of its derivatives.
class Family {
 public:
  enum Kind : std::size_t { value, tangent, adjoint, jacobian, hessian };

  Family(const std::string& name, std::vector<CasadiOutput> outputs, std::vector<Recording> recordings)
      : name_(name), outputs_(std::move(outputs)), recordings_(std::move(recordings)) {
    const Recording& f = recordings_[value];
    for (std::size_t k = 0; k < f.arguments.size(); ++k)
      inputs_.push_back({f.arguments[k], dense(f.lengths[k], 1)});
    for (const CasadiInput& input : inputs_) n_ += input.pattern.rows;
  }
  CasadiFamily made() {
    std::vector<CasadiInput> nominal = inputs_, directed, weighted;
    for (const CasadiOutput& out : outputs_)
      nominal.push_back({"out_" + out.name, {out.pattern.rows, out.pattern.columns}});
    directed = weighted = nominal;
    for (const CasadiInput& input : inputs_) directed.push_back({"fwd_" + input.name, input.pattern});
    for (const CasadiOutput& out : outputs_) weighted.push_back({"adj_" + out.name, out.pattern});
    std::vector<CasadiFunction> functions{{name_, inputs_, outputs_},
                                          {"fwd1_" + name_, directed, changes()},
                                          {"adj1_" + name_, weighted, gradients()},
                                          {"jac_" + name_, nominal, first_derivatives(), true}};
    if (recordings_.size() > hessian) {
      for (const CasadiInput& input : inputs_)
        weighted.push_back({"out_adj_" + input.name, {input.pattern.rows, 1}});
      functions.push_back({"jac_adj1_" + name_, weighted, second_derivatives(), true});
    }
    return {std::move(recordings_), std::move(functions), {}};
  }

 private:
  /// Calls use(output, input, block) for each output and each input of the function. `block` describes the
  /// matrix of derivatives of the output by the input, column by column. For each entry of the matrix it has
  /// the index of this entry among the results of the recording (the list of operations) that computes all
  /// derivatives, or -1 if the entry is always 0.
  template <class Use> void each_block(const std::vector<int>& places, const Use& use) const {
    const std::size_t m = recordings_[value].results.size();
    std::size_t row = 0;
    for (const CasadiOutput& out : outputs_) {
      std::size_t column = 0;
      for (const CasadiInput& input : inputs_) {
        const int rows = out.pattern.rows * out.pattern.columns;
        std::vector<std::vector<int>> block;  // for each column: the result that is each entry of the output,
                                              // or -1
        for (int c = 0; c < input.pattern.rows; ++c) {
          block.emplace_back(rows, -1);
          for (std::size_t k = 0; k < out.pattern.entries.size(); ++k)
            block.back()[static_cast<std::size_t>(out.pattern.entries[k])] =
                places[(column + static_cast<std::size_t>(c)) * m + row + k];
        }
        use(out, input, block);
        column += static_cast<std::size_t>(input.pattern.rows);
      }
      row += out.pattern.entries.size();
    }
  }
  static int in(const std::vector<std::vector<int>>& block, int r, int c) { return block[c][r]; }
  std::vector<CasadiOutput> first_derivatives() {
    std::vector<CasadiOutput> blocks;
    jacobian_places_ = keep_nonzeros(recordings_[jacobian]);
    each_block(jacobian_places_, [&](const auto& out, const auto& input, const auto& block) {
      blocks.push_back(output("jac_" + out.name + "_" + input.name, out.pattern.rows * out.pattern.columns,
                              input.pattern.rows, jacobian, [&](int r, int c) { return in(block, r, c); }));
    });
    return blocks;
  }
  std::vector<CasadiOutput> changes() const {
    std::vector<CasadiOutput> all = outputs_;
    for (CasadiOutput& out : all) {
      out.name = "fwd_" + out.name;
      out.recording = tangent;
    }
    return all;
  }
  std::vector<CasadiOutput> gradients() const {
    std::vector<CasadiOutput> all;
    int first = 0;
    for (const CasadiInput& input : inputs_) {
      all.push_back(
          output("adj_" + input.name, input.pattern.rows, 1, adjoint, [&](int r, int) { return first + r; }));
      first += input.pattern.rows;
    }
    return all;
  }
  /// The results of the function that CasADi calls jac_adj1_NAME, the derivatives of the gradient of the
  /// weighted sum of the results of a function NAME: by the inputs, by the values of the outputs (always 0),
  /// and by the weights (the transposed Jacobian).
  std::vector<CasadiOutput> second_derivatives() {
    Recording& H = recordings_[hessian];
    for (int i = 0; i < n_; ++i)
      for (int j = 0; j < i; ++j) H.results[i * n_ + j] = 0;
    const std::vector<int> places = keep_nonzeros(H);
    std::vector<CasadiOutput> blocks;
    int row = 0;
    for (const CasadiInput& x : inputs_) {
      const std::string name = "jac_adj_" + x.name + "_";
      int column = 0;
      for (const CasadiInput& y : inputs_) {
        blocks.push_back(output(name + y.name, x.pattern.rows, y.pattern.rows, hessian, [&](int r, int c) {
          const int i = std::min(row + r, column + c), j = std::max(row + r, column + c);
          return places[i * n_ + j];
        }));
        column += y.pattern.rows;
      }
      for (const CasadiOutput& out : outputs_)
        blocks.push_back(
            {name + "out_" + out.name, {x.pattern.rows, out.pattern.rows * out.pattern.columns}});
      each_block(jacobian_places_, [&](const auto& out, const auto& input, const auto& block) {
        if (input.name == x.name)
          blocks.push_back(output(name + "adj_" + out.name, x.pattern.rows,
                                  out.pattern.rows * out.pattern.columns, jacobian,
                                  [&](int r, int c) { return in(block, c, r); }));
      });
      row += x.pattern.rows;
    }
    return blocks;
  }

  std::string name_;
  std::vector<CasadiInput> inputs_;
  std::vector<CasadiOutput> outputs_;
  std::vector<Recording> recordings_;
  std::vector<int> jacobian_places_;
  int n_ = 0;
};

/// The derivatives of M from which CasadiInverse computes the derivatives of M⁻¹.
CasadiInverse inverse_of(const Model& model, const CasadiOutput& out) {
  const auto part = [](Recording recording) {
    const std::vector<int> found = keep_nonzeros(recording);
    std::vector<int> places;
    for (std::size_t k = 0; k < found.size(); ++k)
      if (found[k] >= 0) places.push_back(static_cast<int>(k));
    return CasadiInverse::Part{std::move(recording), std::move(places)};
  };
  const int nq = model.nq(), nv = model.nv();
  const Recording M = normalised(model, record(model, {"mass_matrix"}, false));
  const Weights B{{"B"}, {nv * nv}};
  return {nq,
          nv,
          out.pattern.entries,
          "adj_" + out.name,
          {part(tangent_of(M)), part(adjoint_of(M, B)), part(jacobian_of(M))}};
}

Weights weights_of(const std::vector<CasadiOutput>& outputs) {
  Weights weights;
  for (const CasadiOutput& out : outputs) {
    weights.names.push_back("adj_" + out.name);
    weights.lengths.push_back(static_cast<int>(out.results.size()));
  }
  return weights;
}

}  // namespace

CasadiFamily casadi_family(const Model& model, const Function& function, const std::string& name,
                           std::span<const std::string> frames) {
  const std::optional<Accelerations> a =
      function.is("forward_dynamics") ? std::optional<Accelerations>(model) : std::nullopt;
  Recording f = a ? a->value() : normalised(model, record(model, function, false));
  std::vector<CasadiOutput> outputs = matrices(model, function, frames, f);
  put_in_order(outputs, f);
  if (function.is("inverse_mass_matrix")) {
    CasadiInverse inverse = inverse_of(model, outputs[0]);
    std::vector<Recording> recordings{f};
    for (std::size_t kind = 0; kind < CasadiInverse::kinds; ++kind)
      recordings.push_back(inverse.signature(static_cast<CasadiInverse::Kind>(kind)));
    CasadiFamily family = Family(name, std::move(outputs), std::move(recordings)).made();
    family.inverse = std::move(inverse);
    return family;
  }
  const Weights w = weights_of(outputs);
  std::vector<Recording> recordings =
      a ? std::vector{f, a->tangent(), a->adjoint(w), a->jacobian(), a->hessian(w)}
        : std::vector{f, tangent_of(f), adjoint_of(f, w), jacobian_of(f), hessian_of(f, w)};
  return Family(name, std::move(outputs), std::move(recordings)).made();
}

}  // namespace axode::codegen
