#pragma once
#include <nanobind/nanobind.h>

#include <memory>
#include <vector>

#include "array.hpp"
#include "axode/kinematics/place.hpp"
#include "axode/model/model.hpp"
#include "axode/model/workspace.hpp"

namespace axode::python {

/// A Model as Python holds it, with scratch memory for as many threads as have used it at once. Whoever takes
/// or returns a workspace holds the interpreter's lock.
class BoundModel {
 public:
  explicit BoundModel(Model model) : model_(std::move(model)) {}
  BoundModel(BoundModel&&) = default;
  BoundModel(const BoundModel&) = delete;
  operator const Model&() const { return model_; }  // NOLINT(google-explicit-constructor): it is one
  const Model* operator->() const { return &model_; }
  const Model& operator*() const { return model_; }

  class Lease {
   public:
    explicit Lease(const BoundModel& owner) : owner_(owner) {
      if (owner.idle_.empty()) {
        workspace_ = std::make_unique<Workspace<>>(owner.model_);
      } else {
        workspace_ = std::move(owner.idle_.back());
        owner.idle_.pop_back();
      }
    }
    ~Lease() { owner_.idle_.push_back(std::move(workspace_)); }
    Lease(const Lease&) = delete;
    Workspace<>& operator*() const { return *workspace_; }

   private:
    const BoundModel& owner_;
    std::unique_ptr<Workspace<>> workspace_;
  };

 private:
  Model model_;
  mutable std::vector<std::unique_ptr<Workspace<>>> idle_;
};

/// A frame by its name or its number, annotated in Python as `str | int`.
struct FrameName {
  PyObject* given = nullptr;
  /// Throws nb::key_error for an unknown name, nb::value_error for an unknown number or another type.
  int in(const Model& model, const char* argument = "frame") const;
};

/// A frame, or a point (3,) or pose (4, 4) given in it.
Place<> place(const Model& model, FrameName frame, ArrayLike offset, const char* argument = "frame");

}  // namespace axode::python

namespace nanobind::detail {

template <> struct type_caster<axode::python::FrameName> {
  NB_TYPE_CASTER(axode::python::FrameName, const_name("str | int"))
  bool from_python(handle source, uint32_t, cleanup_list*) noexcept {
    value.given = source.ptr();
    return true;
  }
};

}  // namespace nanobind::detail
