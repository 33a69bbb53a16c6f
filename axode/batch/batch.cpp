#include "axode/batch.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "axode/batch/kernels.hpp"
#include "axode/batch/portions.hpp"
#include "axode/batch/scratch.hpp"
#include "axode/batch/states_of_row.hpp"
#include "axode/table/check_counts.hpp"

namespace axode::batch {
namespace {

/// Calls a kernel, a function for as many states as a SIMD register has lanes, on groups of that many states.
/// A smaller group is filled with its last state.
template <class S> class LaneCall {
 public:
  LaneCall(StatesOfRow<S>& states, const LaneKernel<S>& kernel)
      : states_(states),
        kernel_(kernel),
        tree_(states.model().template tree<S>()),
        bytes_(kernel.bytes(tree_)),
        memory_(scratch<std::byte>(bytes_)) {}

  void operator()(std::size_t first, std::size_t count) {
    catalog::Read<S> given;
    for (const catalog::Input input : states_.row().numbers()) given[input] = argument(input, first, count);
    const std::size_t n = states_.size();
    if (count < lanes()) results_.resize(n * lanes());
    S* const out = count < lanes() ? results_.data() : states_.result(first, count).data();
    const unsigned singular_lanes =
        kernel_.call(tree_, Arena(*tree_.topology(), memory_.get(), bytes_), given, out);
    if (count < lanes()) std::copy_n(out, n * count, states_.result(first, count).data());
    if (unsigned char* const verdicts = states_.verdicts(first); verdicts != nullptr)
      for (std::size_t l = 0; l < count; ++l)
        verdicts[l] = static_cast<unsigned char>(singular_lanes >> l & 1);
  }
  static std::size_t lanes() { return kernels<S>().lanes; }

 private:
  const S* argument(catalog::Input input, std::size_t first, std::size_t count) {
    const std::span<const S> numbers = states_.argument(input, first, count);
    if (count == lanes()) return numbers.data();
    std::vector<S>& copy = copies_[static_cast<std::size_t>(input)];
    const std::size_t n = states_.length(input);
    copy.resize(n * lanes());
    for (std::size_t l = 0; l < lanes(); ++l)
      std::copy_n(numbers.data() + std::min(l, count - 1) * n, n, copy.data() + l * n);
    return copy.data();
  }

  StatesOfRow<S>& states_;
  LaneKernel<S> kernel_;
  const Tree<S>& tree_;
  std::size_t bytes_;
  std::shared_ptr<std::byte> memory_;
  std::array<std::vector<S>, catalog::inputs_of_numbers.size()> copies_;
  std::vector<S> results_;
};

bool coupled(const Model& model) { return !model.tree<double>()->coupled_bodies.empty(); }

}  // namespace

template <class S>
Outcome run(const Model& model, catalog::Id function,
            const catalog::Arguments<std::type_identity_t<S>>& given, std::type_identity_t<std::span<S>> out,
            int threads, const Monitor& monitor) {
  const catalog::Words& words = function.words();
  if (!words.lanes)
    throw std::invalid_argument(std::string(words.name) +
                                " has no kernel for states in lanes; call it state by state");
  catalog::check_counts(words, model, catalog::Caller::workspace);
  if (!given.loads.wrenches.empty() || given.loads.joint_losses)
    throw std::invalid_argument("loads: functions of states in lanes take no loads and no joint losses");
  StatesOfRow<S> states(model, *catalog::find<Fast, S>(words.name), given, out, threads);
  const std::size_t N = states.count();
  if (states.size() == 0) return {.done = N};
  const LaneKernel<S>& kernel = kernels<S>().rows[function.index];
  const bool in_lanes = kernel.takes_coupled_joints || !coupled(model);
  return states.outcome(in_portions(N, in_lanes ? LaneCall<S>::lanes() : 1, threads, monitor, [&]() -> Work {
    auto call = in_lanes ? std::make_shared<LaneCall<S>>(states, kernel) : nullptr;
    return
        [&, call, workspace = std::optional<Workspace<S>>()](std::size_t first, std::size_t count) mutable {
          if (call) {
            (*call)(first, count);
          } else if (words.may_fail) {
            std::fill_n(states.verdicts(first), count, StatesOfRow<S>::maybe_singular);
          } else {
            if (!workspace) workspace.emplace(model);
            for (std::size_t k = first; k < first + count; ++k)
              static_cast<void>(states.call_one(*workspace, k));
          }
          states.settle(workspace, first, count);
        };
  }));
}
template decltype(run<double>) run<double>;
template decltype(run<float>) run<float>;

const char* instruction_set() { return axode::instruction_set(); }

}  // namespace axode::batch
