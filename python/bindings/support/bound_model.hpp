#pragma once
#include <nanobind/nanobind.h>

#include <memory>
#include <vector>

#include "axode/constraints/loops.hpp"
#include "axode/kinematics/place.hpp"
#include "axode/model/model.hpp"
#include "axode/model/workspace.hpp"
#include "python/bindings/support/array.hpp"

namespace axode::python {

/// A Model that Python holds, with its workspaces (scratch memory). There are as many workspaces as threads
/// have used the model at the same time. A thread that takes or returns a workspace must hold the
/// interpreter's lock.
class BoundModel {
 public:
  explicit BoundModel(Model model) : model_(std::move(model)) {}
  BoundModel(BoundModel&&) = default;
  BoundModel(const BoundModel&) = delete;
  operator const Model&() const { return model_; }  // NOLINT(google-explicit-constructor): it is a model
  const Model* operator->() const { return &model_; }
  const Model& operator*() const { return model_; }

  template <class W> class Lease {
   public:
    explicit Lease(const BoundModel& owner) : idle_(owner.idle(static_cast<W*>(nullptr))) {
      if (idle_.empty()) {
        workspace_ = std::make_unique<W>(owner.model_);
      } else {
        workspace_ = std::move(idle_.back());
        idle_.pop_back();
      }
    }
    ~Lease() { idle_.push_back(std::move(workspace_)); }
    Lease(const Lease&) = delete;
    W& operator*() const { return *workspace_; }

   private:
    std::vector<std::unique_ptr<W>>& idle_;
    std::unique_ptr<W> workspace_;
  };

 private:
  std::vector<std::unique_ptr<Workspace<>>>& idle(Workspace<>*) const { return idle_; }
  std::vector<std::unique_ptr<LoopWorkspace<>>>& idle(LoopWorkspace<>*) const { return idle_for_loops_; }

  Model model_;
  mutable std::vector<std::unique_ptr<Workspace<>>> idle_;
  mutable std::vector<std::unique_ptr<LoopWorkspace<>>> idle_for_loops_;
};

/// A frame given by its name or its number, annotated in Python as `str | int`.
struct FrameName {
  PyObject* given = nullptr;
  /// The index of the frame. Throws nb::key_error for an unknown name, nb::value_error for anything else.
  int in(const Model& model, const char* argument = "frame") const;
};

/// Returns a Place (a frame on a body): the given frame, displaced in it by `offset`, a pose (4, 4) or the
/// position (3,) of the origin, unless `offset` is None.
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
