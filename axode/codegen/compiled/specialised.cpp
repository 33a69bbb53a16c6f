#include "axode/codegen/compiled/specialised.hpp"

#include <algorithm>
#include <optional>

#include "axode/batch/portions.hpp"
#include "axode/batch/scratch.hpp"
#include "axode/batch/states_of_row.hpp"
#include "axode/codegen/c/states_source.hpp"
#include "axode/codegen/compiled/machine_code.hpp"

namespace axode {
namespace {

using codegen::Function;
bool same(const Function& a, const Function& b) {
  return a.row == b.row &&
         (!a.is_of_a_frame() || (a.frame == b.frame && a.representation == b.representation));
}

}  // namespace

/// The loaded library of compiled code and its functions.
template <class T> struct Specialised<T>::Code {
  struct Entry {
    Function function;
    const catalog::Function<T>* row;
    void (*call)(long count, const T* const* arguments, T* result, T* scratch, unsigned char* maybe_singular);
    std::size_t scratch;  ///< length (in numbers) of the argument `scratch` of call()
  };
  codegen::MachineCode library;
  std::vector<Entry> entries;

  Code(const codegen::Source& source, std::span<const Function> functions, const SpecialisedOptions& options)
      : library(source.text, options.flags, options.monitor) {
    for (std::size_t k = 0; k < functions.size(); ++k) {
      const std::string& symbol = source.functions[k].name;
      const std::string_view name = functions[k].name();
      Entry entry{.function = functions[k], .row = catalog::find<Fast, T>(name)};
      if (entry.row == nullptr) entry.row = catalog::find<BodyFixed, T>(name);
      entry.call = reinterpret_cast<decltype(entry.call)>(library.address(symbol + "_states"));
      entry.scratch =
          static_cast<std::size_t>(*static_cast<const long*>(library.address(symbol + "_scratch")));
      entries.push_back(std::move(entry));
    }
  }

  const Entry& entry(const Model& model, const Function& wanted) const {
    const auto found =
        std::ranges::find_if(entries, [&](const Entry& each) { return same(each.function, wanted); });
    if (found == entries.end())
      throw std::invalid_argument("model \"" + model.name() + "\" was specialised without " +
                                  std::string(wanted.name()) +
                                  (wanted.is_of_a_frame() ? " of that frame in that representation" : ""));
    return *found;
  }
};

/// Calls a compiled function for several states, with scratch memory of its own, for one thread.
template <class T> class Specialised<T>::Call {
 public:
  Call(batch::StatesOfRow<T>& states, const typename Code::Entry& entry)
      : states_(states),
        entry_(entry),
        scratch_(states.count() > 1 ? batch::scratch<T>(entry.scratch) : nullptr) {}

  void operator()(std::size_t first, std::size_t states) {
    std::array<const T*, catalog::inputs_of_numbers.size()> at{};
    std::size_t n = 0;
    for (const catalog::Input input : entry_.row->numbers())
      at[n++] = states_.argument(input, first, states).data();
    unsigned char unused = 0;
    unsigned char* const verdicts = states_.verdicts(first);
    entry_.call(static_cast<long>(states), at.data(), states_.result(first, states).data(), scratch_.get(),
                verdicts != nullptr ? verdicts : &unused);
    states_.settle(workspace_, first, states);
  }

 private:
  batch::StatesOfRow<T>& states_;
  const typename Code::Entry& entry_;
  std::shared_ptr<T> scratch_;
  std::optional<Workspace<T>> workspace_;
};

template <class T>
Specialised<T>::Specialised(const Model& model, std::span<const Function> functions,
                            SpecialisedOptions options)
    : model_(model) {
  constexpr std::array widths{1, 2, 4, 8, 16};
  if (std::ranges::find(widths, options.lanes) == widths.end())
    throw std::invalid_argument("lanes is " + std::to_string(options.lanes) + "; expected 1, 2, 4, 8 or 16");
  if (std::ranges::any_of(functions, [](const Function& f) { return f.is("pose"); }))
    throw std::invalid_argument(
        "functions: a specialised model cannot have pose; poses has the poses of all frames");
  code_ = std::make_shared<const Code>(
      codegen::states_source(model, functions, std::same_as<T, float>, options.lanes), functions, options);
}

template <class T> batch::CompiledDynamics<T> Specialised<T>::compiled_dynamics() const {
  const auto& entry = code_->entry(model_, {"forward_dynamics"});
  return {entry.call, entry.scratch};
}

template <class T> bool Specialised<T>::has(const Function& function) const {
  return std::ranges::any_of(code_->entries, [&](const auto& each) { return same(each.function, function); });
}

template <class T>
batch::Outcome Specialised<T>::run(const Function& function, const catalog::Arguments<T>& given,
                                   std::span<T> out, int threads, const batch::Monitor& monitor) const {
  const std::size_t group = threads > 1 ? 16 : 64;  // fills registers, and leaves work for all threads
  const auto& entry = code_->entry(model_, function);
  if (!given.loads.wrenches.empty() || given.loads.joint_losses)
    throw std::invalid_argument("loads: specialised functions take no loads and no joint losses");
  batch::StatesOfRow<T> states(model_, *entry.row, given, out, threads);
  const std::size_t N = states.count();
  if (out.empty()) return {.done = N};
  if (N <= group) {
    Call(states, entry)(0, N);
    return states.outcome(N);
  }
  return states.outcome(batch::in_portions(N, group, threads, monitor, [&]() -> batch::Work {
    return [call = std::make_shared<Call>(states, entry)](std::size_t first, std::size_t n) {
      (*call)(first, n);
    };
  }));
}

template class Specialised<double>;
template class Specialised<float>;

}  // namespace axode
