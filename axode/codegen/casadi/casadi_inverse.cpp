#include "axode/codegen/casadi/casadi_inverse.hpp"

#include <algorithm>
#include <span>

#include "axode/codegen/c/c_function.hpp"

namespace axode::codegen {
namespace {

constexpr const char* shared = R"(/* z = x y, of n rows and columns. */
static void @P@_product(int n, const casadi_real *x, const casadi_real *y, casadi_real *z) {
  int r, c, k;
  for (r = 0; r < n; ++r, x += n, z += n) {
    for (c = 0; c < n; ++c) z[c] = 0;
    for (k = 0; k < n; ++k)
      if (x[k] != 0)
        for (c = 0; c < n; ++c) z[c] += x[k] * y[k * n + c];
  }
}
/* n numbers in these places of x, and 0 elsewhere. */
static void @P@_spread(int size, casadi_real *x, int n, const casadi_real *numbers, const int *places) {
  int k;
  for (k = 0; k < size; ++k) x[k] = 0;
  for (k = 0; k < n; ++k) x[places[k]] = numbers[k];
}

)";

constexpr const char* tangent_body = R"( {
  casadi_real *const A = fwd + @N@, *const dM = A + @NN@, *const X = dM + @NN@, *const t = X + @NN@;
  const int failed = @INVERSE@(q, t);
  int k;
  (void)fwd_q;
  @P@_spread(@NN@, A, @N@, t, @ENTRIES@);
@CALL@  @P@_spread(@NN@, dM, @N_PLACES@, t, @PLACES@);
  @P@_product(@NV@, dM, A, X);
  @P@_product(@NV@, A, X, dM);
  for (k = 0; k < @N@; ++k) fwd[k] = -dM[@UPPER@[k]];
  return failed;
}
)";

constexpr const char* adjoint_body = R"( {
  casadi_real *const A = adj + @NQ@, *const B = A + @NN@, *const X = B + @NN@, *const t = X + @NN@;
  const int failed = @INVERSE@(q, t);
  int k;
  @P@_spread(@NN@, A, @N@, t, @ENTRIES@);
  @P@_spread(@NN@, B, @N@, @W@, @ENTRIES@);
  @P@_product(@NV@, A, B, X);
  @P@_product(@NV@, X, A, B);
@CALL@  @P@_spread(@NQ@, adj, @N_PLACES@, t, @PLACES@);
  for (k = 0; k < @NQ@; ++k) adj[k] = -adj[k];
  return failed;
}
)";

constexpr const char* jacobian_body = R"( {
  casadi_real *const A = jac + @N_RESULTS@, *const M = A + @NN@, *const X = M + @NN@, *const t = X + @NN@;
  const int failed = @INVERSE@(q, t);
  int i = 0, k;
  @P@_spread(@NN@, A, @N@, t, @ENTRIES@);
@CALL@  for (k = 0; k < @NQ@; ++k) {
    const int n = @BEGIN@[k + 1] - @BEGIN@[k];
    if (n == 0) continue;
    @P@_spread(@NN@, M, n, t + @BEGIN@[k], @PLACES@ + @BEGIN@[k]);
    @P@_product(@NV@, M, A, X);
    @P@_product(@NV@, A, X, M);
    for (; i < @N_RESULTS@ && @RESULTS@[i] < (k + 1) * @N@; ++i) jac[i] = -M[@UPPER@[@RESULTS@[i] - k * @N@]];
  }
  return failed;
}
)";

/// A flag for each entry of a matrix, or of several contiguous matrices: whether the entry can differ from 0.
using Flags = std::vector<char>;

Flags flags_at(std::span<const int> places, std::size_t size) {
  Flags flags(size);
  for (const int place : places) flags[place] = 1;
  return flags;
}
std::vector<int> places_of(const Flags& flags) {
  std::vector<int> places;
  for (std::size_t k = 0; k < flags.size(); ++k)
    if (flags[k]) places.push_back(static_cast<int>(k));
  return places;
}
Flags product_of_flags(std::size_t n, const Flags& x, const Flags& y) {
  Flags z(n * n);
  for (std::size_t r = 0; r < n; ++r)
    for (std::size_t k = 0; k < n; ++k)
      if (x[r * n + k])
        for (std::size_t c = 0; c < n; ++c) z[r * n + c] |= y[k * n + c];
  return z;
}

}  // namespace

