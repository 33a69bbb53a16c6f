#pragma once
#include <variant>

#include "axode/codegen.hpp"
#include "python/bindings/support/bound_model.hpp"

namespace axode::python {

/// A Specialised that Python holds, with the model for which it was compiled.
class BoundSpecialised {
 public:
  using Any = std::variant<Specialised<double>, Specialised<float>>;
  BoundSpecialised(nb::object model, Any functions)
      : model_(std::move(model)), functions_(std::move(functions)) {}

  const nb::object& python_model() const { return model_; }
  const BoundModel& model() const { return *nb::inst_ptr<BoundModel>(model_); }
  const Any& functions() const { return functions_; }
  bool is_single() const { return functions_.index() == 1; }
  /// Throws nb::value_error unless the function is among the compiled ones.
  void check(const codegen::Function& wanted) const;

 private:
  nb::object model_;
  Any functions_;
};

}  // namespace axode::python