CasadiInverse::CasadiInverse(int nq, int nv, std::vector<int> entries, std::string weights,
                             std::array<Part, kinds> masses)
    : nq_(nq),
      nv_(nv),
      entries_(std::move(entries)),
      weights_(std::move(weights)),
      masses_(std::move(masses)) {
  const std::size_t n = entries_.size(), nn = nv_ * nv_;
  std::vector<int>& places = masses_[jacobian].places;
  for (std::size_t k = 0; k <= nq_; ++k)
    begin_.push_back(
        static_cast<int>(std::ranges::lower_bound(places, static_cast<int>(k * nn)) - places.begin()));
  for (int& place : places) place %= static_cast<int>(nn);

  const Flags A = flags_at(entries_, nn);
  Flags by_q;
  for (std::size_t k = 0; k < nq_; ++k) {
    const std::span all(places);
    const Flags M = flags_at(
        all.subspan(static_cast<std::size_t>(begin_[k]), static_cast<std::size_t>(begin_[k + 1] - begin_[k])),
        nn);
    const Flags A_k = product_of_flags(nv_, A, product_of_flags(nv_, M, A));
    for (std::size_t e = 0; e < n; ++e) by_q.push_back(A_k[static_cast<std::size_t>(entries_[e])]);
  }
  by_q_ = places_of(by_q);
}

Recording CasadiInverse::signature(Kind kind) const {
  const int nq = static_cast<int>(nq_), n = static_cast<int>(entries_.size());
  Recording of{.arguments = {"q"}, .lengths = {nq}, .nodes = {{}}, .returns_singularity = true};
  if (kind == tangent) {
    of.arguments.push_back("fwd_q");
    of.lengths.push_back(nq);
  }
  if (kind == adjoint) {
    of.arguments.push_back(weights_);
    of.lengths.push_back(n);
  }
  const auto give = [&](const char* name, const Flags& flags) {
    of.result = name;
    of.results.assign(flags.begin(), flags.end());
  };
  switch (kind) {
    case tangent: give("fwd", Flags(entries_.size(), 1)); break;
    case adjoint: give("adj", Flags(nq_, 1)); break;
    case jacobian: give("jac", flags_at(by_q_, nq_ * entries_.size())); break;
  }
  return of;
}

Operations CasadiInverse::operations(Kind kind) const {
  Operations sum = codegen::operations(masses_[kind].recording);
  const auto size = [](const std::vector<int>& numbers) { return static_cast<long>(numbers.size()); };
  const long n = static_cast<long>(nv_), nq = static_cast<long>(nq_), A = size(entries_),
             M = size(masses_[jacobian].places);
  long both = 0;  // the number of products in the products of matrices, which is also that of sums
  switch (kind) {
    case tangent: both = (size(masses_[tangent].places) + A) * n; break;
    case adjoint: both = 2 * A * n; break;
    case jacobian: both = (M + nq * A) * n; break;
  }
  sum.products += both;
  sum.sums += both;
  return sum;
}

std::size_t CasadiInverse::scratch() const {
  std::size_t t = entries_.size();
  for (const Part& part : masses_) t = std::max(t, part.places.size());
  return 3 * nv_ * nv_ + t;
}

std::string CasadiInverse::body(Kind kind, const std::string& prefix, const std::string& inverse,
                                const std::string& masses,
                                const std::function<std::string(const std::vector<int>&)>& table) const {
  constexpr std::array bodies{tangent_body, adjoint_body, jacobian_body};
  constexpr std::array arguments{"(q, fwd_q, t)", "(q, B, t)", "(q, t)"};
  const bool moves = !masses_[kind].places.empty();
  const auto places = [&](const std::vector<int>& numbers) { return numbers.empty() ? "0" : table(numbers); };
  const int nv = static_cast<int>(nv_);
  std::vector<int> upper;
  for (const int entry : entries_)
    upper.push_back(std::min(entry / nv, entry % nv) * nv + std::max(entry / nv, entry % nv));
  return filled(bodies[kind], {{"N", std::to_string(entries_.size())},
                               {"NN", std::to_string(nv_ * nv_)},
                               {"NQ", std::to_string(nq_)},
                               {"NV", std::to_string(nv_)},
                               {"N_RESULTS", std::to_string(by_q_.size())},
                               {"N_PLACES", std::to_string(masses_[kind].places.size())},
                               {"CALL", moves ? "  " + masses + arguments[kind] + ";\n" : ""},
                               {"INVERSE", inverse},
                               {"W", weights_},
                               {"ENTRIES", places(entries_)},
                               {"UPPER", places(upper)},
                               {"PLACES", places(masses_[kind].places)},
                               {"BEGIN", places(begin_)},
                               {"RESULTS", places(by_q_)},
                               {"P", prefix}});
}

std::string CasadiInverse::loops(const std::string& prefix) { return filled(shared, {{"P", prefix}}); }

}  // namespace axode::codegen
